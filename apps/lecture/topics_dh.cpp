// Lecture 10.2: Denavit-Hartenberg.

#include <random>

#include "apps/lecture/derivations.h"
#include "apps/lecture/example.h"
#include "apps/lecture/text.h"
#include "kinematics/configuration.h"
#include "kinematics/notation/dh_table.h"
#include "kinematics/notation/robots.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double degree = M_PI / 180.0;

/// A chain of four turning axes, pairwise skew, crossing, parallel; and a fifth that coincides with the
/// fourth.
const std::vector<AxisLine>& exampleAxes() {
  static const std::vector<AxisLine> axes{{{0, 0, 0}, {0, 0, 1}},
                                          {{0.4, 0.1, 0.5}, {0, 1, 0.5}},
                                          {{0.4, 0.3, 0.6}, {1, 0, 0}},
                                          {{0.4, 0.3, 1.0}, {1, 0, 0}},
                                          {{0.9, 0.3, 1.0}, {1, 0, 0}}};
  return axes;
}

double linesApart(const AxisLine& one, const AxisLine& other) {
  const Vector3d u = one.direction.normalized();
  return std::max((u - other.direction.normalized()).norm(), (other.point - one.point).cross(u).norm());
}

double axesApart() {
  const DhTable table = dhFromAxes(exampleAxes());
  const auto again = jointAxes(table, VectorXd::Zero(table.variableCount()));
  double apart = 0.0;
  for (std::size_t i = 0; i < again.size(); ++i)
    apart = std::max(apart, linesApart(exampleAxes()[i], again[i]));
  return apart;
}

/// Largest difference of any matrix entry over 200 random configurations of every robot.
template <typename Difference>
double overAllRobots(Difference difference) {
  std::mt19937_64 random(1);
  double apart = 0.0;
  for (const Robot& robot : robots()) {
    const DhTable table = robot.table();
    const Skeleton skeleton = toSkeleton(table);
    for (int i = 0; i < 200; ++i)
      apart = std::max(apart, difference(table, skeleton, randomWithinLimits(skeleton, random)));
  }
  return apart;
}

double chainAgainstSkeleton() {
  return overAllRobots([](const DhTable& table, const Skeleton& skeleton, const VectorXd& q) {
    return (dhFrames(table, q).back().matrix() - forwardKinematics(skeleton, q).back().matrix())
        .cwiseAbs()
        .maxCoeff();
  });
}

double conventionsApart() {
  return overAllRobots([](const DhTable& table, const Skeleton&, const VectorXd& q) {
    const DhConvention other =
        table.convention == DhConvention::Modified ? DhConvention::Standard : DhConvention::Modified;
    return (dhFrames(table, q).back().matrix() - dhFrames(toConvention(table, other), q).back().matrix())
        .cwiseAbs()
        .maxCoeff();
  });
}

/// The slide's T = R(x, alpha) T(a, 0, d) R(z, phi) multiplied out by hand against the product.
double rowAgainstHand() {
  const DhRow row{.a = 0.3, .alpha = 0.4, .d = 0.5, .phi = 0.6};
  const double ca = std::cos(row.alpha), sa = std::sin(row.alpha), cp = std::cos(row.phi),
               sp = std::sin(row.phi);
  Eigen::Matrix4d hand;
  hand << cp, -sp, 0, row.a, ca * sp, ca * cp, -sa, -sa * row.d, sa * sp, sa * cp, ca, ca * row.d, 0, 0, 0, 1;
  return (dhTransform(row, DhConvention::Modified, 0.0).matrix() - hand).cwiseAbs().maxCoeff();
}

std::string tableText(const DhTable& table) {
  std::string out = text::heads({"kind", "a [m]", "alpha [deg]", "d [m]", "phi [deg]"});
  const auto number = [](double value) {
    return fmt::format("{:.6g}", std::abs(value) < 1e-12 ? 0.0 : value);
  };
  for (const DhRow& row : table.rows)
    out += text::row({toString(row.kind), number(row.a), number(row.alpha / degree), number(row.d),
                      number(row.phi / degree)});
  return out;
}

std::string steps() {
  std::string out =
      "T_(i -> i+1) = R(x, alpha_i) T(a_i, 0, d_i) R(z, phi_i): the modified (Craig) convention.\n";
  out +=
      "Standard convention: R(z, phi_i) T(0, 0, d_i) T(a_i, 0, 0) R(x, alpha_i), the fixed part after the "
      "variable.\n\n";
  out +=
      "From axes to parameters. K_i stands on axis i where the common normal to axis i + 1 begins, x_i along "
      "it:\n" +
      text::heads({"axes", "", "a [m]", "alpha [deg]", "normal from", "", "", "to", "", ""});
  const auto& axes = exampleAxes();
  Vector3d near = Vector3d::Zero(), x = Vector3d::UnitX();
  for (std::size_t i = 0; i + 1 < axes.size(); ++i) {
    const CommonNormal n = commonNormal(axes[i], axes[i + 1], near, x);
    std::vector<std::string> cells{fmt::format("{} and {}", i + 1, i + 2), toString(n.kind),
                                   text::fixed(n.a, 4), text::fixed(n.alpha / degree, 4)};
    text::append(cells, n.footOnFirst, 3);
    text::append(cells, n.footOnSecond, 3);
    out += text::row(cells);
    near = n.footOnSecond;
    x = n.x;
  }
  const DhTable table = dhFromAxes(axes);
  out += fmt::format(
      "  K_1 at {}, parameters:\n{}  and back: the axes of this table differ from the given lines by "
      "{:.1e}\n",
      text::point(table.base.translation()), tableText(table), axesApart());
  out += fmt::format("  parameters counted: 4 n + 3 = {} for n = {}\n\n", parameterCount(table),
                     table.rows.size());
  for (const Robot& robot : robots()) {
    const DhTable r = robot.table();
    const Isometry3d tool = dhFrames(r, *r.rest).back();
    out += fmt::format("{} ({} convention, {} parameters), tool at rest {}\n{}", robot.title,
                       toString(r.convention), parameterCount(r), text::point(tool.translation(), 7),
                       tableText(r));
  }
  out += fmt::format(
      "\nOver 200 random configurations a robot: product of matrices against skeleton {:.1e}, one convention "
      "against the other {:.1e}\n",
      chainAgainstSkeleton(), conventionsApart());
  return out;
}

}  // namespace

std::string dhDerivation(const DhTable& table, const VectorXd& q) {
  std::string out =
      table.convention == DhConvention::Modified
          ? "T_(i -> i+1) = R(x, alpha_i) T(a_i, 0, d_i) R(z, phi_i), the modified convention\n\n"
          : "T_(i -> i+1) = R(z, phi_i) T(0, 0, d_i) T(a_i, 0, 0) R(x, alpha_i), the standard "
            "convention\n\n";
  out += text::heads(
      {"i", "a_i [m]", "alpha_i [deg]", "d_i [m]", "phi_i [deg]", "origin of K_(i+1) [m]", "", ""});
  const Frames K = dhFrames(table, q);
  Eigen::Index variable = 0;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const DhRow& row = table.rows[i];
    const double value = row.kind == DhJoint::Fixed ? 0.0 : q[variable++];
    const double d = row.d + (row.kind == DhJoint::Prismatic ? value : 0.0),
                 phi = row.phi + (row.kind == DhJoint::Revolute ? value : 0.0);
    std::vector<std::string> cells{std::to_string(i + 1), text::fixed(row.a, 4),
                                   text::fixed(row.alpha / degree, 2), text::fixed(d, 4),
                                   text::fixed(phi / degree, 2)};
    text::append(cells, K[i + 1].translation(), 5);
    out += text::row(cells);
  }
  return out + fmt::format("\nThe tool's frame, base T_1 ... T_{} tool =\n{}", table.rows.size(),
                           text::matrix(K.back().matrix(), 6));
}

LectureTopic denavitHartenbergTopic() {
  const std::string section = "10.2, Denavit-Hartenberg";
  LectureTopic topic{
      .id = "dh", .section = "10.2", .title = "Denavit-Hartenberg chains", .steps = &steps, .checks = {}};
  topic.checks = {
      {.id = "dh-row",
       .section = section,
       .what = "R(x, alpha) T(a, 0, d) R(z, phi) against the matrix multiplied out",
       .printed = {1e-15},
       .tolerance = {0},
       .compute = [] { return std::vector{rowAgainstHand()}; },
       .comparison = Comparison::AtMost},
      {.id = "dh-skeleton",
       .section = section,
       .what = "five robots: chain of matrices equals skeleton",
       .printed = {1e-14},
       .tolerance = {0},
       .compute = [] { return std::vector{chainAgainstSkeleton()}; },
       .comparison = Comparison::AtMost,
       .note = "modified and standard convention, revolute and prismatic joints"},
      {.id = "dh-conventions",
       .section = section,
       .what = "modified and standard turned into each other: same tool frame",
       .printed = {1e-14},
       .tolerance = {0},
       .compute = [] { return std::vector{conventionsApart()}; },
       .comparison = Comparison::AtMost},
      {.id = "dh-axes",
       .section = section,
       .what = "axes (skew, crossing, parallel, coincident) to parameters and back",
       .printed = {1e-12},
       .tolerance = {0},
       .compute = [] { return std::vector{axesApart()}; },
       .comparison = Comparison::AtMost,
       .note = "the slide says the shortest connection always exists; for parallel and crossing axes it is "
               "not unique and a choice is made"},
      {.id = "dh-parameters",
       .section = section,
       .what = "4 n + 3 parameters, n = 6 (ur5)",
       .printed = {27},
       .tolerance = {0},
       .compute = [] { return std::vector<double>{static_cast<double>(parameterCount(robotTable("ur5")))}; }},
      {.id = "dh-panda-zero",
       .section = "10.2 on a real robot",
       .what = "panda, q = 0: flange at (0.088, 0, 0.926) m",
       .printed = {0.088, 0.0, 0.926},
       .tolerance = {5e-4},
       .compute =
           [] { return text::list(dhFrames(robotTable("panda"), VectorXd::Zero(7)).back().translation()); },
       .note = "0.333 + 0.316 + 0.384 - 0.107 above the base"},
  };
  return topic;
}

}  // namespace gelenk
