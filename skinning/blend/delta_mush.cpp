#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <Eigen/SparseCore>
#include <Eigen/SparseLU>
#include <algorithm>
#include <map>

#include "kinematics/rotation.h"
#include "skinning/blend/skin_method.h"
#include "skinning/blend/surface_slopes.h"

// Delta mush (Mancewicz et al. 2014) and direct delta mush (Le and Lewis 2019), on the processor only: what
// the methods of the shader are compared with.

namespace gelenk {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using SparseMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

constexpr double lambda = 3.0;  ///< of an implicit step
constexpr int steps = 20;       ///< the paper's p
constexpr double alpha = 0.8;   ///< share of the rotated rest vertex's own centre (v0)
constexpr std::size_t bonesKept = 8;

/// B = (I + lambda L)^-p, L = I - mean over neighbours: smooths any field over the mesh.
class Smoother {
 public:
  explicit Smoother(const Mesh& mesh) {
    const auto rings = surfaceRings(mesh);
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t v = 0; v < rings.size(); ++v) {
      entries.emplace_back(v, v, 1.0 + (rings[v].empty() ? 0.0 : lambda));
      for (const int u : rings[v]) entries.emplace_back(v, u, -lambda / static_cast<double>(rings[v].size()));
    }
    Eigen::SparseMatrix<double> A(static_cast<Eigen::Index>(rings.size()),
                                  static_cast<Eigen::Index>(rings.size()));
    A.setFromTriplets(entries.begin(), entries.end());
    factor_.compute(A);
    if (factor_.info() != Eigen::Success) throw std::runtime_error("the smoothing could not be factorised");
  }
  Eigen::MatrixXd operator()(Eigen::MatrixXd field) const {
    for (int i = 0; i < steps; ++i) field = factor_.solve(field);
    return field;
  }

 private:
  Eigen::SparseLU<Eigen::SparseMatrix<double>> factor_;
};

Eigen::MatrixXd fieldOf(const std::vector<Vector3d>& points) {
  Eigen::MatrixXd field(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t v = 0; v < points.size(); ++v)
    field.row(static_cast<Eigen::Index>(v)) = points[v].transpose();
  return field;
}

/// Unit normals of the triangles, for methods that know no other.
void triangleNormals(const PreparedSkin& prepared, SkinnedVertices& out) {
  Mesh posed{.positions = out.positions, .triangles = prepared.skin.mesh.triangles, .normals = {}};
  computeNormals(posed);
  out.normals = std::move(posed.normals);
}

// ----------------------------------------------------------------------------------------------------
// Direct delta mush

/// Of one bone at one vertex: b = sum_k B_ik w_kj, s = sum_k B_ik w_kj d, S = sum_k B_ik w_kj d d^T with
/// d = x_k - p_i. Centred, so that nothing cancels.
struct Moment {
  int joint = 0;
  double b = 0.0;
  Vector3d s = Vector3d::Zero();
  Matrix3d S = Matrix3d::Zero();
};
struct Moments : MethodData {
  std::vector<Vector3d> smooth;  ///< p_i = sum_k B_ik x_k
  std::vector<std::vector<Moment>> of;
};

void prepareMoments(PreparedSkin& prepared) {
  const Skin& skin = prepared.skin;
  const auto n = static_cast<Eigen::Index>(skin.mesh.positions.size());
  const Smoother smooth(skin.mesh);
  auto moments = std::make_shared<Moments>();
  const Eigen::MatrixXd p = smooth(fieldOf(skin.mesh.positions));
  for (Eigen::Index v = 0; v < n; ++v) moments->smooth.push_back(p.row(v).transpose());
  moments->of.resize(static_cast<std::size_t>(n));
  for (int joint = 0; joint < skin.jointCount(); ++joint) {
    Eigen::MatrixXd field = Eigen::MatrixXd::Zero(n, 10);  // w (1, x, xx^T)
    bool any = false;
    for (Eigen::Index v = 0; v < n; ++v) {
      const Influences& in = skin.influences[static_cast<std::size_t>(v)];
      for (int k = 0; k < 4 && in.weights[k] > 0.0; ++k) {
        if (in.joints[k] != joint) continue;
        const Vector3d& x = skin.mesh.positions[static_cast<std::size_t>(v)];
        const double w = in.weights[k];
        field.row(v) << w, w * x.transpose(), w * x.x() * x.x(), w * x.x() * x.y(), w * x.x() * x.z(),
            w * x.y() * x.y(), w * x.y() * x.z(), w * x.z() * x.z();
        any = true;
      }
    }
    if (!any) continue;
    field = smooth(field);
    for (Eigen::Index v = 0; v < n; ++v) {
      const auto row = field.row(v);
      if (!(row[0] > 1e-6)) continue;
      const Vector3d centre = moments->smooth[static_cast<std::size_t>(v)],
                     first = row.segment<3>(1).transpose();
      Matrix3d second;
      second << row[4], row[5], row[6], row[5], row[7], row[8], row[6], row[8], row[9];
      Moment moment{.joint = joint, .b = row[0]};
      moment.s = first - row[0] * centre;
      moment.S = second - first * centre.transpose() - centre * first.transpose() +
                 row[0] * centre * centre.transpose();
      moments->of[static_cast<std::size_t>(v)].push_back(moment);
    }
  }
  for (std::vector<Moment>& list : moments->of) {
    std::sort(list.begin(), list.end(), [](const Moment& a, const Moment& b) { return a.b > b.b; });
    if (list.size() > bonesKept) list.resize(bonesKept);
    double sum = 0.0;
    for (const Moment& m : list) sum += m.b;
    Vector3d firsts = Vector3d::Zero();
    for (Moment& m : list) m.b /= sum, m.s /= sum, m.S /= sum, firsts += m.s;
    for (Moment& m : list)
      m.s -= m.b * firsts;  // of all bones they sum to 0, and so must those that are kept
  }
  prepared.own = std::move(moments);
}

/// The rotation nearest to M.
Matrix3d polarRotation(const Matrix3d& M) {
  const Eigen::JacobiSVD<Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d flip = Matrix3d::Identity();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) flip(2, 2) = -1.0;
  return svd.matrixU() * flip * svd.matrixV().transpose();
}

/// v0: the rotation is the polar one of M = sum_j R_j S_ij + c_j s_ij^T; v2: of blended quaternions.
/// x' = (1 - alpha) sum_j (R_j s_ij + b_ij c_j) + alpha sum_j b_ij c_j + R (x - p_i), c_j = T_j p_i.
template <bool polar>
void directDeltaMush(const PreparedSkin& prepared, const PosedBones& bones, SkinNormals,
                     SkinnedVertices& out) {
  const auto& moments = static_cast<const Moments&>(*prepared.own);
  std::vector<Eigen::Quaterniond> turns;
  for (const Eigen::Isometry3d& T : bones.worldFromRest) turns.emplace_back(T.linear());
  for (std::size_t v = 0; v < out.positions.size(); ++v) {
    const Vector3d &p = moments.smooth[v], &x = prepared.skin.mesh.positions[v];
    Matrix3d M = Matrix3d::Zero();
    Eigen::Vector4d q = Eigen::Vector4d::Zero();
    Vector3d place = Vector3d::Zero(), mean = Vector3d::Zero();
    for (const Moment& m : moments.of[v]) {
      const Eigen::Isometry3d& T = bones.worldFromRest[m.joint];
      const Vector3d c = T * p;
      place += m.b * c;
      mean += T.linear() * m.s + m.b * c;
      if (polar)
        M += T.linear() * m.S + c * m.s.transpose();  // the s sum to 0: any origin will do
      else
        q += (turns[m.joint].dot(turns[moments.of[v].front().joint]) < 0.0 ? -m.b : m.b) *
             turns[m.joint].coeffs();
    }
    const Matrix3d R = polar ? polarRotation(M) : Eigen::Quaterniond(q).normalized().toRotationMatrix();
    out.positions[v] = (1.0 - alpha) * mean + alpha * place + R * (x - p);
  }
  triangleNormals(prepared, out);
}

// ----------------------------------------------------------------------------------------------------
// Delta mush itself

struct Details : MethodData {
  std::shared_ptr<const Smoother> smooth;
  std::vector<Vector3d> inFrame;  ///< rest vertex minus smoothed one, in the smoothed surface's frame
};

/// Frame of a smoothed surface at a vertex: normal and the direction to its first neighbour.
std::vector<Matrix3d> surfaceFrames(const Mesh& mesh, const std::vector<std::vector<int>>& rings) {
  std::vector<Matrix3d> frames;
  for (std::size_t v = 0; v < rings.size(); ++v) {
    const Vector3d n = mesh.normals[v];
    Vector3d along = rings[v].empty() ? Vector3d(surfaceTangents(n).col(0))
                                      : Vector3d(mesh.positions[rings[v][0]] - mesh.positions[v]);
    along -= n.dot(along) * n;
    if (!(along.norm() > 1e-12)) along = surfaceTangents(n).col(0);
    along.normalize();
    Matrix3d frame;
    frame << along, n.cross(along), n;
    frames.push_back(frame);
  }
  return frames;
}

Mesh smoothed(const Smoother& smooth, const std::vector<Vector3d>& positions, const Mesh& like) {
  Mesh mesh{.positions = {}, .triangles = like.triangles, .normals = {}};
  const Eigen::MatrixXd field = smooth(fieldOf(positions));
  for (Eigen::Index v = 0; v < field.rows(); ++v) mesh.positions.push_back(field.row(v).transpose());
  computeNormals(mesh);
  return mesh;
}

void prepareDetails(PreparedSkin& prepared) {
  auto details = std::make_shared<Details>();
  details->smooth = std::make_shared<Smoother>(prepared.skin.mesh);
  const Mesh rest = smoothed(*details->smooth, prepared.skin.mesh.positions, prepared.skin.mesh);
  const auto frames = surfaceFrames(rest, surfaceRings(prepared.skin.mesh));
  for (std::size_t v = 0; v < frames.size(); ++v)
    details->inFrame.push_back(frames[v].transpose() * (prepared.skin.mesh.positions[v] - rest.positions[v]));
  prepared.own = std::move(details);
}

void deltaMush(const PreparedSkin& prepared, const PosedBones& bones, SkinNormals, SkinnedVertices& out) {
  const auto& details = static_cast<const Details&>(*prepared.own);
  std::vector<Vector3d> linear(out.positions.size(), Vector3d::Zero());
  for (std::size_t v = 0; v < linear.size(); ++v)
    for (int k = 0; k < 4; ++k)
      linear[v] +=
          prepared.skin.influences[v].weights[k] *
          (bones.worldFromRest[prepared.skin.influences[v].joints[k]] * prepared.skin.mesh.positions[v]);
  const Mesh posed = smoothed(*details.smooth, linear, prepared.skin.mesh);
  const auto frames = surfaceFrames(posed, surfaceRings(prepared.skin.mesh));
  for (std::size_t v = 0; v < frames.size(); ++v)
    out.positions[v] = posed.positions[v] + frames[v] * details.inFrame[v];
  triangleNormals(prepared, out);
}

}  // namespace

extern const SkinMethod ddm0Method, ddm2Method, deltaMushMethod;
const SkinMethod ddm0Method{.kind = SkinMethodKind::Ddm0,
                            .name = "ddm-v0",
                            .title = "Direct delta mush, v0",
                            .reference = "Le and Lewis 2019",
                            .prepare = prepareMoments,
                            .blend = directDeltaMush<true>,
                            .twists = false,
                            .bytesAVertex = 8 * 48 + 12};
const SkinMethod ddm2Method{.kind = SkinMethodKind::Ddm2,
                            .name = "ddm-v2",
                            .title = "Direct delta mush, v2",
                            .reference = "Le and Lewis 2019",
                            .prepare = prepareMoments,
                            .blend = directDeltaMush<false>,
                            .twists = false,
                            .bytesAVertex = 8 * 24 + 12};
const SkinMethod deltaMushMethod{.kind = SkinMethodKind::DeltaMush,
                                 .name = "delta-mush",
                                 .title = "Delta mush",
                                 .reference = "Mancewicz, Derksen, Rijpkema and Wilson 2014",
                                 .prepare = prepareDetails,
                                 .blend = deltaMush,
                                 .twists = false,
                                 .bytesAVertex = 12};

}  // namespace gelenk
