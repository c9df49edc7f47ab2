#include <Eigen/Geometry>
#include <algorithm>

#include "skinning/bodies/polygonise.h"
#include "skinning/rigging/bone_heat.h"
#include "skinning/rigging/fit/template_body.h"
#include "skinning/skin.h"

namespace gelenk {

using Eigen::Vector3d;

namespace {

/// A joint of a four-legged animal of length 1 from nose to tail: z from the tail to the nose, y from the
/// ground up. Each joint but an end begins a piece that reaches to `to`, as a round cone of the two radii.
struct JointRow {
  const char *name, *parent;
  double x, y, z;
  const char* to = "";
  double radiusFrom = 0.0, radiusTo = 0.0;
  double bond = 0.0;
};

/// Horses, cattle, deer: straight forelegs, of which figures in drawings bend at the carpus.
constexpr JointRow hoofed[] = {
    {"pelvis", "", 0.0, 0.42, 0.22, "spine", 0.095, 0.10, 0.1},
    {"spine", "pelvis", 0.0, 0.40, 0.42, "withers", 0.10, 0.11, 0.2},
    {"withers", "spine", 0.0, 0.41, 0.64},
    {"fshoulder_l", "spine", 0.070, 0.349, 0.636, "felbow_l", 0.055, 0.032, 0.1},
    {"felbow_l", "fshoulder_l", 0.074, 0.178, 0.65, "fankle_l", 0.030, 0.022},
    {"fankle_l", "felbow_l", 0.075, 0.055, 0.635, "ffoot_l", 0.022, 0.022, 0.2},
    {"ffoot_l", "fankle_l", 0.075, 0.022, 0.655},
    {"neck", "spine", 0.0, 0.44, 0.68, "head", 0.075, 0.055, 0.1},
    {"head", "neck", 0.0, 0.58, 0.835, "nose", 0.055, 0.032, 0.1},
    {"nose", "head", 0.0, 0.50, 0.965},
    {"tail_root", "pelvis", 0.0, 0.45, 0.145, "tail", 0.020, 0.015, 0.05},
    {"tail", "tail_root", 0.0, 0.28, 0.045},
    {"hip_l", "pelvis", 0.072, 0.42, 0.22, "knee_l", 0.080, 0.042, 0.1},
    {"knee_l", "hip_l", 0.074, 0.298, 0.274, "hock_l", 0.041, 0.026},
    {"hock_l", "knee_l", 0.073, 0.19, 0.125, "hankle_l", 0.024, 0.021},
    {"hankle_l", "hock_l", 0.073, 0.055, 0.14, "hfoot_l", 0.021, 0.022, 0.2},
    {"hfoot_l", "hankle_l", 0.073, 0.022, 0.16},
};

/// Cattle and other heavy bodies on short legs.
constexpr JointRow cattle[] = {
    {"pelvis", "", 0.0, 0.41, 0.13, "spine", 0.135, 0.15, 0.1},
    {"spine", "pelvis", 0.0, 0.395, 0.36, "withers", 0.15, 0.15, 0.2},
    {"withers", "spine", 0.0, 0.40, 0.61},
    {"fshoulder_l", "spine", 0.075, 0.325, 0.605, "felbow_l", 0.065, 0.036, 0.1},
    {"felbow_l", "fshoulder_l", 0.076, 0.148, 0.627, "fankle_l", 0.034, 0.024},
    {"fankle_l", "felbow_l", 0.076, 0.055, 0.605, "ffoot_l", 0.024, 0.024, 0.2},
    {"ffoot_l", "fankle_l", 0.076, 0.024, 0.62},
    {"neck", "spine", 0.0, 0.42, 0.66, "head", 0.10, 0.07, 0.1},
    {"head", "neck", 0.0, 0.48, 0.86, "nose", 0.065, 0.04, 0.1},
    {"nose", "head", 0.0, 0.40, 0.96},
    {"tail_root", "pelvis", 0.0, 0.50, 0.05, "tail", 0.020, 0.015, 0.05},
    {"tail", "tail_root", 0.0, 0.28, 0.01},
    {"hip_l", "pelvis", 0.078, 0.385, 0.118, "knee_l", 0.09, 0.055, 0.1},
    {"knee_l", "hip_l", 0.076, 0.257, 0.168, "hock_l", 0.05, 0.028},
    {"hock_l", "knee_l", 0.073, 0.155, 0.067, "hankle_l", 0.026, 0.022},
    {"hankle_l", "hock_l", 0.071, 0.055, 0.074, "hfoot_l", 0.022, 0.024, 0.2},
    {"hfoot_l", "hankle_l", 0.071, 0.024, 0.09},
};

/// Dogs, foxes, cats: elbows close under the chest, hind legs well bent, long feet.
constexpr JointRow pawed[] = {
    {"pelvis", "", 0.0, 0.415, 0.22, "spine", 0.101, 0.096, 0.1},
    {"spine", "pelvis", 0.0, 0.40, 0.42, "withers", 0.095, 0.11, 0.2},
    {"withers", "spine", 0.0, 0.41, 0.64},
    {"fshoulder_l", "spine", 0.083, 0.346, 0.615, "felbow_l", 0.055, 0.038, 0.1},
    {"felbow_l", "fshoulder_l", 0.087, 0.260, 0.592, "fankle_l", 0.034, 0.022},
    {"fankle_l", "felbow_l", 0.087, 0.055, 0.66, "ffoot_l", 0.024, 0.024, 0.2},
    {"ffoot_l", "fankle_l", 0.087, 0.024, 0.69},
    {"neck", "spine", 0.0, 0.46, 0.70, "head", 0.075, 0.060, 0.1},
    {"head", "neck", 0.0, 0.60, 0.82, "nose", 0.060, 0.030, 0.1},
    {"nose", "head", 0.0, 0.55, 0.965},
    {"tail_root", "pelvis", 0.0, 0.45, 0.145, "tail", 0.025, 0.035, 0.05},
    {"tail", "tail_root", 0.0, 0.33, 0.03},
    {"hip_l", "pelvis", 0.094, 0.398, 0.235, "knee_l", 0.068, 0.045, 0.1},
    {"knee_l", "hip_l", 0.096, 0.285, 0.308, "hock_l", 0.042, 0.026},
    {"hock_l", "knee_l", 0.092, 0.168, 0.07, "hankle_l", 0.024, 0.021},
    {"hankle_l", "hock_l", 0.090, 0.050, 0.11, "hfoot_l", 0.022, 0.024, 0.2},
    {"hfoot_l", "hankle_l", 0.090, 0.024, 0.145},
};

bool sided(const std::string& name) { return name.ends_with("_l"); }
std::string otherSide(std::string name) {
  if (sided(name)) name.back() = 'r';
  return name;
}

TemplateBody makeQuadruped(std::span<const JointRow> rows) {
  TemplateBody body;
  body.fourLegged = true;
  body.variety = 0.12;
  std::vector<BodyPart> parts;
  const auto joint = [&](const std::string& name) {
    for (std::size_t k = 0; k < body.joints.size(); ++k)
      if (body.joints[k].name == name) return static_cast<int>(k);
    return -1;
  };
  const auto rowOf = [&](const std::string& name) -> const JointRow& {
    return *std::find_if(rows.begin(), rows.end(), [&](const JointRow& row) { return name == row.name; });
  };
  std::vector<int> pieceOfJoint;
  for (const JointRow& row : rows)
    for (const bool right : {false, true}) {
      if (right && !sided(row.name)) break;
      const double side = right ? -1.0 : 1.0;
      const Vector3d at(side * row.x, row.y, row.z);
      const std::string name = right ? otherSide(row.name) : row.name;
      const int parent = joint(right ? otherSide(row.parent) : row.parent);
      int piece = parent < 0 ? 0 : body.joints[parent].piece;
      if (*row.to) {
        const JointRow& end = rowOf(row.to);
        piece = static_cast<int>(body.pieces.size());
        body.pieces.push_back({.name = name,
                               .parent = parent < 0 ? -1 : body.joints[parent].piece,
                               .partner = piece + (!sided(row.name) ? 0
                                                   : right          ? -1
                                                                    : 1),
                               .from = at,
                               .to = {side * end.x, end.y, end.z},
                               .bond = row.bond});
        parts.push_back({.form = BodyPart::Form::RoundCone,
                         .parent = body.pieces.back().parent,
                         .blend = 0.5 * row.radiusFrom,
                         .a = at,
                         .b = body.pieces.back().to,
                         .radiusA = row.radiusFrom,
                         .radiusB = row.radiusTo});
      }
      const int index = static_cast<int>(body.joints.size());
      body.joints.push_back({.name = name,
                             .parent = parent,
                             .partner = index + (!sided(row.name) ? 0
                                                 : right          ? -1
                                                                  : 1),
                             .piece = piece,
                             .position = at});
    }
  body.surface = polygonise(BodyShape(parts), {.cell = 0.018, .symmetric = true});
  for (const char* side : {"l", "r"}) {
    const int upper = body.piece(std::string("fshoulder_") + side),
              lower = body.piece(std::string("felbow_") + side);
    body.pieces[upper].mate = lower;
    body.pieces[lower].mate = upper;
  }
  for (const char* foot : {"fankle_l", "fankle_r", "hankle_l", "hankle_r"})
    body.pieces[body.piece(foot)].stands = true;
  body.pieces[body.piece("tail_root")].trails = true;

  std::vector<Bone> bones;
  for (std::size_t k = 0; k < body.pieces.size(); ++k)
    bones.push_back({static_cast<int>(k), body.pieces[k].from, body.pieces[k].to});
  const SparseWeights heat = boneHeatWeights(body.surface, bones, {.strength = 8.0, .voxels = 120});
  for (const Influences& row : fourLargest(heat, static_cast<int>(body.pieces.size()))) {
    std::array<std::pair<int, double>, 4> kept;
    for (int k = 0; k < 4; ++k) kept[k] = {row.joints[k], row.weights[k]};
    body.weights.push_back(kept);
    body.importance.push_back(1.0);
  }

  body.poses.push_back({"standing", restMaps(body)});
  PieceMaps low = restMaps(body), high = restMaps(body);
  aim(body, low, "neck", {0.0, 0.15, 1.0});
  aim(body, low, "head", {0.0, -0.5, 1.0});
  body.poses.push_back({"head low", low});
  aim(body, high, "neck", {0.0, 1.0, 0.5});
  aim(body, high, "head", {0.0, -0.4, 1.0});
  body.poses.push_back({"head high", high});
  return body;
}

}  // namespace

const TemplateBody& hoofedTemplate() {
  static const TemplateBody body = makeQuadruped(hoofed);
  return body;
}

const TemplateBody& cattleTemplate() {
  static const TemplateBody body = makeQuadruped(cattle);
  return body;
}

const TemplateBody& pawedTemplate() {
  static const TemplateBody body = makeQuadruped(pawed);
  return body;
}

}  // namespace gelenk
