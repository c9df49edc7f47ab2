#include "skinning/blend/limb_chains.h"

#include <array>

#include "kinematics/motion/joint_matching.h"

namespace gelenk {
namespace {

struct KnownChain {
  bool arm, left;
  std::array<const char*, 3> parts;
  std::array<const char*, 3> pinocchio;
};
constexpr KnownChain known[] = {{true, true, {"upperarm", "lowerarm", "hand"}, {"15", "16", "17"}},
                                {true, false, {"upperarm", "lowerarm", "hand"}, {"12", "13", "14"}},
                                {false, true, {"thigh", "calf", "foot"}, {"8", "9", "10"}},
                                {false, false, {"thigh", "calf", "foot"}, {"4", "5", "6"}}};

std::optional<int> jointOf(const std::vector<PlainName>& names, const char* part, bool left) {
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i].part == part && names[i].side == (left ? Side::Left : Side::Right))
      return static_cast<int>(i);
  return std::nullopt;
}

}  // namespace

std::vector<LimbChain> limbChains(const Skeleton& skeleton) {
  const std::vector<PlainName> names = plainNames(skeleton);
  const bool numbered = skeleton.jointCount() == 18 && skeleton.findJoint("17");  // Pinocchio's human
  std::vector<LimbChain> chains;
  for (const KnownChain& row : known) {
    LimbChain chain{.arm = row.arm, .left = row.left, .joints = {}};
    for (int k = 0; k < 3; ++k) {
      const auto joint =
          numbered ? skeleton.findJoint(row.pinocchio[k]) : jointOf(names, row.parts[k], row.left);
      if (!joint || (k > 0 && !skeleton.isAncestor(chain.joints.back(), *joint))) break;
      chain.joints.push_back(*joint);
    }
    if (chain.joints.size() == 3) chains.push_back(std::move(chain));
  }
  return chains;
}

}  // namespace gelenk
