#include "skinning/blend/linear_blend.h"

#include <cmath>

// GCC compiles the loop twice and the loader takes the better one for the processor at hand. (Not under
// sanitizers, which start later than such a choice is made, and clang 14 has another way.) Compiled
// without errno, so that square roots are taken four at a time.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__)
#define GELENK_FOR_EACH_PROCESSOR __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define GELENK_FOR_EACH_PROCESSOR
#endif

namespace gelenk {
namespace {

/// Four doubles that are added and scaled together: (x, y, z, nothing). Columns of a 3x4 matrix.
typedef double Column __attribute__((vector_size(32), aligned(32)));
typedef long long Order __attribute__((vector_size(32)));
struct Columns {
  Column x, y, z, translation;
};

void setColumns(const Eigen::Isometry3d& worldFromRest, Columns& out) {
  const Eigen::Matrix4d& m = worldFromRest.matrix();
  for (int row = 0; row < 4; ++row) {
    out.x[row] = m(row, 0);
    out.y[row] = m(row, 1);
    out.z[row] = m(row, 2);
    out.translation[row] = m(row, 3);
  }
}

/// (y, z, x, nothing). A macro, because each compilation of the loop must inline its own.
#ifdef __clang__
#define GELENK_TURNED(v) __builtin_shufflevector(v, v, 1, 2, 0, 3)
#else
#define GELENK_TURNED(v) __builtin_shuffle(v, Order{1, 2, 0, 3})
#endif

constexpr std::size_t blockSize = 64;  ///< vertices between two rounds of square roots

/// count vertices; the arrays hold three numbers a vertex. The blended matrix is kept as columns (a b c | t):
/// x' = x a + y b + z c + t, and the normal goes with the cofactors: n' = nx b x c + ny c x a + nz a x b,
/// which is b x (nx c - nz a) + c x (ny a).
GELENK_FOR_EACH_PROCESSOR
void blendVertices(const Columns* matrices, const Influences* influences, const double* restPositions,
                   const double* restNormals, std::size_t count, double* positions, double* normals) {
  double scale[blockSize] = {};
  for (std::size_t start = 0; start < count; start += blockSize) {
    const std::size_t end = start + blockSize < count ? start + blockSize : count;
    for (std::size_t v = start; v < end; ++v) {
      const Influences& in = influences[v];
      const Columns& first = matrices[in.joints[0]];
      const double w0 = in.weights[0];
      Column a = w0 * first.x, b = w0 * first.y, c = w0 * first.z, t = w0 * first.translation;
      for (int k = 1; k < 4 && in.weights[k] > 0.0; ++k) {  // weights descend
        const double w = in.weights[k];
        const Columns& m = matrices[in.joints[k]];
        a += w * m.x;
        b += w * m.y;
        c += w * m.z;
        t += w * m.translation;
      }
      const double *p = restPositions + 3 * v, *n = restNormals + 3 * v;
      const Column position = (p[0] * a + t) + (p[1] * b + p[2] * c);
      const Column u = n[0] * c - n[2] * a, w = n[1] * a;
      const Column crossed =
          (b * GELENK_TURNED(u) - GELENK_TURNED(b) * u) + (c * GELENK_TURNED(w) - GELENK_TURNED(c) * w);
      const Column normal = GELENK_TURNED(crossed);
      for (int k = 0; k < 3; ++k) positions[3 * v + k] = position[k];
      for (int k = 0; k < 3; ++k) normals[3 * v + k] = normal[k];
      scale[v - start] = normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2];
    }
    for (std::size_t i = 0; i < blockSize; ++i) scale[i] = 1.0 / std::sqrt(scale[i]);
    for (std::size_t v = start; v < end; ++v)
      for (int k = 0; k < 3; ++k) normals[3 * v + k] *= scale[v - start];
  }
}

}  // namespace

void linearBlendSkin(const Skin& skin, const Frames& worldFromJoint, SkinnedVertices& out) {
  static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double));
  thread_local std::vector<Columns> matrices;
  matrices.resize(worldFromJoint.size());
  for (std::size_t i = 0; i < worldFromJoint.size(); ++i)
    setColumns(worldFromJoint[i] * skin.jointFromRestWorld[i], matrices[i]);
  const std::size_t count = skin.mesh.positions.size();
  out.positions.resize(count);
  out.normals.resize(count);
  if (count == 0) return;
  blendVertices(matrices.data(), skin.influences.data(), skin.mesh.positions[0].data(),
                skin.mesh.normals[0].data(), count, out.positions[0].data(), out.normals[0].data());
}

SkinnedVertices linearBlendSkin(const Skin& skin, const Frames& worldFromJoint) {
  SkinnedVertices out;
  linearBlendSkin(skin, worldFromJoint, out);
  return out;
}

}  // namespace gelenk
