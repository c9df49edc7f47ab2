#include "skinning/blend/skin_method.h"

#include <array>
#include <complex>
#include <stdexcept>

#include "kinematics/rotation.h"
#include "skinning/blend/blend_kernel.h"
#include "skinning/blend/surface_slopes.h"

namespace gelenk {

#define GELENK_DECLARATION(Kind, method) extern const SkinMethod method;
GELENK_SKIN_METHODS(GELENK_DECLARATION)
#undef GELENK_DECLARATION

std::span<const SkinMethod* const> skinMethods() {
#define GELENK_ROW(Kind, method) &method,
  static constexpr std::array table{GELENK_SKIN_METHODS(GELENK_ROW)};
#undef GELENK_ROW
  return table;
}

const SkinMethod& skinMethod(SkinMethodKind kind) { return *skinMethods()[static_cast<std::size_t>(kind)]; }

const SkinMethod& skinMethodNamed(std::string_view name) {
  std::string known;
  for (const SkinMethod* method : skinMethods()) {
    if (method->name == name) return *method;
    known += (known.empty() ? "" : ", ") + std::string(method->name);
  }
  throw std::invalid_argument("no skinning method is called '" + std::string(name) +
                              "'; there are: " + known);
}

PreparedSkin prepareSkin(Skin skin, const SkinMethod& method, TwistSpread spread) {
  PreparedSkin prepared{.skin = std::move(skin), .method = &method, .spread = std::move(spread)};
  if (!method.twists) prepared.spread = {};
  prepared.slopes = weightSlopes(prepared.skin);
  if (method.prepare) method.prepare(prepared);
  return prepared;
}

PreparedSkin verticesOf(const PreparedSkin& prepared, std::span<const int> vertices) {
  PreparedSkin some{
      .skin = {.mesh = {}, .influences = {}, .jointFromRestWorld = prepared.skin.jointFromRestWorld},
      .method = prepared.method,
      .spread = prepared.spread};
  const auto take = [&](const auto& from, auto& to) {
    if (!from.empty())
      for (const int v : vertices) to.push_back(from[v]);
  };
  take(prepared.skin.mesh.positions, some.skin.mesh.positions);
  take(prepared.skin.mesh.normals, some.skin.mesh.normals);
  take(prepared.skin.influences, some.skin.influences);
  take(prepared.slopes, some.slopes);
  take(prepared.centres, some.centres);
  take(prepared.centreSlopes, some.centreSlopes);
  return some;
}

PosedBones poseBones(const PreparedSkin& prepared, const Frames& worldFromJoint, const Eigen::VectorXd* q) {
  if (worldFromJoint.size() != prepared.skin.jointFromRestWorld.size())
    throw std::invalid_argument("the skin has " + std::to_string(prepared.skin.jointFromRestWorld.size()) +
                                " joints, the pose has " + std::to_string(worldFromJoint.size()) + " frames");
  PosedBones bones{.worldFromRest = skinningMatrices(prepared.skin, worldFromJoint), .twists = {}};
  bones.twists = boneTwists(prepared.spread, bones.worldFromRest, q);
  return bones;
}

void blendSkin(const PreparedSkin& prepared, const PosedBones& bones, SkinnedVertices& out,
               SkinNormals normals) {
  out.positions.resize(prepared.skin.mesh.positions.size());
  out.normals.resize(prepared.skin.mesh.positions.size());
  if (out.positions.empty()) return;
  prepared.method->blend(prepared, bones, normals, out);
}

SkinnedVertices blendSkin(const PreparedSkin& prepared, const Frames& worldFromJoint,
                          const Eigen::VectorXd* q, SkinNormals normals) {
  SkinnedVertices out;
  blendSkin(prepared, poseBones(prepared, worldFromJoint, q), out, normals);
  return out;
}

namespace blend {
namespace {

Column column(const Eigen::Vector3d& v, double w = 0.0) { return Column{v.x(), v.y(), v.z(), w}; }
Column column(const Eigen::Quaterniond& q) { return Column{q.x(), q.y(), q.z(), q.w()}; }
Eigen::Quaterniond pure(const Eigen::Vector3d& v) { return {0.0, v.x(), v.y(), v.z()}; }

Columns columns(const Eigen::Matrix3d& linear, const Eigen::Vector3d& translation) {
  return {column(linear.col(0)), column(linear.col(1)), column(linear.col(2)), column(translation)};
}

TwistColumns twistColumns(const Eigen::Isometry3d& motion, const Eigen::Quaterniond& q,
                          const Eigen::Quaterniond& p, const TwistBone& bone, const BoneTwist& twist) {
  const Eigen::Matrix3d R = motion.linear(), along = bone.axis * bone.axis.transpose(),
                        across = Eigen::Matrix3d::Identity() - along, turned = crossMatrix(bone.axis);
  TwistColumns out;
  out.fixed = columns(R * along, motion * bone.head - R * along * bone.head);
  out.even = columns(R * across, -R * across * bone.head);
  out.odd = columns(R * turned, -R * turned * bone.head);
  const Eigen::Quaterniond a = pure(bone.axis), moment = pure(bone.head.cross(bone.axis));
  out.qOdd = column(q * a);
  out.pOdd = column(q * moment) + column(p * a);
  out.axisByLength = column(bone.axis / bone.length);
  out.start = bone.axis.dot(bone.head) / bone.length;
  out.halfSlope = 0.5 * (twist.atEnd - twist.atHead);
  std::complex<double> knot = std::polar(1.0, 0.5 * twist.atHead);
  const std::complex<double> step = std::polar(1.0, out.halfSlope / (TwistColumns::knots - 1));
  for (auto& [cosine, sine] : out.knot) {
    cosine = knot.real(), sine = knot.imag();
    knot *= step;
  }
  return out;
}

}  // namespace

void runLoop(const Loops& loops, const PreparedSkin& prepared, const PosedBones& posed, SkinNormals normals,
             SkinnedVertices& out) {
  static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double) && sizeof(WeightSlopes) == 8 * sizeof(double) &&
                sizeof(PointSlopes) == 6 * sizeof(double));
  thread_local std::vector<BoneColumns> bones;
  thread_local std::vector<TwistColumns> twists;
  thread_local std::vector<int> twistOfJoint;
  bones.resize(posed.worldFromRest.size());
  twistOfJoint.assign(bones.size(), -1);
  twists.resize(prepared.spread.bones.size());
  for (std::size_t j = 0; j < bones.size(); ++j) {
    const Eigen::Isometry3d& motion = posed.worldFromRest[j];
    const Eigen::Quaterniond q(motion.linear());
    Eigen::Quaterniond p = pure(motion.translation()) * q;
    p.coeffs() *= 0.5;
    bones[j] = {columns(motion.linear(), motion.translation()), column(q), column(p)};
    for (std::size_t b = 0; b < twists.size(); ++b)
      if (prepared.spread.bones[b].joint == static_cast<int>(j)) {
        twistOfJoint[j] = static_cast<int>(b);
        twists[b] = twistColumns(motion, q, p, prepared.spread.bones[b], posed.twists[b]);
      }
  }
  const Mesh& mesh = prepared.skin.mesh;
  const BlendInput in{
      .count = mesh.positions.size(),
      .bones = bones.data(),
      .twistOfJoint = twistOfJoint.data(),
      .twists = twists.data(),
      .influences = prepared.skin.influences.data(),
      .positions = mesh.positions[0].data(),
      .normals = mesh.normals[0].data(),
      .slopes = prepared.slopes[0].data(),
      .centres = prepared.centres.empty() ? nullptr : prepared.centres[0].data(),
      .centreSlopes = prepared.centreSlopes.empty() ? nullptr : prepared.centreSlopes[0].data(),
      .outPositions = out.positions[0].data(),
      .outNormals = out.normals[0].data()};
  const bool gradients = normals == SkinNormals::Gradients;
  (twists.empty() ? (gradients ? loops.exact : loops.cheap)
                  : (gradients ? loops.exactTwisted : loops.cheapTwisted))(in);
}

}  // namespace blend
}  // namespace gelenk
