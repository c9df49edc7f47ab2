#pragma once

#include <span>
#include <string_view>

#include "kinematics/notation/dh_table.h"

namespace gelenk {

/// A robot known by name.
struct Robot {
  std::string_view name;
  std::string_view title;
  DhTable (*table)();
};

/// puma560, ur5, panda, iiwa14, scara: an explicit table. Lecture 10.2.
std::span<const Robot> robots();

/// Throws std::invalid_argument that lists the names there are.
DhTable robotTable(std::string_view name);

}  // namespace gelenk
