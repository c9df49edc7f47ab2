#include "skinning/rigging/bone_heat.h"

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <queue>
#include <stdexcept>
#include <unordered_map>

#include "skinning/cotangent.h"
#include "skinning/rigging/short_edges.h"

namespace gelenk {

using Eigen::Vector3d;
using Eigen::Vector3i;
using Eigen::VectorXd;
using SparseMatrix = Eigen::SparseMatrix<double>;

namespace {

// ----------------------------------------------------------------------------------------------------
// Welding

struct Welded {
  Mesh mesh;
  std::vector<int> of;  ///< for each vertex of the input its vertex in mesh
};

struct CellHash {
  std::size_t operator()(const std::array<std::int64_t, 3>& c) const {
    std::uint64_t h = 1469598103934665603ull;
    for (const std::int64_t k : c) h = (h ^ static_cast<std::uint64_t>(k)) * 1099511628211ull;
    return h ^ (h >> 29);
  }
};

/// Vertices in one place, to a millionth of the size, become one.
Welded weld(const Mesh& mesh) {
  Welded out;
  const double grain = std::max(1e-6 * bodySize(mesh), 1e-300);
  std::unordered_map<std::array<std::int64_t, 3>, int, CellHash> at;
  at.reserve(mesh.positions.size());
  const Vector3d origin = mesh.positions[0];
  for (const Vector3d& p : mesh.positions) {
    std::array<std::int64_t, 3> cell;
    for (int d = 0; d < 3; ++d) cell[d] = std::llround((p[d] - origin[d]) / grain);
    const auto [found, fresh] = at.emplace(cell, static_cast<int>(out.mesh.positions.size()));
    if (fresh) out.mesh.positions.push_back(p);
    out.of.push_back(found->second);
  }
  for (const auto& [a, b, c] : mesh.triangles) {
    const std::array<int, 3> t{out.of[a], out.of[b], out.of[c]};
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) out.mesh.triangles.push_back(t);
  }
  return out;
}

// ----------------------------------------------------------------------------------------------------
// Voxels

/// The body as voxels: those that the surface touches and those that cannot be reached from outside. For each
/// of them the bone that is nearest by a path inside.
class BodyVoxels {
 public:
  BodyVoxels(const Mesh& mesh, std::span<const Bone> bones, int resolution) {
    Eigen::AlignedBox3d box;
    for (const Vector3d& p : mesh.positions) box.extend(p);
    size_ = std::max(box.sizes().maxCoeff() / resolution, 1e-300);
    origin_ = box.min().array() - 1.5 * size_;
    for (int d = 0; d < 3; ++d) count_[d] = static_cast<int>(std::ceil(box.sizes()[d] / size_)) + 4;
    state_.assign(static_cast<std::size_t>(count_.x()) * count_.y() * count_.z(), Inside);
    markSurface(mesh);
    markOutside();
    spread(bones);
  }

  /// Bones that reach the voxel of p or one of its neighbours.
  void bonesNear(const Vector3d& p, std::vector<int>& found) const {
    found.clear();
    const Vector3i centre = voxelOf(p);
    for (int k = 0; k < 27; ++k) {
      const Vector3i v = centre + Vector3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
      if (!within(v)) continue;
      const int bone = bone_[indexOf(v)];
      if (bone >= 0 && std::find(found.begin(), found.end(), bone) == found.end()) found.push_back(bone);
    }
  }

 private:
  enum State : char { Outside, Surface, Inside };

  Vector3i voxelOf(const Vector3d& p) const { return ((p - origin_) / size_).array().floor().cast<int>(); }
  bool within(const Vector3i& v) const {
    return (v.array() >= 0).all() && (v.array() < count_.array()).all();
  }
  std::size_t indexOf(const Vector3i& v) const {
    return v.x() +
           static_cast<std::size_t>(count_.x()) * (v.y() + static_cast<std::size_t>(count_.y()) * v.z());
  }
  Vector3d centreOf(const Vector3i& v) const {
    return origin_ + size_ * (v.cast<double>().array() + 0.5).matrix();
  }

  void markSurface(const Mesh& mesh) {
    for (const auto& t : mesh.triangles) {
      const Vector3d a = mesh.positions[t[0]], u = mesh.positions[t[1]] - a, v = mesh.positions[t[2]] - a;
      const double longest = std::max({u.norm(), v.norm(), (u - v).norm()});
      const int steps = static_cast<int>(std::ceil(longest / (0.4 * size_))) + 1;
      for (int i = 0; i <= steps; ++i)
        for (int j = 0; i + j <= steps; ++j) state_[indexOf(voxelOf(a + (i * u + j * v) / steps))] = Surface;
    }
  }

  void markOutside() {
    std::vector<Vector3i> open{Vector3i::Zero()};
    state_[0] = Outside;
    while (!open.empty()) {
      const Vector3i at = open.back();
      open.pop_back();
      for (int d = 0; d < 6; ++d) {
        const Vector3i next = at + (d % 2 ? 1 : -1) * Vector3i::Unit(d / 2);
        if (!within(next) || state_[indexOf(next)] != Inside) continue;
        state_[indexOf(next)] = Outside;
        open.push_back(next);
      }
    }
  }

  /// Dijkstra from all bones at once through the voxels that are not outside.
  void spread(std::span<const Bone> bones) {
    bone_.assign(state_.size(), -1);
    std::vector<double> distance(state_.size(), std::numeric_limits<double>::infinity());
    struct Entry {
      double distance;
      Vector3i at;
      int bone;
      bool operator<(const Entry& other) const {
        return distance != other.distance ? distance > other.distance : bone > other.bone;
      }
    };
    std::priority_queue<Entry> queue;
    const auto reach = [&](const Vector3i& v, double d, int bone) {
      if (!within(v) || state_[indexOf(v)] == Outside) return;
      double& known = distance[indexOf(v)];
      if (d > known || (d == known && bone >= bone_[indexOf(v)])) return;
      known = d;
      bone_[indexOf(v)] = bone;
      queue.push({d, v, bone});
    };
    for (int b = 0; b < static_cast<int>(bones.size()); ++b) {
      const int steps = static_cast<int>(std::clamp(bones[b].length() / (0.5 * size_), 1.0, 1e5));
      for (int k = 0; k <= steps; ++k) {
        const Vector3d p = bones[b].from + (bones[b].to - bones[b].from) * k / steps;
        if (!((p - origin_).cwiseAbs().maxCoeff() < 1e6 * size_)) continue;  // far outside the body
        const Vector3i v = voxelOf(p);
        reach(v, distanceTo(bones[b], centreOf(v)), b);
      }
    }
    while (!queue.empty()) {
      const Entry entry = queue.top();
      queue.pop();
      if (entry.distance > distance[indexOf(entry.at)]) continue;
      for (int k = 0; k < 27; ++k) {
        const Vector3i step(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
        if (k != 13) reach(entry.at + step, entry.distance + size_ * step.cast<double>().norm(), entry.bone);
      }
    }
  }

  double size_;
  Vector3d origin_;
  Vector3i count_;
  std::vector<State> state_;
  std::vector<int> bone_;
};

// ----------------------------------------------------------------------------------------------------
// Heat

/// X <- A^-1 X for eight columns at a time: the factor is read once for all of them.
constexpr int lanes = 8;
using Lanes = Eigen::Matrix<double, Eigen::Dynamic, lanes, Eigen::RowMajor>;

void solveLanes(const SparseMatrix& L, const VectorXd& D, Lanes& X) {
  using Row = Eigen::Matrix<double, 1, lanes>;
  const int* outer = L.outerIndexPtr();
  const int* inner = L.innerIndexPtr();
  const double* value = L.valuePtr();
  const Eigen::Index n = X.rows();
  for (Eigen::Index j = 0; j < n; ++j) {
    const Row x = X.row(j);
    if (x.isZero(0.0)) continue;
    for (int k = outer[j]; k < outer[j + 1]; ++k)
      if (inner[k] != j) X.row(inner[k]).noalias() -= value[k] * x;
  }
  for (Eigen::Index j = n - 1; j >= 0; --j) {
    Row x = X.row(j) / D[j];
    for (int k = outer[j]; k < outer[j + 1]; ++k)
      if (inner[k] != j) x.noalias() -= value[k] * X.row(inner[k]);
    X.row(j) = x;
  }
}

std::vector<int> ownBones(const Mesh& mesh, std::span<const Bone> bones, int voxels) {
  const BodyVoxels body(mesh, bones, voxels);
  std::vector<int> all(bones.size()), near, own;
  for (std::size_t b = 0; b < bones.size(); ++b) all[b] = static_cast<int>(b);
  for (const Vector3d& p : mesh.positions) {
    body.bonesNear(p, near);
    const std::vector<int>& candidates = near.empty() ? all : near;
    own.push_back(*std::min_element(candidates.begin(), candidates.end(), [&](int a, int b) {
      const double da = distanceTo(bones[a], p), db = distanceTo(bones[b], p);
      return da != db ? da < db : a < b;
    }));
  }
  return own;
}

/// Distance of each vertex from its own bone, but no less than four fifths of the mean over all vertices of
/// that bone: where a bone comes close under the skin, as at knuckles, its heat would otherwise make a step.
std::vector<double> ownDistances(const Mesh& mesh, std::span<const Bone> bones, const std::vector<int>& own) {
  std::vector<double> distance, sum(bones.size(), 0.0);
  std::vector<int> count(bones.size(), 0);
  for (std::size_t v = 0; v < own.size(); ++v) {
    distance.push_back(distanceTo(bones[own[v]], mesh.positions[v]));
    sum[own[v]] += distance[v];
    ++count[own[v]];
  }
  for (std::size_t v = 0; v < own.size(); ++v)
    distance[v] = std::max(distance[v], 0.8 * sum[own[v]] / count[own[v]]);
  return distance;
}

void check(const Mesh& mesh, std::span<const Bone> bones) {
  validate(mesh);
  if (bones.empty()) throw std::invalid_argument("weights need at least one bone");
  for (const Bone& bone : bones)
    if (bone.joint < 0 || !bone.from.allFinite() || !bone.to.allFinite())
      throw std::invalid_argument("a bone without a joint or with an end that is not finite");
}

}  // namespace

std::vector<int> nearestBoneInside(const Mesh& mesh, std::span<const Bone> bones, int voxels) {
  check(mesh, bones);
  return ownBones(mesh, bones, voxels);
}

SparseWeights boneHeatWeights(const Mesh& input, std::span<const Bone> bones,
                              const BoneHeatOptions& options) {
  check(input, bones);
  if (!(options.strength > 0.0) || options.voxels < 1 || options.voxels > 1000 ||
      !(options.longestEdge > 0.0))
    throw std::invalid_argument(
        "the strength of heat and the longest edge must be positive and the voxels from 1 to 1000");
  const Welded welded = weld(input);
  const double size = std::max(bodySize(input), 1e-300);
  const Mesh mesh = withShortEdges(welded.mesh, options.longestEdge * size, 30000);
  const int n = static_cast<int>(mesh.positions.size());
  const std::vector<int> own = ownBones(mesh, bones, options.voxels);

  VectorXd areas;
  SparseMatrix A = cotangentMatrix(mesh, areas);
  // Loose vertices: their own bone alone.
  const double leastArea = std::max({1e-12 * areas.sum() / n, 1e-30 * size * size, 1e-300});
  const std::vector<double> distance = ownDistances(mesh, bones, own);
  VectorXd heat(n);
  for (int v = 0; v < n; ++v) {
    const double d = std::max(distance[v], 1e-4 * size);
    // Slivers conduct so well that rounding would swallow the heat of their corners.
    heat[v] = std::max(std::max(areas[v], leastArea) * options.strength / (d * d), 1e-12 * A.coeff(v, v));
    A.coeffRef(v, v) += heat[v];
  }
  Eigen::SimplicialLDLT<SparseMatrix> factor(A);
  if (factor.info() != Eigen::Success) throw std::runtime_error("the heat equation could not be factorised");
  const SparseMatrix L = factor.matrixL();
  const VectorXd D = factor.vectorD();
  const auto& permuted = factor.permutationP().indices();

  std::vector<int> joints;
  for (const int b : own) joints.push_back(bones[b].joint);
  std::sort(joints.begin(), joints.end());
  joints.erase(std::unique(joints.begin(), joints.end()), joints.end());

  constexpr double least = 1e-5;  // what is left out below changes a row's sum by less than that a joint
  SparseWeights rows(n);
  Lanes X(n, lanes);
  for (std::size_t first = 0; first < joints.size(); first += lanes) {
    const auto inBatch = std::min<std::size_t>(lanes, joints.size() - first);
    X.setZero();
    for (int v = 0; v < n; ++v)
      for (std::size_t k = 0; k < inBatch; ++k)
        if (bones[own[v]].joint == joints[first + k]) X(permuted[v], k) = heat[v];
    solveLanes(L, D, X);
    for (int v = 0; v < n; ++v)
      for (std::size_t k = 0; k < inBatch; ++k)
        if (const double w = X(permuted[v], k); w > least) rows[v].emplace_back(joints[first + k], w);
  }
  for (int v = 0; v < n; ++v) {
    double sum = 0.0;
    for (const auto& [joint, w] : rows[v]) sum += w;
    if (!(sum > 0.0) || !std::isfinite(sum)) rows[v] = {{bones[own[v]].joint, 1.0}}, sum = 1.0;
    for (auto& [joint, w] : rows[v]) w /= sum;
  }
  SparseWeights out;
  out.reserve(input.positions.size());
  for (const int v : welded.of) out.push_back(rows[v]);
  return out;
}

}  // namespace gelenk
