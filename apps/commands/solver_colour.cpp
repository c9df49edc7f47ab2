#include "apps/commands/solver_colour.h"

#include <array>

#include "solvers/problem/ik_solver.h"

namespace gelenk {

namespace {

Eigen::Vector3f fromHex(unsigned rgb) {
  return Eigen::Vector3f(static_cast<float>(rgb >> 16), static_cast<float>(rgb >> 8 & 255),
                         static_cast<float>(rgb & 255)) /
         255.0f;
}

}  // namespace

Eigen::Vector3f solverColour(std::string_view solver) {
  static constexpr std::array<unsigned, 17> palette{
      0xd55e00, 0x009e73, 0xe69f00, 0xcc79a7, 0x56b4e9,
      0x7d6e1f,  // Okabe, Ito: vermilion, bluish green, orange, reddish purple, sky blue;
                 // olive in place of their pale yellow
      0x8a0068, 0x4fc52e, 0x2a35d8, 0xd01168, 0x8ad09c, 0x9b30e0, 0x8f2a0a, 0x8f86ee, 0x0b6558, 0xe860dc,
      0x5b2a9d};
  std::size_t index = 0;
  for (const SolverEntry& entry : solverCatalogue()) {
    if (entry.name == "drag") continue;
    if (entry.name == solver.substr(0, solver.find('['))) return fromHex(palette[index % palette.size()]);
    ++index;
  }
  return fromHex(0x0072b2);  // blue
}

}  // namespace gelenk
