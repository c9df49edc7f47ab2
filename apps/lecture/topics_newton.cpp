// Lecture 10.1.4: Newton's method in one and several dimensions, the pseudo-inverse, and the claim of the
// shortest way.

#include <Eigen/LU>
#include <Eigen/SVD>
#include <random>

#include "apps/lecture/derivations.h"
#include "apps/lecture/example.h"
#include "apps/lecture/newton_runs.h"
#include "apps/lecture/slide_data.h"
#include "apps/lecture/text.h"
#include "kinematics/configuration.h"
#include "solvers/ceres/nearest_solution.h"

namespace gelenk {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

NewtonRun planarNewton(const PlanarChain& chain, const VectorXd& phi, const Vector2d& X, double tolerance,
                       int maxSteps) {
  return newton([&](const VectorXd& p) -> VectorXd { return endEffector(chain, p); },
                [&](const VectorXd& p) -> MatrixXd { return jacobian(chain, p); }, phi, X, tolerance,
                maxSteps);
}

const NewtonRun& lectureNewtonRun() {
  const PlanarChain chain = lecturePlanarChain();
  static const NewtonRun run =
      planarNewton(chain, slide::startAngles, slide::newTarget, 1e-12 * chain.reach());
  return run;
}

double oneLinkHeight(double phi) { return slide::armLength * std::sin(phi); }

namespace {

constexpr double degree = M_PI / 180.0;

// --- one dimension
// ---------------------------------------------------------------------------------------------

constexpr double goodStart = slide::oneLinkStart, farStart = 1.2;

std::vector<NewtonStep1d> convergentRun(double delta = 1e-6) {
  return newton1d(oneLinkHeight, goodStart, oneLinkTarget, delta, 1e-13);
}
/// Towards height 0: near phi = 0 a zero, but beyond |phi| = 1.1656 (tan phi = 2 phi) the tangent leads away
/// from it.
std::vector<NewtonStep1d> divergentRun() { return newton1d(oneLinkHeight, farStart, 0.0, 1e-6, 1e-13); }

std::vector<double> errorsOf(const std::vector<NewtonStep1d>& run, double zero) {
  std::vector<double> errors;
  for (const NewtonStep1d& step : run) errors.push_back(step.phi - zero);
  return errors;
}

std::string table(const std::vector<NewtonStep1d>& run, double zero) {
  std::string out = text::heads({"i", "phi^i [rad]", "g = f - X", "quotient", "|phi^i - zero|"});
  for (std::size_t i = 0; i < run.size(); ++i)
    out += text::row({std::to_string(i), text::fixed(run[i].phi, 12), text::scientific(run[i].g),
                      text::fixed(run[i].slope, 6), text::scientific(std::abs(run[i].phi - zero))});
  return out;
}

const char* const oneDimensionFormula =
    "phi^(i+1) = phi^i - (f(phi^i) - X) / f'(phi^i),  f'(phi) ~ (f(phi + Delta) - f(phi)) / Delta\n\n";

std::string oneDimensionSteps() {
  std::string out = fmt::format(
      "One-link arm, l = {:g}; f(phi) = l sin phi is the end-effector's height. X = {:g}, so phi = 30 "
      "degrees.\n",
      slide::armLength, oneLinkTarget);
  out += oneDimensionFormula;
  out += fmt::format("Start {:g}, Delta = 1e-6:\n{}", goodStart, table(convergentRun(), M_PI / 6));
  out += fmt::format("  order of convergence, from the last three errors: {:.3f}\n\n",
                     convergenceOrder(errorsOf(convergentRun(), M_PI / 6), 1e-11));
  out += fmt::format("A coarse quotient, Delta = 0.1, bends the tangent: order {:.3f}\n{}\n",
                     convergenceOrder(errorsOf(convergentRun(0.1), M_PI / 6), 1e-12),
                     table(convergentRun(0.1), M_PI / 6));
  out += fmt::format(
      "Divergence: X = 0 from phi = {:g}. Beyond |phi| = 1.1656, where tan phi = 2 phi, each tangent leads "
      "farther from the zero at 0:\n{}",
      farStart, table(divergentRun(), 0.0));
  out += "  the iteration leaves for another zero of the sine, half a turn or more away: the arm jumps.\n";
  return out;
}

// --- n = m
// -----------------------------------------------------------------------------------------------------

PlanarChain twoLinkArm() {
  return {.base = Vector2d::Zero(), .lengths = {slide::armLength, slide::armLength}};
}
using slide::squareStart;
NewtonRun squareRun() { return planarNewton(twoLinkArm(), squareStart, slide::armTarget, 1e-12); }

double stepNearStraight(double phi2) {
  return planarNewton(twoLinkArm(), Vector2d(0.3, phi2), slide::armTarget, 1e-12, 1).steps[0].step.norm();
}

std::string runTable(const NewtonRun& run) {
  const NewtonStep& first = run.steps.front();
  std::vector<std::string> heads{"i"};
  text::appendHead(heads, "phi^i [rad]", first.phi.size());
  text::appendHead(heads, "f(phi^i)", first.f.size());
  heads.insert(heads.end(), {"|g|", "sigma_max", "sigma_min", "|step|"});
  std::string out = text::heads(heads);
  for (std::size_t i = 0; i < run.steps.size(); ++i) {
    const NewtonStep& s = run.steps[i];
    std::vector<std::string> cells{std::to_string(i)};
    text::append(cells, s.phi, 6);
    text::append(cells, s.f, 4);
    cells.insert(cells.end(), {text::scientific(s.g.norm()), text::fixed(s.singularValues[0], 2),
                               text::fixed(s.singularValues.tail<1>()[0], 2),
                               s.step.size() ? text::scientific(s.step.norm()) : "-"});
    out += text::row(cells);
  }
  return out;
}

/// A step of the run in full; i counts from 0 as on the slides.
std::string stepInFull(const PlanarChain& chain, const NewtonRun& run, std::size_t i) {
  const NewtonStep& s = run.steps[i];
  std::string out = fmt::format("Step {} in full\n", i + 1);
  std::vector<std::string> heads{""}, x{"x"}, y{"y"};
  const auto points = linkPoints(chain, s.phi);
  for (std::size_t k = 0; k < points.size(); ++k) {
    heads.push_back(fmt::format("P_{}", k + 1));
    x.push_back(text::fixed(points[k].x(), 6));
    y.push_back(text::fixed(points[k].y(), 6));
  }
  out += text::heads(heads) + text::row(x) + text::row(y);
  out += fmt::format("  f(phi^{}) = {}\n  g = f(phi^{}) - X^neu = {}\n", i, text::point(s.f), i,
                     text::point(s.g));
  out += fmt::format("    D_f = (column i: X - P_i turned by 90 degrees)\n{}", text::matrix(s.D, 8));
  const bool square = chain.linkCount() == 2;
  if (s.Dplus.size() == 0) return out + "  D_f has no inverse here: the method stops\n";
  if (square)
    out += fmt::format("    D_f^-1 =\n{}", text::matrix(s.Dplus, 7));
  else
    out += fmt::format("    D_f D_f^T =\n{}    D_f^+ = D_f^T (D_f D_f^T)^-1 =\n{}",
                       text::matrix(s.D * s.D.transpose(), 8), text::matrix(s.Dplus, 7));
  out += fmt::format("  singular values {}\n", text::point(s.singularValues));
  if (s.step.size() == 0 || i + 1 >= run.steps.size()) return out;
  out += fmt::format("  step = -D_f^{} g = {}\n  phi^{} = {}\n", square ? "-1" : "+", text::point(s.step),
                     i + 1, text::point(run.steps[i + 1].phi, 10));
  out += fmt::format("  where the linear function leads: {}; where the arm really goes: f(phi^{}) = {}\n",
                     text::point(s.linearised, 10), i + 1, text::point(run.steps[i + 1].f, 10));
  return out;
}

std::string given(const PlanarChain& chain, const VectorXd& phi, const Vector2d& X) {
  return fmt::format("P_1 = {}, l = {}, phi^alt = {}, X^neu = {}\n", text::point(chain.base),
                     text::point(VectorXd::Map(chain.lengths.data(), chain.linkCount())), text::point(phi),
                     text::point(X));
}

std::string squareSteps() {
  const NewtonRun run = squareRun();
  std::string out = given(twoLinkArm(), squareStart, slide::armTarget) + "Two links, n = m = 2.\n";
  out += "phi^(i+1) = phi^i - D_f(phi^i)^-1 (f(phi^i) - X)\n\n" + runTable(run) + "\n" +
         stepInFull(twoLinkArm(), run, 0);
  out +=
      "\nThe straight arm: det D_f = l_1 l_2 sin phi_2, so the inverse does not exist at phi_2 = 0, and next "
      "to it the step explodes:\n" +
      text::heads({"phi_2", "|det D_f|", "sigma_min", "|step| [rad]"});
  for (const double phi2 : {0.1, 0.01, 0.001, 1e-4, 0.0}) {
    const NewtonRun straight = planarNewton(twoLinkArm(), Vector2d(0.3, phi2), slide::armTarget, 1e-12, 1);
    const NewtonStep& s = straight.steps[0];
    out += text::row({fmt::format("{:g}", phi2), text::scientific(std::abs(s.D.determinant())),
                      text::scientific(s.singularValues[1]),
                      s.step.size() ? fmt::format("{:.4g}", s.step.norm()) : "no inverse"});
  }
  return out;
}

// --- n > m
// -----------------------------------------------------------------------------------------------------

const NewtonStep& firstStep() { return lectureNewtonRun().steps[0]; }
const NewtonStep& secondStep() { return lectureNewtonRun().steps[1]; }

/// Part of the first step that lies in the null space of D_f: 0 for the shortest of all solutions.
double nullSpacePart() {
  const NewtonStep& s = firstStep();
  return ((MatrixXd::Identity(3, 3) - s.Dplus * s.D) * s.step).norm();
}

/// Of other solutions of D_f d = -g, step + null vector, the smallest length relative to the step's.
double shortestOther() {
  const NewtonStep& s = firstStep();
  const MatrixXd N = MatrixXd::Identity(3, 3) - s.Dplus * s.D;
  std::mt19937_64 random(1);
  double shortest = 1e300;
  for (int i = 0; i < 1000; ++i) {
    Eigen::Vector3d z;
    for (double& c : z) c = uniform01(random) - 0.5;  // one after the other: arguments have no order
    shortest = std::min(shortest, (s.step + N * z).norm() / s.step.norm());
  }
  return shortest;
}

std::string pseudoInverseSteps() {
  const PlanarChain chain = lecturePlanarChain();
  std::string out =
      given(chain, slide::startAngles, slide::newTarget) + "\n" + stepInFull(chain, lectureNewtonRun(), 0);
  out +=
      "  The slide prints phi^1 = (0.295, 1., -0.833): \"1.\" stands for 1.00419, and its f(phi^1) = "
      "(336.44, 681.27) belongs to the unrounded angles; the rounded ones give " +
      text::point(endEffector(chain, Eigen::Vector3d(0.295, 1.0, -0.833)), 8) + ".\n\n";
  out += "On to |g| <= 1e-12 (l_1 + l_2 + l_3):\n" + runTable(lectureNewtonRun());
  out += fmt::format("  {} iterations\n\n", lectureNewtonRun().iterations());
  out += fmt::format(
      "Shortest of all solutions of D_f d = -g: null-space part of the step {:.1e}; of 1,000 others the "
      "shortest is {:.6f} times as long.\n",
      nullSpacePart(), shortestOther());
  return out;
}

// --- the minimum over all solutions
// ----------------------------------------------------------------------------

const NearestSolution& trueMinimum() {
  static const NearestSolution found = nearestSolution(lecturePlanarChain(), slide::startAngles,
                                                       slide::newTarget, lectureNewtonRun().steps.back().phi);
  return found;
}
double newtonDistance() { return (lectureNewtonRun().steps.back().phi - slide::startAngles).norm(); }

/// Newton's end relative to the true minimum when the target is moved there in small steps: the ratio for
/// `pieces` steps.
double pathRatio(int pieces) {
  const PlanarChain chain = lecturePlanarChain();
  const Vector2d from = endEffector(chain, slide::startAngles);
  VectorXd phi = slide::startAngles;
  for (int i = 1; i <= pieces; ++i)
    phi = planarNewton(chain, phi, from + (slide::newTarget - from) * i / pieces, 1e-9).steps.back().phi;
  return (phi - slide::startAngles).norm() / trueMinimum().distance;
}

std::string shortestSteps() {
  std::string out = shortestDerivation(lecturePlanarChain(), slide::startAngles,
                                       lectureNewtonRun().steps.back().phi, trueMinimum()) +
                    "\n";
  out +=
      "Moving the target there in more, smaller steps (as dragging does) follows the pseudo-inverse's path, "
      "not the minimum:\n" +
      text::heads({"steps", "longer by [%]"});
  for (const int pieces : {1, 2, 5, 20, 100})
    out += text::row({std::to_string(pieces), text::fixed(100 * (pathRatio(pieces) - 1), 4)});
  out +=
      "The claim holds for each linearised step, and for the whole only to first order in the distance to "
      "the target.\n";
  return out;
}

}  // namespace

std::string oneDimensionDerivation(double start, double X, double delta) {
  constexpr std::size_t shown = 16;
  std::vector<NewtonStep1d> run = newton1d(oneLinkHeight, start, X, delta, 1e-13);
  const double end = run.back().phi;
  const bool converged = std::abs(run.back().g) < 1e-12;
  std::string out = fmt::format(
      "One-link arm, l = {:g}; f(phi) = l sin phi is the end-effector's height. X = {:.6g}.\n{}Start {:.6g}, "
      "Delta = {:g}:\n",
      slide::armLength, X, oneDimensionFormula, start, delta);
  std::vector<double> errors = errorsOf(run, end);
  errors.pop_back();
  if (run.size() > shown) run.resize(shown);
  out += table(run, end);
  if (!converged) return out + "  no zero is found: the iteration wanders\n";
  out += fmt::format("  ends at phi = {:.10g} = {:.8g} degrees\n", end, end / degree);
  if (errors.size() >= 3)
    out += fmt::format("  order of convergence, from the last three errors: {:.3f}\n",
                       convergenceOrder(errors, 1e-11));
  return out;
}

std::string newtonDerivation(const PlanarChain& chain, const Vector2d& X, const NewtonRun& run,
                             std::size_t i) {
  std::string out = given(chain, run.steps.front().phi, X);
  out += chain.linkCount() == 2 ? "phi^(i+1) = phi^i - D_f(phi^i)^-1 (f(phi^i) - X^neu)\n\n"
                                : "phi^(i+1) = phi^i - D_f(phi^i)^+ (f(phi^i) - X^neu)\n\n";
  out += stepInFull(chain, run, i) + "\nThe whole run:\n" + runTable(run);
  return out + fmt::format("  {} iterations\n", run.iterations());
}

std::string shortestDerivation(const PlanarChain& chain, const VectorXd& start, const VectorXd& newtonEnd,
                               const NearestSolution& best) {
  std::string out =
      "The lecture asks for ||phi_new - phi_old|| = min over all phi with f(phi) = X. Newton takes the "
      "shortest of each linearised step; is the sum of its steps the shortest way? Compared with the true "
      "minimum (" +
      std::string(nearestSolutionMethod) + ", 18 starts):\n\n";
  std::vector<std::string> heads{""};
  text::appendHead(heads, "phi [rad]", start.size());
  text::appendHead(heads, "f(phi)", 2);
  heads.push_back("distance");
  out += text::heads(heads);
  const auto row = [&](const char* name, const VectorXd& phi) {
    std::vector<std::string> cells{name};
    text::append(cells, phi, 6);
    text::append(cells, endEffector(chain, phi), 3);
    cells.push_back(text::fixed((phi - start).norm(), 8));
    return text::row(cells);
  };
  out += row("start", start) + row("Newton's end", newtonEnd) + row("true minimum", best.phi);
  const double newton = (newtonEnd - start).norm();
  out += fmt::format("  At the minimum |f - X| = {:.1e}, found in {} iterations.\n", best.violation,
                     best.iterations);
  return out + fmt::format("  Newton's way is {:.4f} % longer; the two poses are {:.4f} rad apart.\n",
                           100 * (newton / best.distance - 1), (newtonEnd - best.phi).norm());
}

LectureTopic newtonOneDimensionTopic() {
  LectureTopic topic{.id = "newton-1d",
                     .section = "10.1.4",
                     .title = "Newton in one dimension",
                     .steps = &oneDimensionSteps,
                     .checks = {}};
  const std::string section = "10.1.4, one-dimensional Newton method";
  topic.checks = {
      {.id = "newton-1d-zero",
       .section = section,
       .what = "one-link arm, l = 10, height 5: phi = 30 degrees",
       .printed = {30},
       .tolerance = {1e-10},
       .compute = [] { return std::vector{convergentRun().back().phi / degree}; }},
      {.id = "newton-1d-order",
       .section = section,
       .what = "order of convergence with a fine quotient",
       .printed = {2},
       .tolerance = {0.25},
       .compute = [] { return std::vector{convergenceOrder(errorsOf(convergentRun(), M_PI / 6), 1e-11)}; }},
      {.id = "newton-1d-coarse",
       .section = section,
       .what = "order with Delta = 0.1: the quotient is no derivative",
       .printed = {1},
       .tolerance = {0.1},
       .compute =
           [] { return std::vector{convergenceOrder(errorsOf(convergentRun(0.1), M_PI / 6), 1e-12)}; }},
      {.id = "newton-1d-divergence",
       .section = section,
       .what = "start 1.2, zero at 0: |phi^i| grows at each of the first 2 steps",
       .printed = {1, 1},
       .tolerance = {0},
       .compute =
           [] {
             const auto run = divergentRun();
             return std::vector{std::abs(run[1].phi / run[0].phi), std::abs(run[2].phi / run[1].phi)};
           },
       .comparison = Comparison::AtLeast,
       .note = "diverges from the zero it started next to, and ends at another one"},
  };
  return topic;
}

LectureTopic newtonSquareTopic() {
  LectureTopic topic{.id = "newton-square",
                     .section = "10.1.4, n = m",
                     .title = "Newton in several dimensions, n = m",
                     .steps = &squareSteps,
                     .checks = {}};
  topic.checks = {
      {.id = "newton-square-zero",
       .section = topic.section,
       .what = "two-link arm to (10, 0): phi = (-60, 120) degrees",
       .printed = {-60, 120},
       .tolerance = {1e-9},
       .compute =
           [] {
             return std::vector{squareRun().steps.back().phi[0] / degree,
                                squareRun().steps.back().phi[1] / degree};
           }},
      {.id = "newton-square-iterations",
       .section = topic.section,
       .what = "iterations to |g| <= 1e-12",
       .printed = {8},
       .tolerance = {0},
       .compute = [] { return std::vector{static_cast<double>(squareRun().iterations())}; },
       .comparison = Comparison::AtMost},
      {.id = "newton-square-singular",
       .section = topic.section,
       .what = "straight arm: sigma_min of D_f",
       .printed = {0},
       .tolerance = {1e-14},
       .compute =
           [] {
             return std::vector{
                 planarNewton(twoLinkArm(), Vector2d(0.3, 0.0), slide::armTarget).steps[0].singularValues[1]};
           },
       .note = "the inverse does not exist: the method stops"},
      {.id = "newton-square-explosion",
       .section = topic.section,
       .what = "a tenth of phi_2 makes the step ten times longer",
       .printed = {10},
       .tolerance = {0.1},
       .compute = [] { return std::vector{stepNearStraight(1e-4) / stepNearStraight(1e-3)}; }},
  };
  return topic;
}

LectureTopic pseudoInverseTopic() {
  LectureTopic topic{.id = "pseudo-inverse",
                     .section = "10.1.4, n > m",
                     .title = "Newton with the pseudo-inverse, n > m",
                     .steps = &pseudoInverseSteps,
                     .checks = {}};
  const std::string section = "10.1.4, example of inverse kinematics";
  const auto column = [](int i) { return [i] { return text::list(firstStep().D.col(i)); }; };
  topic.checks = {
      {.id = "pseudo-inverse-x-old",
       .section = section,
       .what = "X^alt",
       .printed = {230, 763},
       .tolerance = {0.5},
       .compute = [] { return text::list(firstStep().f); }},
      {.id = "pseudo-inverse-d1",
       .section = section,
       .what = "df / dphi_1",
       .printed = {-363, 180},
       .tolerance = {0.5},
       .compute = column(0)},
      {.id = "pseudo-inverse-d2",
       .section = section,
       .what = "df / dphi_2",
       .printed = {-278, 56},
       .tolerance = {0.5},
       .compute = column(1)},
      {.id = "pseudo-inverse-d3",
       .section = section,
       .what = "df / dphi_3",
       .printed = {-78, 62},
       .tolerance = {0.5},
       .compute = column(2)},
      {.id = "pseudo-inverse-dplus",
       .section = section,
       .what = "D_f^+, row by row",
       .printed = {0.001025, 0.006793, -0.005497, -0.010536, 0.002010, 0.00595},
       .tolerance = {5e-7, 5e-7, 5e-7, 5e-7, 5e-7, 5e-6},
       .compute = [] { return text::list(firstStep().Dplus); },
       .corrected = {0.001025, 0.006793, -0.005497, -0.010535, 0.002010, 0.00595},
       .note = "the slide prints -0.010536 where -0.0105355 rounds to -0.010535 (D_f rounded to three "
               "decimals gives the slide's digit); "
               "its D_f^+ does not follow from the whole numbers printed above it"},
      {.id = "pseudo-inverse-phi1",
       .section = section,
       .what = "phi^1",
       .printed = {0.295, 1.0, -0.833},
       .tolerance = {5e-4, 0.5, 5e-4},
       .compute = [] { return text::list(secondStep().phi); },
       .note = "the slide rounds 1.004 to \"1.\""},
      {.id = "pseudo-inverse-phi1-unrounded",
       .section = section,
       .what = "phi^1 in unrounded arithmetic",
       .printed = {0.29530, 1.00419, -0.83348},
       .tolerance = {5e-6},
       .compute = [] { return text::list(secondStep().phi); }},
      {.id = "pseudo-inverse-f1",
       .section = section,
       .what = "f(phi^1)",
       .printed = {336.44, 681.27},
       .tolerance = {5e-3},
       .compute = [] { return text::list(secondStep().f); },
       .note = "belongs to the unrounded phi^1"},
      {.id = "pseudo-inverse-iterations",
       .section = section,
       .what = "iterations to 1e-12 of the chain's length",
       .printed = {6},
       .tolerance = {0},
       .compute = [] { return std::vector{static_cast<double>(lectureNewtonRun().iterations())}; },
       .comparison = Comparison::AtMost},
      {.id = "pseudo-inverse-residual",
       .section = section,
       .what = "|f - X| at the end",
       .printed = {1e-12 * 450},
       .tolerance = {0},
       .compute = [] { return std::vector{lectureNewtonRun().steps.back().g.norm()}; },
       .comparison = Comparison::AtMost},
      {.id = "pseudo-inverse-shortest",
       .section = "10.1.4, n > m, interpretation",
       .what = "null-space part of the step: the shortest of all solutions",
       .printed = {0},
       .tolerance = {1e-14},
       .compute = [] { return std::vector{nullSpacePart()}; }},
      {.id = "pseudo-inverse-others",
       .section = "10.1.4, n > m, interpretation",
       .what = "length of the shortest of 1,000 other solutions / the step's",
       .printed = {1},
       .tolerance = {0},
       .compute = [] { return std::vector{shortestOther()}; },
       .comparison = Comparison::AtLeast},
  };
  return topic;
}

LectureTopic shortestPathTopic() {
  LectureTopic topic{.id = "shortest",
                     .section = "10.1.4, general inverse kinematics",
                     .title = "Is Newton's way the shortest?",
                     .steps = &shortestSteps,
                     .checks = {}};
  topic.checks = {
      {.id = "shortest-feasible",
       .section = topic.section,
       .what = "|f - X| of the true minimum",
       .printed = {1e-9},
       .tolerance = {0},
       .compute = [] { return std::vector{trueMinimum().violation}; },
       .comparison = Comparison::AtMost},
      {.id = "shortest-ratio",
       .section = topic.section,
       .what = "Newton's ||phi_new - phi_old|| / the minimum over all solutions",
       .printed = {1},
       .tolerance = {0.05},
       .compute = [] { return std::vector{newtonDistance() / trueMinimum().distance}; },
       .note = "the claim holds for the linearised step; for the whole way only nearly"},
      {.id = "shortest-minimum",
       .section = topic.section,
       .what = "no solution is shorter than the minimum: Newton's / minimum",
       .printed = {1},
       .tolerance = {0},
       .compute = [] { return std::vector{newtonDistance() / trueMinimum().distance + 1e-12}; },
       .comparison = Comparison::AtLeast},
  };
  return topic;
}

}  // namespace gelenk
