#include "kinematics/motion/joint_matching.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <optional>
#include <set>
#include <string_view>

namespace gelenk {
namespace {

/// Names of one part, the first of a row stands for all. A joint is the part that begins there.
constexpr std::array synonyms{
    std::array<std::string_view, 8>{"pelvis", "hips", "hip"},
    std::array<std::string_view, 8>{"chest", "thorax"},
    std::array<std::string_view, 8>{"neck", "neck1", "lowerneck"},
    std::array<std::string_view, 8>{"clavicle", "collar", "collarbone"},
    std::array<std::string_view, 8>{"upperarm", "uparm", "humerus", "arm", "upperarm1"},
    std::array<std::string_view, 8>{"lowerarm", "loarm", "forearm", "radius", "elbow", "lowerarm1"},
    std::array<std::string_view, 8>{"thigh", "upleg", "upperleg", "femur", "upperleg1"},
    std::array<std::string_view, 8>{"calf", "loleg", "lowerleg", "tibia", "shin", "knee", "leg", "lowerleg1"},
    std::array<std::string_view, 8>{"foot", "ankle"},
    std::array<std::string_view, 8>{"ball", "toe", "toes", "toebase"},
};

char lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }
bool isLetter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }
bool isDigit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }
bool isUpper(char c) { return std::isupper(static_cast<unsigned char>(c)) != 0; }

/// Lower-case words: split at what is neither letter nor digit, before a capital after a small letter, and
/// between letters and digits.
std::vector<std::string> wordsOf(std::string_view name) {
  if (const auto at = name.find_last_of(":|"); at != std::string_view::npos && at + 1 < name.size())
    name.remove_prefix(at + 1);
  std::vector<std::string> words;
  char before = '\0';
  for (const char c : name) {
    const bool inWord = isLetter(c) || isDigit(c);
    const bool begins = !(isLetter(before) || isDigit(before)) || isDigit(c) != isDigit(before) ||
                        (isUpper(c) && !isUpper(before));
    if (inWord && begins) words.emplace_back();
    if (inWord) words.back() += lower(c);
    before = c;
  }
  for (std::string& word : words) {
    const std::size_t zeros = std::min(word.find_first_not_of('0'), word.size() - 1);
    if (isDigit(word[0])) word.erase(0, zeros);
  }
  return words;
}

std::optional<Side> sideOf(const std::string& word) {
  if (word == "left" || word == "l") return Side::Left;
  if (word == "right" || word == "r") return Side::Right;
  return std::nullopt;
}

PlainName withoutSide(const std::vector<std::string>& words) {
  PlainName name;
  for (const std::string& word : words) {
    const auto side = sideOf(word);
    if (side && name.side == Side::Middle)
      name.side = *side;
    else
      name.part += word;
  }
  return name;
}

/// What all names but the root's begin with, up to a separator, if that is no side and leaves a part of the
/// body in every name.
std::string_view sharedPrefix(const Skeleton& skeleton) {
  if (skeleton.jointCount() < 3) return {};
  const std::string_view first = skeleton.joint(1).name;
  const std::size_t separator = first.find_first_of(" _-.");
  if (separator == std::string_view::npos || sideOf(wordsOf(first)[0])) return {};
  const std::string_view prefix = first.substr(0, separator + 1);
  const auto has = [&](const Joint& joint) {
    const std::string_view name = joint.name;
    return name.starts_with(prefix) && !withoutSide(wordsOf(name.substr(prefix.size()))).part.empty();
  };
  return separator > 0 && std::all_of(skeleton.joints().begin() + 1, skeleton.joints().end(), has)
             ? prefix
             : std::string_view{};
}

/// "lfemur" and "rfemur" are the two sides of "femur".
void splitLeadingSides(std::vector<PlainName>& names) {
  std::set<std::string> parts;
  for (const PlainName& name : names)
    if (name.side == Side::Middle) parts.insert(name.part);
  for (PlainName& name : names) {
    if (name.side != Side::Middle || name.part.size() < 2 || (name.part[0] != 'l' && name.part[0] != 'r'))
      continue;
    const bool left = name.part[0] == 'l';
    if (parts.count((left ? "r" : "l") + name.part.substr(1)))
      name = {name.part.substr(1), left ? Side::Left : Side::Right};
  }
}

void mergeSynonyms(std::vector<PlainName>& names) {
  for (PlainName& name : names) {
    if (name.side != Side::Middle && name.part == "hip") name.part = "thigh";
    for (const auto& row : synonyms)
      if (std::find(row.begin(), row.end(), name.part) != row.end()) name.part = row[0];
  }
  // Some rigs call the collar bone shoulder, others the upper arm; a wrist is the hand where there is no
  // hand, a root the pelvis where there is no pelvis (CMU).
  const auto has = [&](std::string_view part) {
    return std::any_of(names.begin(), names.end(), [&](const PlainName& name) { return name.part == part; });
  };
  const std::string shoulder = has("upperarm") ? "clavicle" : "upperarm",
                    wrist = has("hand") ? "wrist" : "hand", root = has("pelvis") ? "root" : "pelvis";
  for (PlainName& name : names)
    if (name.part == "shoulder")
      name.part = shoulder;
    else if (name.part == "wrist")
      name.part = wrist;
    else if (name.part == "root")
      name.part = root;
}

using Key = std::pair<std::string, Side>;

/// Plain name -> the joint that it means; joints that are taken are passed over.
std::map<Key, int> jointsByName(const Skeleton& skeleton, const std::vector<bool>& taken) {
  const auto names = plainNames(skeleton);
  std::map<Key, std::vector<int>> candidates;
  for (int i = 0; i < skeleton.jointCount(); ++i)
    if (!taken[i] && !names[i].part.empty()) candidates[{names[i].part, names[i].side}].push_back(i);
  std::map<Key, int> joints;
  for (const auto& [name, list] : candidates) {
    const auto length = [&](int i) { return skeleton.joint(i).name.size(); };
    const int shortest =
        *std::min_element(list.begin(), list.end(), [&](int a, int b) { return length(a) < length(b); });
    if (std::count_if(list.begin(), list.end(), [&](int i) { return length(i) == length(shortest); }) == 1)
      joints[name] = shortest;
  }
  return joints;
}

std::vector<std::string> unmatched(const Skeleton& skeleton, const std::vector<bool>& taken) {
  std::vector<std::string> names;
  for (int i = 0; i < skeleton.jointCount(); ++i)
    if (!taken[i] && (skeleton.qCount(i) > 0 || !skeleton.children(i).empty()))
      names.push_back(skeleton.joint(i).name);
  return names;
}

}  // namespace

std::vector<PlainName> plainNames(const Skeleton& skeleton) {
  const std::string_view prefix = sharedPrefix(skeleton);
  std::vector<PlainName> names;
  for (const Joint& joint : skeleton.joints()) {
    const std::string_view name = joint.name;
    names.push_back(withoutSide(wordsOf(name.starts_with(prefix) ? name.substr(prefix.size()) : name)));
  }
  splitLeadingSides(names);
  mergeSynonyms(names);
  return names;
}

JointMatching matchJoints(const Skeleton& source, const Skeleton& target) {
  std::vector<bool> sourceTaken(source.jointCount(), false), targetTaken(target.jointCount(), false);
  std::vector<JointMatch> found;
  const auto pair = [&](int s, int t) {
    for (const JointMatch& other : found)
      if ((source.isAncestor(s, other.source) && target.isAncestor(other.target, t)) ||
          (source.isAncestor(other.source, s) && target.isAncestor(t, other.target)))
        return;
    found.push_back({s, t});
    sourceTaken[s] = targetTaken[t] = true;
  };
  for (int t = 0; t < target.jointCount(); ++t)
    if (const auto s = source.findJoint(target.joint(t).name)) pair(*s, t);
  const auto inSource = jointsByName(source, sourceTaken);
  for (const auto& [name, t] : jointsByName(target, targetTaken))
    if (const auto s = inSource.find(name); s != inSource.end()) pair(s->second, t);
  std::sort(found.begin(), found.end(),
            [](const JointMatch& a, const JointMatch& b) { return a.target < b.target; });
  return {found, unmatched(source, sourceTaken), unmatched(target, targetTaken)};
}

}  // namespace gelenk
