#include "skinning/blend/blend_kernel.h"

namespace gelenk {
namespace blend {
namespace {

/// x' = sum w_k T_k x. Tangents t' = sum w_k R_k t + sum w_k,t T_k x: the second sum is what the cofactors of
/// the blended matrix leave out.
struct Lbs {
  template <bool twist, bool gradients>
  GELENK_INLINE static void vertex(const BlendInput& in, std::size_t v, Column& position, Column& normal) {
    const Influences& influences = in.influences[v];
    const Column x = load3(in.positions + 3 * v), n = load3(in.normals + 3 * v);
    Column t1{}, t2{}, d1{}, d2{};
    if (gradients) tangents(n, t1, t2);
    const double* slopes = in.slopes + 8 * v;
    Columns sum{};
    BoneAt here;
    for (int k = 0; k < 4 && influences.weights[k] > 0.0; ++k) {  // weights descend
      const double w = influences.weights[k];
      const int joint = influences.joints[k];
      const Columns* motion = &in.bones[joint].motion;
      if (twist && in.twistOfJoint[joint] >= 0) {
        twistedBone<false, true, gradients>(in.bones[joint], in.twists[in.twistOfJoint[joint]], x, t1, t2,
                                            here);
        motion = &here.bone.motion;
        if (gradients) {
          const Column dx = w * at(here.motionSlope, x);
          d1 += here.slope1 * dx;
          d2 += here.slope2 * dx;
        }
      }
      add(sum, w, *motion);
      if (gradients) {
        const Column moved = at(*motion, x);
        d1 += slopes[k] * moved;
        d2 += slopes[4 + k] * moved;
      }
    }
    position = at(sum, x);
    if (gradients) {
      normal = cross(linear(sum, t1) + d1, linear(sum, t2) + d2);
    } else {
      const Column u = n[0] * sum.z - n[2] * sum.x, w = n[1] * sum.x;
      normal = cross(sum.y, u) + cross(sum.z, w);
    }
  }
};
GELENK_BLEND_LOOPS(Lbs)

void blendAll(const PreparedSkin& prepared, const PosedBones& bones, SkinNormals normals,
              SkinnedVertices& out) {
  runLoop({cheap, exact, cheapTwisted, exactTwisted}, prepared, bones, normals, out);
}

}  // namespace
}  // namespace blend

extern const SkinMethod lbsMethod;
const SkinMethod lbsMethod{.kind = SkinMethodKind::Lbs,
                           .name = "lbs",
                           .title = "Linear blending",
                           .reference = "Magnenat-Thalmann, Laperriere and Thalmann 1988; Lewis et al. 2000",
                           .blend = blend::blendAll,
                           .shader = "SKIN_LBS"};

}  // namespace gelenk
