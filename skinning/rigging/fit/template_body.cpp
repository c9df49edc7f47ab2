#include "skinning/rigging/fit/template_body.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <stdexcept>
#include <tuple>

#include "kinematics/notation/mannequin.h"
#include "kinematics/symmetry.h"
#include "skinning/bodies/mannequin_body.h"
#include "skinning/rigging/bone_heat.h"

namespace gelenk {

using Eigen::Vector3d;

namespace {

/// A piece reaches from one joint of the figure to another.
struct PieceRow {
  const char *name, *parent, *from, *to, *mate = "";
  double stiffness = 1.0, bond = 0.0;
};

constexpr PieceRow humanPieces[] = {
    {"pelvis", "", "pelvis", "spine_02"},
    {"chest", "pelvis", "spine_02", "neck_01", "", 1.0, 0.1},
    {"neck", "chest", "neck_01", "head", "", 1.0, 0.2},
    {"head", "neck", "head", "head_end", "", 1.0, 0.1},
    {"clavicle", "chest", "clavicle", "upperarm", "", 1.0, 0.1},
    {"upperarm", "clavicle", "upperarm", "lowerarm", "lowerarm"},
    {"lowerarm", "upperarm", "lowerarm", "hand", "upperarm"},
    {"hand", "lowerarm", "hand", "middle_end", "", 1.0, 0.1},
    {"thigh", "pelvis", "thigh", "calf", "calf"},
    {"calf", "thigh", "calf", "foot", "thigh"},
    {"foot", "calf", "foot", "ball"},
    {"toes", "foot", "ball", "toe_end", "", 1.0, 0.5},
};

/// The template with pieces of other sizes, joined as they were.
template <class Size>
PieceMaps resized(const TemplateBody& body, Size size) {
  PieceMaps maps = restMaps(body);
  for (std::size_t k = 0; k < maps.size(); ++k) {
    const BodyPiece& piece = body.pieces[k];
    maps[k].linear = size(piece.name) * Eigen::Matrix3d::Identity();
    if (piece.parent < 0) continue;
    const PieceMap& parent = maps[piece.parent];
    maps[k].origin = parent.origin + parent.linear * (piece.from - body.pieces[piece.parent].from);
  }
  return maps;
}

bool isMiddle(const Skeleton& skeleton, const std::string& name) {
  return skeleton.findJoint(name).has_value();
}

TemplateBody makeHuman() {
  TemplateBody body;
  const Skeleton figure = mannequin();
  const Frames rest = restFrames(figure);
  PolygoniseOptions grid{.cell = 0.03, .symmetric = true};
  grid.lenses = {{{{0.545, 1.0, 0.29}, {-0.545, 1.0, 0.29}}, 1.4, 0.25}};
  body.surface = polygonise(mannequinShape(), grid);

  const auto at = [&](const std::string& name) { return rest[figure.jointIndex(name)].translation(); };
  for (const PieceRow& row : humanPieces) {
    const bool middle = isMiddle(figure, row.from);
    for (const char* side : {"_l", "_r"}) {
      if (middle && side[1] == 'r') break;
      const auto named = [&](const std::string& base) {
        return base.empty() || isMiddle(figure, base) ? base : base + side;
      };
      BodyPiece piece{.name = middle ? row.name : std::string(row.name) + side,
                      .from = at(named(row.from)),
                      .to = at(named(row.to)),
                      .stiffness = row.stiffness,
                      .bond = row.bond,
                      .twists = std::string(row.name) == "hand",
                      .stands = std::string(row.name) == "foot"};
      const std::string parent = row.parent;
      for (std::size_t k = 0; k < body.pieces.size(); ++k)
        if (body.pieces[k].name == parent || body.pieces[k].name == parent + side)
          piece.parent = static_cast<int>(k);
      piece.partner = static_cast<int>(body.pieces.size()) + (middle ? 0 : side[1] == 'l' ? 1 : -1);
      body.pieces.push_back(piece);
    }
  }
  for (const PieceRow& row : humanPieces)
    for (const char* side : {"_l", "_r"})
      if (*row.mate)
        body.pieces[body.piece(std::string(row.name) + side)].mate = body.piece(std::string(row.mate) + side);
  for (const std::string side : {"_l", "_r"})
    body.pieces[body.piece("clavicle" + side)].lifter = body.piece("upperarm" + side);

  std::vector<Bone> bones;
  for (std::size_t k = 0; k < body.pieces.size(); ++k)
    bones.push_back({static_cast<int>(k), body.pieces[k].from, body.pieces[k].to});
  // The trunk is wide: its pieces hold the flanks by segments of their own.
  const int pelvis = body.piece("pelvis"), chest = body.piece("chest");
  for (const double side : {1.0, -1.0}) {
    bones.push_back({chest, {side * 0.10, 1.36, 0.0}, {side * 0.10, 1.12, 0.0}});
    bones.push_back({pelvis, {side * 0.10, 1.08, 0.0}, {side * 0.085, 0.97, 0.0}});
  }
  const SparseWeights heat = boneHeatWeights(body.surface, bones, {.strength = 8.0, .voxels = 120});
  for (const Influences& row : fourLargest(heat, static_cast<int>(body.pieces.size()))) {
    std::array<std::pair<int, double>, 4> kept;
    for (int k = 0; k < 4; ++k) kept[k] = {row.joints[k], row.weights[k]};
    body.weights.push_back(kept);
  }

  // Fingers differ from body to body, and a hand has more vertices than its share of the surface.
  const int hand = body.piece("hand_l"), otherHand = body.piece("hand_r");
  for (const auto& row : body.weights) {
    double inHand = 0.0;
    for (const auto& [k, w] : row)
      if (k == hand || k == otherHand) inHand += w;
    body.importance.push_back(1.0 - 0.6 * inHand);
  }

  // A joint belongs to the piece of its nearest ancestor (itself included) at which a piece begins.
  std::vector<int> pieceOf(figure.jointCount(), 0);
  std::vector<int> index(figure.jointCount(), -1);
  const std::vector<int> partners = mirrorPartners(figure);
  for (int j = 1; j < figure.jointCount(); ++j) {  // without Root, which stands on the floor
    pieceOf[j] = figure.parent(j) < 1 ? 0 : pieceOf[figure.parent(j)];
    for (std::size_t k = 0; k < body.pieces.size(); ++k)
      if ((body.pieces[k].from - rest[j].translation()).norm() < 1e-9) pieceOf[j] = static_cast<int>(k);
    index[j] = static_cast<int>(body.joints.size());
    body.joints.push_back({.name = figure.joint(j).name,
                           .parent = figure.parent(j) < 1 ? -1 : index[figure.parent(j)],
                           .partner = partners[j],
                           .piece = pieceOf[j],
                           .position = rest[j].translation()});
  }
  for (TemplateJoint& joint : body.joints) joint.partner = index[joint.partner];

  const double height = 1.7365;  // crown
  for (Vector3d& p : body.surface.positions) p /= height;
  for (BodyPiece& piece : body.pieces) piece.from /= height, piece.to /= height;
  for (TemplateJoint& joint : body.joints) joint.position /= height;

  body.variety = 0.065;  // grown people and children 0.02 to 0.05, clothed characters of games 0.1 to 0.18
  for (int v = 0; v < static_cast<int>(body.surface.positions.size()); ++v) {
    const Vector3d& p = body.surface.positions[v];
    if (std::abs(p.x()) < 1e-6 && (body.crotch < 0 || p.y() < body.surface.positions[body.crotch].y()))
      body.crotch = v;
  }
  // In people the hip joints lie this much above the crotch, in heights (grown bodies: 0.051 to 0.058).
  constexpr double hipsAboveCrotch = 0.056;
  body.crotchDrop =
      body.pieces[body.piece("thigh_l")].from.y() - body.surface.positions[body.crotch].y() - hipsAboveCrotch;

  body.poses.push_back({"A", restMaps(body)});
  const auto arms = [&](const char* name, const Vector3d& clavicle, const Vector3d& arm) {
    PieceMaps maps = restMaps(body);
    aim(body, maps, "clavicle_l", clavicle);
    for (const char* piece : {"upperarm_l", "lowerarm_l", "hand_l"}) aim(body, maps, piece, arm);
    body.poses.push_back({name, std::move(maps)});
  };
  arms("T", {1.0, 0.0, 0.0}, {1.0, 0.0, 0.0});
  arms("arms down", {1.0, -0.1, 0.0}, {0.25, -1.0, 0.0});
  arms("arms up", {1.0, 0.5, 0.0}, {0.4, 1.0, 0.0});
  for (const char* name : {"large head, A", "large head, T"}) {
    PieceMaps maps = resized(body, [](const std::string& piece) {
      if (piece == "head") return 3.0;
      for (const char* leg : {"thigh", "calf"})
        if (piece.starts_with(leg)) return 0.5;
      return 0.8;
    });
    if (name[12] == 'T')
      for (const char* piece : {"clavicle_l", "upperarm_l", "lowerarm_l", "hand_l"})
        aim(body, maps, piece, {1.0, 0.0, 0.0});
    body.poses.push_back({.name = name, .maps = std::move(maps), .rarity = 1.08});
  }
  for (const bool left : {true, false}) {  // the leg in front; the other arm is
    PieceMaps maps = restMaps(body);
    const std::string front = left ? "_l" : "_r", back = left ? "_r" : "_l";
    const double side = left ? 1.0 : -1.0;
    aimOne(body, maps, "thigh" + front, {0.0, -1.0, 0.45});
    aimOne(body, maps, "calf" + front, {0.0, -1.0, 0.15});
    aimOne(body, maps, "thigh" + back, {0.0, -1.0, -0.25});
    aimOne(body, maps, "calf" + back, {0.0, -0.85, -0.55});
    for (const auto& [swing, sign, z] : {std::tuple(front, side, -0.35), {back, -side, 0.35}}) {
      aimOne(body, maps, "upperarm" + swing, {0.25 * sign, -1.0, z});
      for (const char* piece : {"lowerarm", "hand"})
        aimOne(body, maps, piece + swing, {0.2 * sign, -1.0, z + 0.55});
    }
    body.poses.push_back({left ? "stride, left leg in front" : "stride, right leg in front", maps, false});
  }
  return body;
}

}  // namespace

int TemplateBody::piece(const std::string& name) const {
  for (std::size_t k = 0; k < pieces.size(); ++k)
    if (pieces[k].name == name) return static_cast<int>(k);
  throw std::invalid_argument("the template has no piece '" + name + "'");
}

PieceMaps restMaps(const TemplateBody& body) {
  PieceMaps maps;
  for (const BodyPiece& piece : body.pieces) maps.push_back({Eigen::Matrix3d::Identity(), piece.from});
  return maps;
}

void aimOne(const TemplateBody& body, PieceMaps& maps, const std::string& name, const Vector3d& direction) {
  const int k = body.piece(name);
  const BodyPiece& piece = body.pieces[k];
  const Eigen::Matrix3d turn =
      Eigen::Quaterniond::FromTwoVectors(maps[k].linear * (piece.to - piece.from), direction)
          .toRotationMatrix();
  const Vector3d pivot = maps[k].origin;
  std::vector<char> below(body.pieces.size(), 0);
  for (int i = k; i < static_cast<int>(body.pieces.size()); ++i) {
    below[i] = i == k || (body.pieces[i].parent >= 0 && below[body.pieces[i].parent]);
    if (!below[i]) continue;
    maps[i].linear = turn * maps[i].linear;
    maps[i].origin = pivot + turn * (maps[i].origin - pivot);
  }
}

void aim(const TemplateBody& body, PieceMaps& maps, const std::string& left, const Vector3d& direction) {
  const int first = body.piece(left), second = body.pieces[first].partner;
  aimOne(body, maps, left, direction);
  if (second != first)
    aimOne(body, maps, body.pieces[second].name, {-direction.x(), direction.y(), direction.z()});
}

const TemplateBody& humanTemplate() {
  static const TemplateBody body = makeHuman();
  return body;
}

}  // namespace gelenk
