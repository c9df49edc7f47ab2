#include "skinning/blend/blend_kernel.h"

namespace gelenk {
namespace blend {
namespace {

/// q + eps p = sum s_k w_k (q_k + eps p_k), s_k = sign(q_k . q_0) with 0 the heaviest bone: q and -q are one
/// rotation, and the nearer one is blended. x' = R x + 2 vec(p conj(q)) / |q|^2, R of q / |q|. Frames are
/// rigid here, so there is no scale to carry.
struct Dqs {
  template <bool twist, bool gradients>
  GELENK_INLINE static void vertex(const BlendInput& in, std::size_t v, Column& position, Column& normal) {
    const Influences& influences = in.influences[v];
    if (!gradients && !(influences.weights[1] > 0.0)) return withOneBone<twist>(in, v, position, normal);
    const Column x = load3(in.positions + 3 * v), n = load3(in.normals + 3 * v);
    Column t1{}, t2{};
    if (gradients) tangents(n, t1, t2);
    const double* slopes = in.slopes + 8 * v;
    Column q{}, p{}, q1{}, q2{}, p1{}, p2{}, first{};
    BoneAt here;
    for (int k = 0; k < 4 && influences.weights[k] > 0.0; ++k) {
      const int joint = influences.joints[k];
      const BoneColumns* bone = &in.bones[joint];
      bool twisted = false;
      if (twist && in.twistOfJoint[joint] >= 0) {
        twistedBone<true, false, gradients>(*bone, in.twists[in.twistOfJoint[joint]], x, t1, t2, here);
        bone = &here.bone;
        twisted = true;
      }
      if (k == 0) first = bone->q;
      const double sign = k > 0 && dot4(bone->q, first) < 0.0 ? -1.0 : 1.0;
      const double w = sign * influences.weights[k];
      q += w * bone->q;
      p += w * bone->p;
      if (!gradients) continue;
      q1 += sign * slopes[k] * bone->q;
      p1 += sign * slopes[k] * bone->p;
      q2 += sign * slopes[4 + k] * bone->q;
      p2 += sign * slopes[4 + k] * bone->p;
      if (twist && twisted) {
        q1 += w * here.slope1 * here.qSlope;
        p1 += w * here.slope1 * here.pSlope;
        q2 += w * here.slope2 * here.qSlope;
        p2 += w * here.slope2 * here.pSlope;
      }
    }
    const double two = 2.0 / dot4(q, q);
    const Column turned = rotate(q, two, x), shift = two * vecTimesConjugate(p, q);
    position = turned + shift;
    if (!gradients) {
      normal = rotate(q, two, n);
      return;
    }
    // With N = |q|^2: d(R x) = R t + omega x R x, omega = 2 vec(dq conj(q)) / N, and
    // d shift = (2 vec(dp conj(q) + p conj(dq)) - shift dN) / N.
    const Column o1 = two * vecTimesConjugate(q1, q), o2 = two * vecTimesConjugate(q2, q);
    const Column s1 = two * (vecTimesConjugate(p1, q) + vecTimesConjugate(p, q1) - dot4(q, q1) * shift);
    const Column s2 = two * (vecTimesConjugate(p2, q) + vecTimesConjugate(p, q2) - dot4(q, q2) * shift);
    normal = cross(rotate(q, two, t1) + cross(o1, turned) + s1, rotate(q, two, t2) + cross(o2, turned) + s2);
  }
};
GELENK_BLEND_LOOPS(Dqs)

void blendAll(const PreparedSkin& prepared, const PosedBones& bones, SkinNormals normals,
              SkinnedVertices& out) {
  runLoop({cheap, exact, cheapTwisted, exactTwisted}, prepared, bones, normals, out);
}

}  // namespace
}  // namespace blend

extern const SkinMethod dqsMethod;
const SkinMethod dqsMethod{.kind = SkinMethodKind::Dqs,
                           .name = "dqs",
                           .title = "Dual quaternions",
                           .reference = "Kavan, Collins, Zara and O'Sullivan 2008",
                           .blend = blend::blendAll,
                           .shader = "SKIN_DQS"};

}  // namespace gelenk
