#include "skinning/blend/blend_kernel.h"
#include "skinning/blend/rotation_centres.h"
#include "skinning/blend/surface_slopes.h"

namespace gelenk {
namespace blend {
namespace {

/// x' = sum w_k T_k c + R (x - c), R of q = sum s_k w_k q_k: the linear blend where the centre of rotation
/// goes, and one rotation about it.
struct Cor {
  template <bool twist, bool gradients>
  GELENK_INLINE static void vertex(const BlendInput& in, std::size_t v, Column& position, Column& normal) {
    const Influences& influences = in.influences[v];
    if (!gradients && !(influences.weights[1] > 0.0)) return withOneBone<twist>(in, v, position, normal);
    const Column x = load3(in.positions + 3 * v), n = load3(in.normals + 3 * v),
                 c = load3(in.centres + 3 * v);
    Column t1{}, t2{}, d1{}, d2{};
    if (gradients) tangents(n, t1, t2);
    const double* slopes = in.slopes + 8 * v;
    Columns sum{};
    Column q{}, q1{}, q2{}, first{};
    BoneAt here;
    for (int k = 0; k < 4 && influences.weights[k] > 0.0; ++k) {
      const int joint = influences.joints[k];
      const BoneColumns* bone = &in.bones[joint];
      bool twisted = false;
      if (twist && in.twistOfJoint[joint] >= 0) {
        twistedBone<false, true, gradients>(*bone, in.twists[in.twistOfJoint[joint]], x, t1, t2, here);
        bone = &here.bone;
        twisted = true;
      }
      if (k == 0) first = bone->q;
      const double sign = k > 0 && dot4(bone->q, first) < 0.0 ? -1.0 : 1.0;
      const double w = influences.weights[k], sw = sign * w;
      add(sum, w, bone->motion);
      q += sw * bone->q;
      if (!gradients) continue;
      const Column moved = at(bone->motion, c);
      d1 += slopes[k] * moved;
      d2 += slopes[4 + k] * moved;
      q1 += sign * slopes[k] * bone->q;
      q2 += sign * slopes[4 + k] * bone->q;
      if (twist && twisted) {
        const Column dc = w * at(here.motionSlope, c);
        d1 += here.slope1 * dc;
        d2 += here.slope2 * dc;
        q1 += sw * here.slope1 * here.qSlope;
        q2 += sw * here.slope2 * here.qSlope;
      }
    }
    const double two = 2.0 / dot4(q, q);
    const Column arm = rotate(q, two, x - c);
    position = at(sum, in.centres + 3 * v) + arm;
    if (!gradients) {
      normal = rotate(q, two, n);
      return;
    }
    const Column c1 = load3(in.centreSlopes + 6 * v), c2 = load3(in.centreSlopes + 6 * v + 3);
    const Column o1 = two * vecTimesConjugate(q1, q), o2 = two * vecTimesConjugate(q2, q);
    normal = cross(linear(sum, c1) + d1 + rotate(q, two, t1 - c1) + cross(o1, arm),
                   linear(sum, c2) + d2 + rotate(q, two, t2 - c2) + cross(o2, arm));
  }
};
GELENK_BLEND_LOOPS(Cor)

void blendAll(const PreparedSkin& prepared, const PosedBones& bones, SkinNormals normals,
              SkinnedVertices& out) {
  runLoop({cheap, exact, cheapTwisted, exactTwisted}, prepared, bones, normals, out);
}

void prepare(PreparedSkin& prepared) {
  std::vector<bool> blended;
  prepared.centres = rotationCentres(prepared.skin, &blended);
  prepared.centreSlopes = pointSlopes(prepared.skin.mesh, prepared.centres, blended);
}

}  // namespace
}  // namespace blend

extern const SkinMethod corMethod;
const SkinMethod corMethod{.kind = SkinMethodKind::Cor,
                           .name = "cor",
                           .title = "Centres of rotation",
                           .reference = "Le and Hodgins 2016",
                           .prepare = blend::prepare,
                           .blend = blend::blendAll,
                           .shader = "SKIN_COR",
                           .bytesAVertex = 12};

}  // namespace gelenk
