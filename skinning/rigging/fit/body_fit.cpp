#include "skinning/rigging/fit/body_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <Eigen/SparseCholesky>
#include <cmath>

namespace gelenk {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

KdTree<6>::Point lifted(const Vector3d& p, const Vector3d& n, double reach) {
  KdTree<6>::Point out;
  out << p, reach * n;
  return out;
}

std::vector<KdTree<6>::Point> lifted(const SurfaceSamples& s, double reach) {
  std::vector<KdTree<6>::Point> out(s.points.size());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = lifted(s.points[i], s.normals[i], reach);
  return out;
}

std::vector<Vector3d> normalsOf(const Mesh& mesh, const std::vector<Vector3d>& positions) {
  std::vector<Vector3d> normals(positions.size(), Vector3d::Zero());
  for (const auto& t : mesh.triangles) {
    const Vector3d n = (positions[t[1]] - positions[t[0]]).cross(positions[t[2]] - positions[t[0]]);
    for (const int v : t) normals[v] += n;
  }
  for (Vector3d& n : normals) n = n.squaredNorm() > 0.0 ? Vector3d(n.normalized()) : Vector3d::UnitZ();
  return normals;
}

/// The normal equations of all maps, entry 12 k + 3 c + r for row r and column c of piece k (column 3: where
/// its origin goes). In a symmetric problem the right pieces are mirror images of the left ones and the
/// middle ones of themselves.
class MapEquations {
 public:
  MapEquations(const TemplateBody& body, bool symmetric)
      : size_(12 * static_cast<int>(body.pieces.size())),
        N_(MatrixXd::Zero(size_, size_)),
        b_(VectorXd::Zero(size_)),
        unknown_(size_, {-1, 0.0}) {
    constexpr double mirror[4] = {-1.0, 1.0, 1.0, 1.0};
    for (int i = 0; i < size_; ++i) {
      const int k = i / 12, partner = body.pieces[k].partner;
      const double odd = mirror[i % 3] * mirror[i % 12 / 3];
      if (!symmetric || partner > k)
        unknown_[i] = {unknowns_++, 1.0};
      else if (partner < k)
        unknown_[i] = {unknown_[i + 12 * (partner - k)].first, odd};
      else if (odd > 0.0)
        unknown_[i] = {unknowns_++, 1.0};
    }
  }

  /// Adds p . A p / 2 - b . p for the point p = sum over its pieces of w (linear y + origin), y = x - from.
  using Blend = std::array<std::pair<int, double>, 4>;
  void point(const TemplateBody& body, const Vector3d& x, const Blend& blend, const Matrix3d& A,
             const Vector3d& b) {
    Eigen::Matrix<double, 4, 4> phi;  // one column a piece
    int pieces = 0;
    while (pieces < 4 && blend[pieces].second != 0.0) {
      const auto& [k, w] = blend[pieces];
      phi.col(pieces++) << w * (x - body.pieces[k].from), w;
    }
    for (int m = 0; m < pieces; ++m)
      for (int i = 0; i < 4; ++i) {
        const int row = 12 * blend[m].first + 3 * i;
        b_.segment<3>(row) += phi(i, m) * b;
        for (int n = 0; n < pieces; ++n) {
          if (blend[n].first > blend[m].first) continue;  // lower blocks only
          for (int j = 0; j < 4; ++j)
            N_.block<3, 3>(row, 12 * blend[n].first + 3 * j) += (phi(i, m) * phi(j, n)) * A;
        }
      }
  }

  /// Adds weight |linear of a piece - shape|^2 / 2.
  void shape(int piece, const Matrix3d& shape, double weight) {
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) {
        const int i = 12 * piece + 3 * c + r;
        N_(i, i) += weight;
        b_[i] += weight * shape(r, c);
      }
  }

  /// Adds weight |linear of a piece - turn * linear of its parent|^2 / 2; parent < piece.
  void together(int piece, int parent, const Matrix3d& turn, double weight) {
    for (int c = 0; c < 3; ++c) {
      const int i = 12 * piece + 3 * c, j = 12 * parent + 3 * c;
      N_.block<3, 3>(i, i).diagonal().array() += weight;
      N_.block<3, 3>(j, j).diagonal().array() += weight;
      N_.block<3, 3>(i, j) -= weight * turn;
    }
  }

  void solve(PieceMaps& maps) const {
    MatrixXd N = MatrixXd::Zero(unknowns_, unknowns_);
    VectorXd b = VectorXd::Zero(unknowns_);
    for (int j = 0; j < size_; ++j) {
      const auto& [column, columnSign] = unknown_[j];
      if (column < 0) continue;
      b[column] += columnSign * b_[j];
      for (int i = 12 * (j / 12); i < size_; ++i) {
        const auto& [row, rowSign] = unknown_[i];
        if (row < 0 || N_(i, j) == 0.0) continue;
        const double value = rowSign * columnSign * N_(i, j);
        N(row, column) += value;
        if (i / 12 != j / 12) N(column, row) += value;  // the block above the diagonal
      }
    }
    N.diagonal().array() += 1e-12 * N.diagonal().maxCoeff();
    const VectorXd x = N.ldlt().solve(b);
    for (int i = 0; i < size_; ++i) {
      const auto& [index, sign] = unknown_[i];
      const double value = index < 0 ? 0.0 : sign * x[index];
      PieceMap& map = maps[i / 12];
      const int column = i % 12 / 3;
      (column < 3 ? map.linear(i % 3, column) : map.origin[i % 3]) = value;
    }
  }

 private:
  int size_, unknowns_ = 0;
  MatrixXd N_;
  VectorXd b_;
  std::vector<std::pair<int, double>> unknown_;
};

Matrix3d rotationOf(const Matrix3d& linear) {
  Eigen::JacobiSVD<Matrix3d> svd(linear, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d flip = Matrix3d::Identity();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) flip(2, 2) = -1.0;
  return svd.matrixU() * flip * svd.matrixV().transpose();
}

/// Length along the piece and the girths across it: a frame (along, side, depth) of the template at rest.
Matrix3d pieceFrame(const BodyPiece& piece) {
  const Vector3d along = (piece.to - piece.from).normalized();
  const Vector3d hint = std::abs(along.z()) < 0.9 ? Vector3d::UnitZ() : Vector3d::UnitY();
  Matrix3d B;
  B.col(0) = along;
  B.col(1) = hint.cross(along).normalized();
  B.col(2) = B.col(0).cross(B.col(1));
  return B;
}

/// What the pieces should look like: rotation times stretch along and across, mirrored pieces alike, lengths
/// in a limb near each other's stretch.
std::vector<Matrix3d> shapesOf(const TemplateBody& body, const PieceMaps& maps) {
  const std::size_t n = maps.size();
  std::vector<Matrix3d> R(n), frame(n);
  std::vector<Vector3d> stretch(n);
  for (std::size_t i = 0; i < n; ++i) {
    R[i] = rotationOf(maps[i].linear);
    frame[i] = pieceFrame(body.pieces[i]);
    stretch[i] = (frame[i].transpose() * R[i].transpose() * maps[i].linear * frame[i]).diagonal();
    stretch[i] = stretch[i].cwiseMax(0.2);
  }
  const std::vector<Vector3d> raw = stretch;
  for (std::size_t i = 0; i < n; ++i) {
    stretch[i] = 0.5 * (raw[i] + raw[body.pieces[i].partner]);
    const bool limb = body.pieces[i].partner != static_cast<int>(i) && body.pieces[i].length() > 0.08;
    if (limb) stretch[i].tail<2>().setConstant(stretch[i].tail<2>().mean());
  }
  const std::vector<Vector3d> shared = stretch;
  for (std::size_t i = 0; i < n; ++i)
    if (const int mate = body.pieces[i].mate; mate >= 0)
      stretch[i][0] = 0.5 * shared[i][0] + 0.5 * shared[mate][0];
  std::vector<Matrix3d> out(n);
  for (std::size_t i = 0; i < n; ++i)
    out[i] = R[i] * frame[i] * stretch[i].asDiagonal() * frame[i].transpose();
  return out;
}

/// How a piece turns beside its parent: not at all, but for a shoulder blade, which goes along with an arm
/// that is raised above the horizontal (the scapulohumeral rhythm, Inman, Saunders and Abbott 1944).
Matrix3d turnBesideParent(const TemplateBody& body, const PieceMaps& maps, int piece) {
  constexpr double share = 0.4;
  const int lifter = body.pieces[piece].lifter;
  if (lifter < 0) return Matrix3d::Identity();
  const Matrix3d trunk = rotationOf(maps[body.pieces[piece].parent].linear);
  const Vector3d arm = maps[lifter].linear * (body.pieces[lifter].to - body.pieces[lifter].from);
  const double raised = std::asin(std::clamp(trunk.col(1).dot(arm.normalized()), 0.0, 1.0));
  const double side = body.pieces[piece].to.x() > 0.0 ? 1.0 : -1.0;
  return Eigen::AngleAxisd(side * share * raised, trunk.col(2)).toRotationMatrix();
}

}  // namespace

FitTarget::FitTarget(SurfaceSamples samples, double normalReach)
    : samples_(std::move(samples)), reach_(normalReach), tree_(lifted(samples_, normalReach)) {}

int FitTarget::nearest(const Vector3d& point, const Vector3d& normal) const {
  return tree_.nearest(lifted(point, normal, reach_));
}

std::vector<Vector3d> deformed(const TemplateBody& body, const PieceMaps& maps) {
  std::vector<Vector3d> out(body.surface.positions.size(), Vector3d::Zero());
  for (std::size_t v = 0; v < out.size(); ++v)
    for (const auto& [k, w] : body.weights[v])
      if (w > 0.0)
        out[v] += w * (maps[k].linear * (body.surface.positions[v] - body.pieces[k].from) + maps[k].origin);
  return out;
}

std::vector<Vector3d> deformedJoints(const TemplateBody& body, const PieceMaps& maps) {
  std::vector<Vector3d> out;
  for (const TemplateJoint& joint : body.joints) {
    const auto under = [&](int k) {
      return Vector3d(maps[k].linear * (joint.position - body.pieces[k].from) + maps[k].origin);
    };
    out.push_back(under(joint.piece));
  }
  return out;
}

double fitPieces(const TemplateBody& body, const FitTarget& target, PieceMaps& maps, const FitStage& stage) {
  const auto& rest = body.surface.positions;
  const SurfaceSamples& samples = target.samples();
  const double width2 = stage.robustWidth * stage.robustWidth;
  const std::size_t stride = std::max<std::size_t>(1, rest.size() / stage.vertices),
                    sampleStride = std::max<std::size_t>(1, samples.points.size() / stage.samples);
  std::vector<Matrix3d> A(rest.size());
  std::vector<Vector3d> b(rest.size());
  std::vector<int> active;
  for (std::size_t v = 0; v < rest.size(); v += stride) active.push_back(static_cast<int>(v));
  double error = 0.0;
  for (int round = 0; round < stage.rounds; ++round) {
    const std::vector<Vector3d> now = deformed(body, maps);
    const std::vector<Vector3d> normals = normalsOf(body.surface, now);
    std::fill(A.begin(), A.end(), Matrix3d::Zero());
    std::fill(b.begin(), b.end(), Vector3d::Zero());
    double sum = 0.0, total = 0.0;
    const auto pair = [&](int v, int s, double share) {
      const double d2 = (samples.points[s] - now[v]).squaredNorm();
      const double facing = normals[v].dot(samples.normals[s]);
      sum += share * std::min(facing > 0.2 ? d2 : 1.0, 4.0 * width2), total += share;
      if (facing < 0.2) return;
      const double robust = 1.0 / ((1.0 + d2 / width2) * (1.0 + d2 / width2));
      const double weight = share * robust * body.importance[v] * facing;
      const Vector3d n = (normals[v] + samples.normals[s]).normalized();
      const Matrix3d metric = weight * (n * n.transpose() + stage.pull * Matrix3d::Identity());
      A[v] += metric;
      b[v] += metric * samples.points[s];
    };
    for (const int v : active)
      if (const int s = target.nearest(now[v], normals[v]); s >= 0)
        pair(v, s, 0.5 / static_cast<double>(active.size()));

    std::vector<KdTree<6>::Point> points;
    for (const int v : active) points.push_back(lifted(now[v], normals[v], target.normalReach()));
    const KdTree<6> tree(std::move(points));
    const double share = 0.5 * static_cast<double>(sampleStride) / static_cast<double>(samples.points.size());
    for (std::size_t s = 0; s < samples.points.size(); s += sampleStride)
      pair(active[tree.nearest(lifted(samples.points[s], samples.normals[s], target.normalReach()))],
           static_cast<int>(s), share);
    error = std::sqrt(sum / std::max(total, 1e-300));

    MapEquations equations(body, stage.symmetric);
    for (const int v : active) equations.point(body, rest[v], body.weights[v], A[v], b[v]);
    for (const auto& [v, place, metric] : stage.landmarks)
      equations.point(body, rest[v], body.weights[v], metric, metric * place);
    const std::vector<Matrix3d> shapes = shapesOf(body, maps);
    for (int i = 0; i < static_cast<int>(body.pieces.size()); ++i) {
      const BodyPiece& piece = body.pieces[i];
      const double size = std::max(piece.length(), 0.06);
      equations.shape(i, shapes[i], stage.stiffness * size * size * piece.stiffness);
      if (piece.parent < 0) continue;
      // The joint, as it moves with either piece, stays one point.
      equations.point(body, piece.from, {{{i, 1.0}, {piece.parent, -1.0}}}, 10.0 * Matrix3d::Identity(),
                      Vector3d::Zero());
      equations.together(i, piece.parent, turnBesideParent(body, maps, i),
                         piece.bond * stage.stiffness * size * size);
    }
    equations.solve(maps);
  }
  return error;
}

namespace {

/// Visits the nearest pairs in both directions, either way with a total weight of 1: visit(vertex, sample,
/// weight).
template <class Visit>
void eachPair(const FitTarget& target, const std::vector<Vector3d>& now, const std::vector<Vector3d>& normals,
              Visit visit) {
  const SurfaceSamples& samples = target.samples();
  const int n = static_cast<int>(now.size()), m = static_cast<int>(samples.points.size());
  std::vector<KdTree<6>::Point> points;
  for (int v = 0; v < n; ++v) {
    visit(v, target.nearest(now[v], normals[v]), 1.0 / n);
    points.push_back(lifted(now[v], normals[v], target.normalReach()));
  }
  const KdTree<6> tree(std::move(points));
  for (int s = 0; s < m; ++s)
    visit(tree.nearest(lifted(samples.points[s], samples.normals[s], target.normalReach())), s, 1.0 / m);
}

}  // namespace

std::vector<double> pieceMisfits(const TemplateBody& body, const FitTarget& target, const PieceMaps& maps) {
  const std::vector<Vector3d> now = deformed(body, maps), normals = normalsOf(body.surface, now);
  const SurfaceSamples& samples = target.samples();
  std::vector<double> square(maps.size(), 0.0), weight(maps.size(), 1e-12);
  eachPair(target, now, normals, [&](int v, int s, double share) {
    const double across = 0.5 * (normals[v] + samples.normals[s]).dot(samples.points[s] - now[v]);
    for (const auto& [k, w] : body.weights[v]) {
      square[k] += share * w * across * across;
      weight[k] += share * w;
    }
  });
  for (std::size_t k = 0; k < square.size(); ++k) square[k] = std::sqrt(square[k] / weight[k]);
  return square;
}

double surfaceMisfit(const TemplateBody& body, const FitTarget& target, const PieceMaps& maps) {
  constexpr double grain = 0.02, farthest = 0.06;
  const std::vector<Vector3d> now = deformed(body, maps), normals = normalsOf(body.surface, now);
  const SurfaceSamples& samples = target.samples();
  double square = 0.0;
  eachPair(target, now, normals, [&](int v, int s, double share) {
    const Vector3d gap = samples.points[s] - now[v];
    const double across = 0.5 * (normals[v] + samples.normals[s]).dot(gap),
                 along = std::max(0.0, gap.norm() - grain), d = std::hypot(across, along);
    const bool facing = normals[v].dot(samples.normals[s]) > 0.2;
    square += 0.5 * share * (facing ? std::min(d * d, farthest * farthest) : farthest * farthest);
  });
  return std::sqrt(square);
}

double shapeStrain(const TemplateBody& body, const PieceMaps& maps) {
  std::vector<double> logs;
  for (std::size_t i = 0; i < maps.size(); ++i) {
    const Matrix3d frame = pieceFrame(body.pieces[i]);
    const Matrix3d inPiece = maps[i].linear * frame;
    const double length = inPiece.col(0).norm(), girth = inPiece.col(1).cross(inPiece.col(2)).norm();
    logs.push_back(std::log(length));
    logs.push_back(0.5 * std::log(girth));
  }
  double mean = 0.0, square = 0.0;
  for (const double x : logs) mean += x / static_cast<double>(logs.size());
  for (const double x : logs) square += (x - mean) * (x - mean) / static_cast<double>(logs.size());
  return std::isfinite(square) ? std::sqrt(square) : std::numeric_limits<double>::infinity();
}

void twistPieces(const TemplateBody& body, const FitTarget& target, PieceMaps& maps, bool symmetric) {
  for (int k = 0; k < static_cast<int>(body.pieces.size()); ++k) {
    const BodyPiece& piece = body.pieces[k];
    if (!piece.twists || (symmetric && piece.partner < k)) continue;
    std::vector<int> own;
    for (std::size_t v = 0; v < body.weights.size(); ++v)
      if (body.weights[v][0].first == k && body.weights[v][0].second > 0.5)
        own.push_back(static_cast<int>(v));
    const std::vector<Vector3d> now = deformed(body, maps);
    const std::vector<Vector3d> normals = normalsOf(body.surface, now);
    const Vector3d pivot = maps[k].origin, axis = (maps[k].linear * (piece.to - piece.from)).normalized();
    const auto misfit = [&](const Matrix3d& turn) {
      double sum = 0.0;
      for (const int v : own) {
        const Vector3d p = pivot + turn * (now[v] - pivot), n = turn * normals[v];
        const int s = target.nearest(p, n);
        const double d2 =
            (target.samples().points[s] - p).squaredNorm() +
            target.normalReach() * target.normalReach() * (target.samples().normals[s] - n).squaredNorm();
        sum += std::sqrt(d2);
      }
      return sum;
    };
    double best = 0.0, least = 0.85 * misfit(Matrix3d::Identity());
    for (int step = 1; step < 12; ++step) {
      const double angle = step * M_PI / 6.0;
      const double m = misfit(Eigen::AngleAxisd(angle, axis).toRotationMatrix());
      if (m < least) least = m, best = std::remainder(angle, 2.0 * M_PI);
    }
    if (best == 0.0) continue;
    maps[k].linear = Eigen::AngleAxisd(best, axis).toRotationMatrix() * maps[k].linear;
    PieceMap& parent = maps[piece.parent];
    const BodyPiece& above = body.pieces[piece.parent];
    const Vector3d along = (parent.linear * (above.to - above.from)).normalized();
    parent.linear = Eigen::AngleAxisd(0.5 * best, along).toRotationMatrix() * parent.linear;
    if (!symmetric) continue;
    const Vector3d mirror(-1.0, 1.0, 1.0);
    for (const int left : {k, piece.parent}) {
      PieceMap& right = maps[body.pieces[left].partner];
      right.linear = mirror.asDiagonal() * maps[left].linear * mirror.asDiagonal();
      right.origin = mirror.cwiseProduct(maps[left].origin);
    }
  }
}

std::vector<Vector3d> refineJoints(const TemplateBody& body, const FitTarget& target, const PieceMaps& maps,
                                   const SurfaceStage& stage, std::vector<Vector3d>* surface) {
  using SparseMatrix = Eigen::SparseMatrix<double>;
  const std::vector<Vector3d> start = deformed(body, maps);
  const int n = static_cast<int>(start.size());
  const SurfaceSamples& samples = target.samples();
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& t : body.surface.triangles)
    for (int k = 0; k < 3; ++k) {
      const int i = t[k], j = t[(k + 1) % 3];
      for (const auto& [r, c] : {std::pair(i, i), std::pair(j, j)}) entries.emplace_back(r, c, 0.5);
      entries.emplace_back(std::max(i, j), std::min(i, j), -0.5);
    }
  SparseMatrix laplacian(n, n);
  laplacian.setFromTriplets(entries.begin(), entries.end());

  std::vector<Vector3d> shift(n, Vector3d::Zero());
  Eigen::SimplicialLDLT<SparseMatrix> factor;
  factor.analyzePattern(laplacian);
  const double width2 = stage.robustWidth * stage.robustWidth;
  for (int round = 0; round < stage.rounds; ++round) {
    std::vector<Vector3d> now(n);
    for (int v = 0; v < n; ++v) now[v] = start[v] + shift[v];
    const std::vector<Vector3d> normals = normalsOf(body.surface, now);
    VectorXd weight = VectorXd::Constant(n, 1e-6);
    Eigen::Matrix<double, Eigen::Dynamic, 3> wanted = Eigen::Matrix<double, Eigen::Dynamic, 3>::Zero(n, 3);
    for (int v = 0; v < n; ++v) wanted.row(v) = 1e-6 * shift[v].transpose();
    const auto pair = [&](int v, int s, double share) {
      const Vector3d gap = samples.points[s] - now[v];
      const double facing = normals[v].dot(samples.normals[s]);
      if (facing < 0.3) return;
      const double d2 = gap.squaredNorm();
      const double w = share * facing / ((1.0 + d2 / width2) * (1.0 + d2 / width2));
      weight[v] += w;
      wanted.row(v) += w * (shift[v] + samples.normals[s].dot(gap) * normals[v]).transpose();
    };
    std::vector<KdTree<6>::Point> points;
    for (int v = 0; v < n; ++v) points.push_back(lifted(now[v], normals[v], target.normalReach()));
    const KdTree<6> tree(points);
    for (int v = 0; v < n; ++v) pair(v, target.nearest(now[v], normals[v]), 1.0);
    const double share = static_cast<double>(n) / static_cast<double>(samples.points.size());
    for (std::size_t s = 0; s < samples.points.size(); ++s)
      pair(tree.nearest(lifted(samples.points[s], samples.normals[s], target.normalReach())),
           static_cast<int>(s), share);
    SparseMatrix A = stage.smoothness * laplacian;
    for (int v = 0; v < n; ++v) A.coeffRef(v, v) += weight[v];
    factor.factorize(A);
    const Eigen::Matrix<double, Eigen::Dynamic, 3> moved = factor.solve(wanted);
    for (int v = 0; v < n; ++v) shift[v] = moved.row(v).transpose();
  }
  if (surface) {
    surface->resize(n);
    for (int v = 0; v < n; ++v) (*surface)[v] = start[v] + shift[v];
  }

  std::vector<Vector3d> joints = deformedJoints(body, maps);
  for (std::size_t k = 0; k < joints.size(); ++k) {
    const int piece = body.joints[k].piece, parent = body.pieces[piece].parent;
    double depth = std::numeric_limits<double>::infinity();
    for (int v = 0; v < n; ++v) depth = std::min(depth, (start[v] - joints[k]).norm());
    const double radius = std::max(1.2 * depth, 0.01);
    Eigen::Matrix4d N = Eigen::Matrix4d::Zero();
    Eigen::Matrix<double, 4, 3> b = Eigen::Matrix<double, 4, 3>::Zero();
    for (int v = 0; v < n; ++v) {
      const Vector3d arm = start[v] - joints[k];
      if (arm.norm() > 3.0 * radius) continue;
      double own = 0.0;
      for (const auto& [p, w] : body.weights[v])
        if (p == piece || p == parent || (p >= 0 && body.pieces[p].parent == piece)) own += w;
      const double w = own * std::exp(-arm.squaredNorm() / (radius * radius));
      const Eigen::Vector4d row(arm.x() / radius, arm.y() / radius, arm.z() / radius, 1.0);
      N += w * row * row.transpose();
      b += w * row * shift[v].transpose();
    }
    if (!(N(3, 3) > 1e-9)) continue;
    const double ridge = 0.1 * N(3, 3);
    N.diagonal().head<3>().array() += ridge;
    joints[k] += N.ldlt().solve(b).row(3).transpose();
  }
  if (stage.symmetric) {
    const std::vector<Vector3d> raw = joints;
    for (std::size_t k = 0; k < joints.size(); ++k) {
      const Vector3d& other = raw[body.joints[k].partner];
      joints[k] = 0.5 * (raw[k] + Vector3d(-other.x(), other.y(), other.z()));
    }
  }
  return joints;
}

}  // namespace gelenk
