#pragma once

#include <array>
#include <string>
#include <utility>

namespace gelenk {

/// Further files that one file needs, empty where not given.
struct Companions {
  std::string skeleton = {}, weights = {};  ///< of an OBJ
  std::string asf = {};                     ///< of an AMC, or to lay a fitted skeleton on
  std::string amc = {};
  std::string mapping = {};  ///< BonePath lines; default: CMU's bones on Pinocchio's human
  std::string figure = {};   ///< of a tutorial pose
  std::string clip = {};     ///< which motion of a file that names several; default: the first
  std::string up = {};       ///< y or z where a format does not say it; default: along which the body stands
  bool operator==(const Companions&) const = default;
};

/// As scenes and options (--skeleton, ...) name them.
inline constexpr std::array<std::pair<std::string Companions::*, const char*>, 8> companionNames{
    {{&Companions::skeleton, "skeleton"},
     {&Companions::weights, "weights"},
     {&Companions::asf, "asf"},
     {&Companions::amc, "amc"},
     {&Companions::mapping, "mapping"},
     {&Companions::clip, "clip"},
     {&Companions::up, "up"},
     {&Companions::figure, "figure"}}};

/// What a model is opened from: a built-in model or a file, and what belongs to it.
struct ModelReference {
  std::string nameOrFile = "figure";
  Companions files = {};
  bool operator==(const ModelReference&) const = default;
};

}  // namespace gelenk
