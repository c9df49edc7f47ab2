#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/solvers/tree/drag_marks.h"

// Where does a drag that cannot be followed end? An independent minimiser of the same objective (Ceres,
// automatic derivatives, its own forward kinematics and parameters, several starts) says what could be had.
// GELENK_DRAG_REFERENCES sets the number of targets and twelve starts for each; by default it is two targets
// of three starts, for the time they take.
namespace gelenk {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using marks::Figure;

template <typename T>
using Vector3 = Eigen::Matrix<T, 3, 1>;
template <typename T>
using Matrix3 = Eigen::Matrix<T, 3, 3>;

/// Swing-twist coordinates from the square |u|, |v| <= 1, which covers the ellipse and nothing else.
template <typename T>
Vector3<T> fromSquare(const BallLimit& limit, const T* p) {
  using std::sqrt;
  return {limit.swingCentre.x() + limit.swingRadii.x() * p[0] * sqrt(1.0 - 0.5 * p[1] * p[1]),
          limit.swingCentre.y() + limit.swingRadii.y() * p[1] * sqrt(1.0 - 0.5 * p[0] * p[0]), p[2]};
}

/// The drag's objective as residuals, one parameter block a joint: axes and displacements; (u, v, tau); or a
/// quaternion after them.
struct DragResiduals {
  const Figure& figure;
  const DragOptions& options;
  const std::vector<double>& stiffness;
  std::vector<Vector3d> targets;

  static constexpr int goalRows = 9 + 2 * 12;

  template <typename T>
  Matrix3<T> ballMatrix(int joint, const T* p) const {
    const Joint& model = figure.skeleton.joint(joint);
    Eigen::Quaternion<T> q;
    if (model.ballLimit) {
      using std::cos, std::sin, std::sqrt;
      const Vector3<T> c = fromSquare(*model.ballLimit, p);
      const T x = 0.5 * c[0], y = 0.5 * c[1];
      q = Eigen::Quaternion<T>(sqrt(1.0 - x * x - y * y), x, y, T(0.0)) *
          Eigen::Quaternion<T>(cos(0.5 * c[2]), T(0.0), T(0.0), sin(0.5 * c[2]));
    } else {
      q = Eigen::Quaternion<T>(p[0], p[1], p[2], p[3]);
    }
    return q.toRotationMatrix();
  }

  template <typename T>
  bool operator()(T const* const* p, T* r) const {
    const Skeleton& skeleton = figure.skeleton;
    std::vector<Matrix3<T>> R(skeleton.jointCount());
    std::vector<Vector3<T>> x(skeleton.jointCount());
    int posture = goalRows;
    for (int i = 0; i < skeleton.jointCount(); ++i) {
      const Joint& joint = skeleton.joint(i);
      const Matrix3<T> offset = joint.parentFromZero.linear().template cast<T>();
      const Vector3<T> at = joint.parentFromZero.translation().template cast<T>();
      R[i] = i == 0 ? offset : Matrix3<T>(R[joint.parent] * offset);
      x[i] = i == 0 ? at : Vector3<T>(x[joint.parent] + R[joint.parent] * at);
      int k = 0;
      for (const AxisDof& dof : joint.axes) {
        const Vector3<T> axis = dof.axis.template cast<T>();
        if (dof.kind == AxisDof::Kind::Translation)
          x[i] += R[i] * axis * p[i][k];
        else
          R[i] = R[i] * Eigen::AngleAxis<T>(p[i][k], axis).toRotationMatrix();
        const double s = stiffness[skeleton.vIndex(i) + k];
        r[posture++] = std::sqrt(options.posture * s) * (p[i][k] - skeleton.rest()[skeleton.qIndex(i) + k]);
        ++k;
      }
      if (!joint.ball) continue;
      R[i] = R[i] * ballMatrix(i, p[i] + k);
      const double weight = std::sqrt(options.posture * stiffness[skeleton.vIndex(i) + k]);
      const Eigen::Quaterniond rest = ballRotation(skeleton, skeleton.rest(), i);
      if (joint.ballLimit) {
        const Vector3<T> c = fromSquare(*joint.ballLimit, p[i] + k);
        const Vector3d c0 = swingTwistCoordinates(rest);
        for (int j = 0; j < 3; ++j) r[posture++] = weight * (c[j] - c0[j]);
      } else {  // 2 sin(angle / 2), which is the angle for the small turns of a figure on its feet
        const Eigen::Quaternion<T> q(p[i][k], p[i][k + 1], p[i][k + 2], p[i][k + 3]);
        const Eigen::Quaternion<T> turned = rest.conjugate().cast<T>() * q;
        for (int j = 0; j < 3; ++j) r[posture++] = weight * 2.0 * turned.vec()[j];
      }
    }
    int row = 0;
    for (int k = 0; k < Figure::dragCount; ++k) {
      const int joint = figure.dragJoint(k);
      const Vector3<T> e =
          targets[k].template cast<T>() - x[joint] - R[joint] * figure.dragPoint(k).template cast<T>();
      for (int j = 0; j < 3; ++j) r[row++] = e[j];
    }
    for (const int foot : figure.feet) {
      const Eigen::Isometry3d& wanted = figure.startFrames[foot];
      for (int j = 0; j < 3; ++j)
        r[row++] = std::sqrt(options.pinWeight) * (wanted.translation()[j] - x[foot][j]);
      const double weight = std::sqrt(options.pinWeight / 3.0) * options.poseArm;
      for (int j = 0; j < 9; ++j) r[row++] = weight * (wanted.linear()(j / 3, j % 3) - R[foot](j / 3, j % 3));
    }
    return true;
  }
};

struct Reference {
  double cost = std::numeric_limits<double>::infinity();
  std::vector<Vector3d> reached;
  double error = 0.0;  ///< root of the summed squared distances of the dragged points
};

double sumOfDistances(const std::vector<Vector3d>& a, const std::vector<Vector3d>& b) {
  double sum = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += (a[k] - b[k]).squaredNorm();
  return std::sqrt(sum);
}

std::vector<Vector3d> draggedPoints(const Figure& figure, const VectorXd& q) {
  const Frames frames = forwardKinematics(figure.skeleton, q);
  std::vector<Vector3d> points;
  for (int k = 0; k < Figure::dragCount; ++k) points.push_back(figure.dragged(frames, k));
  return points;
}

/// Parameters of a configuration, block by block.
std::vector<std::vector<double>> parametersOf(const Figure& figure, const VectorXd& q) {
  const Skeleton& skeleton = figure.skeleton;
  std::vector<std::vector<double>> blocks(skeleton.jointCount());
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const Joint& joint = skeleton.joint(i);
    const int axes = static_cast<int>(joint.axes.size()), at = skeleton.qIndex(i);
    for (int k = 0; k < axes; ++k)
      blocks[i].push_back(std::clamp(q[at + k], joint.axes[k].lower, joint.axes[k].upper));
    if (!joint.ball) continue;
    if (!joint.ballLimit) {
      for (int k = 0; k < 4; ++k) blocks[i].push_back(q[at + axes + k]);
      continue;
    }
    const Vector3d c = swingTwistCoordinates(ballRotation(skeleton, q, i));
    const double a = (c.x() - joint.ballLimit->swingCentre.x()) / joint.ballLimit->swingRadii.x();
    const double b = (c.y() - joint.ballLimit->swingCentre.y()) / joint.ballLimit->swingRadii.y();
    // u = a / sqrt(1 - v^2 / 2), v = b / sqrt(1 - u^2 / 2): a few rounds are enough for a start.
    double u = a, v = b;
    for (int round = 0; round < 30; ++round) {
      u = std::clamp(a / std::sqrt(1.0 - 0.5 * v * v), -0.98, 0.98);
      v = std::clamp(b / std::sqrt(1.0 - 0.5 * u * u), -0.98, 0.98);
    }
    blocks[i] = {u, v, c.z()};
  }
  return blocks;
}

Reference minimise(const Figure& figure, const DragOptions& options, const std::vector<Vector3d>& targets,
                   const VectorXd& start) {
  const Skeleton& skeleton = figure.skeleton;
  const std::vector<double> stiffness = postureStiffness(skeleton);
  std::vector<std::vector<double>> blocks = parametersOf(figure, start);
  const DragResiduals functor{figure, options, stiffness, targets};
  auto* cost = new ceres::DynamicAutoDiffCostFunction<DragResiduals, 12>(new DragResiduals(functor));
  ceres::Problem problem;
  std::vector<double*> pointers;
  for (auto& block : blocks) {
    cost->AddParameterBlock(std::max<int>(1, static_cast<int>(block.size())));
    if (block.empty()) block.push_back(0.0);
    pointers.push_back(block.data());
  }
  cost->SetNumResiduals(DragResiduals::goalRows + skeleton.nv());
  problem.AddResidualBlock(cost, nullptr, pointers);
  std::vector<char> onPath(skeleton.jointCount(), 0);
  for (int joint : {figure.hands[0], figure.hands[1], figure.head, figure.feet[0], figure.feet[1]})
    for (; joint >= 0; joint = skeleton.parent(joint)) onPath[joint] = 1;
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const Joint& joint = skeleton.joint(i);
    if (!onPath[i] || skeleton.vCount(i) == 0) {
      problem.SetParameterBlockConstant(pointers[i]);
      continue;
    }
    const int axes = static_cast<int>(joint.axes.size());
    for (int k = 0; k < axes; ++k) {
      if (std::isfinite(joint.axes[k].lower))
        problem.SetParameterLowerBound(pointers[i], k, joint.axes[k].lower);
      if (std::isfinite(joint.axes[k].upper))
        problem.SetParameterUpperBound(pointers[i], k, joint.axes[k].upper);
    }
    if (joint.ballLimit) {
      for (int k = 0; k < 2; ++k) {
        problem.SetParameterLowerBound(pointers[i], k, -1.0);
        problem.SetParameterUpperBound(pointers[i], k, 1.0);
      }
      problem.SetParameterLowerBound(pointers[i], 2, joint.ballLimit->twistLower);
      problem.SetParameterUpperBound(pointers[i], 2, joint.ballLimit->twistUpper);
    } else if (joint.ball) {
      problem.SetManifold(
          pointers[i], new ceres::ProductManifold<ceres::EuclideanManifold<3>, ceres::QuaternionManifold>());
    }
  }
  ceres::Solver::Options solverOptions;
  solverOptions.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  solverOptions.max_num_iterations = 200;
  solverOptions.function_tolerance = 1e-8;
  solverOptions.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solverOptions, &problem, &summary);

  VectorXd q = skeleton.rest();
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const Joint& joint = skeleton.joint(i);
    const int axes = static_cast<int>(joint.axes.size());
    for (int k = 0; k < axes; ++k) q[skeleton.qIndex(i) + k] = blocks[i][k];
    if (joint.ballLimit)
      setBallRotation(skeleton, q, i,
                      fromSwingTwistCoordinates(fromSquare(*joint.ballLimit, blocks[i].data())));
    else if (joint.ball)
      setBallRotation(
          skeleton, q, i,
          Eigen::Quaterniond(blocks[i][axes], blocks[i][axes + 1], blocks[i][axes + 2], blocks[i][axes + 3]));
  }
  Reference found{.cost = summary.final_cost, .reached = draggedPoints(figure, q), .error = 0.0};
  found.error = sumOfDistances(found.reached, targets);
  return found;
}

TEST(DragReference, PartlyUnreachableDragsEndInTheMinimumOfATwelveStartCeresSearch) {
  const char* wanted = std::getenv("GELENK_DRAG_REFERENCES");
  const int count = wanted != nullptr ? std::atoi(wanted) : 2, starts = wanted != nullptr ? 12 : 3;
  const Figure figure;
  const DragOptions options;
  DragSolver solver(figure.skeleton, options);
  std::mt19937_64 random(77);
  RecordProperty("seed", 77);
  int same = 0, within = 0;
  for (int i = 0; i < count; ++i) {
    const marks::Path path = marks::reachablePath(figure, random, 60, 0.03);
    std::vector<Vector3d> targets = path.back();
    const int pushed = static_cast<int>(random() % 3);  // one of the three goes out of reach
    targets[pushed] += (0.2 + 0.3 * uniform01(random)) * (targets[pushed] - Vector3d(0, 1.2, 0)).normalized();
    solver.reset(figure.start);
    marks::follow(figure, solver, path, 0.03);
    marks::Path outwards;
    for (int frame = 1; frame <= 20; ++frame) {
      outwards.push_back(path.back());
      outwards.back()[pushed] += frame / 20.0 * (targets[pushed] - path.back()[pushed]);
    }
    marks::follow(figure, solver, outwards, 0.03);
    marks::follow(figure, solver, marks::Path(200, targets), 0.0);
    const std::vector<Vector3d> reached = draggedPoints(figure, solver.q());
    const double error = sumOfDistances(reached, targets);

    Reference best;
    for (int start = 0; start < starts; ++start) {
      const VectorXd from = start == 0 ? figure.start : marks::halfRangePose(figure.skeleton, random);
      const Reference found = minimise(figure, options, targets, from);
      if (found.cost < best.cost) best = found;
    }
    double apart = 0.0;
    for (std::size_t k = 0; k < reached.size(); ++k)
      apart = std::max(apart, (reached[k] - best.reached[k]).norm());
    // 4 cm: the bounded corrections of three targets and two feet shift a conflict; other minima lie farther
    // off.
    same += apart <= 0.04;
    within += error <= 1.05 * best.error + 1e-3;
    if (i % 10 == 9)
      std::fprintf(stderr, "%d of %d so far, same minimum %d, within 5 %% %d\n", i + 1, count, same, within);
    if (apart > 0.04)
      std::printf("target %d: drag error %.4f m, reference %.4f m, points %.4f m apart\n", i, error,
                  best.error, apart);
  }
  std::printf("same minimum %d of %d, error within 5 %% on %d\n", same, count, within);
  EXPECT_GE(same, 0.9 * count - 1.0);  // one miss is a third of a small count
  EXPECT_GE(within, 0.95 * count - 1.0);
}

}  // namespace
}  // namespace gelenk
