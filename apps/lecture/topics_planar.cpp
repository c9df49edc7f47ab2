// Lecture 10.1, 10.1.1, 10.1.2: forward kinematics in the plane.

#include "apps/lecture/derivations.h"
#include "apps/lecture/example.h"
#include "apps/lecture/slide_data.h"
#include "apps/lecture/text.h"
#include "kinematics/forward_kinematics.h"
#include "kinematics/notation/planar_chain.h"

namespace gelenk {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double degree = M_PI / 180.0;
const double root3 = std::sqrt(3.0);

PlanarChain chain() {
  return {.base = Vector2d::Zero(), .lengths = {slide::forwardLengths.begin(), slide::forwardLengths.end()}};
}
VectorXd phi() { return slide::forwardDegrees * degree; }

std::vector<double> pointNumber(int i) {
  const Vector2d P = linkPoints(chain(), phi())[static_cast<std::size_t>(i) - 1];
  return {P.x(), P.y()};
}

/// Largest distance between the three routes over all points: sums, hierarchy, skeleton.
double routesApart(const PlanarChain& chain, const VectorXd& phi) {
  const auto sums = linkPoints(chain, phi);
  const auto hierarchy = hierarchicalFrames(chain, phi);
  const Frames frames = forwardKinematics(toSkeleton(chain), phi);
  double apart = 0.0;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    apart = std::max(apart, (sums[i] - hierarchy[i].translation()).norm());
    apart = std::max(apart, (sums[i] - frames[i].translation().head<2>()).norm());
  }
  return apart;
}

/// remark: after the sums.
std::string derivation(const PlanarChain& chain, const VectorXd& phi, const std::string& remark) {
  const int n = chain.linkCount();
  std::string out =
      fmt::format("Given: P_1 = {}, l = {}, phi = {} degrees\n", text::point(chain.base),
                  text::point(VectorXd::Map(chain.lengths.data(), n)), text::point(phi / degree));
  out += fmt::format("Degrees of freedom n + 2 = {}\n\n", degreesOfFreedom(chain));
  out += "P_(i+1) = P_i + l_i (cos, sin)(phi_1 + ... + phi_i)\n";
  out += text::heads({"i", "l_i", "phi_1 + ... + phi_i", "cos", "sin", "P_(i+1)", ""});
  const auto P = linkPoints(chain, phi);
  double sum = 0.0;
  for (int i = 0; i < n; ++i) {
    sum += phi[i];
    std::vector<std::string> cells{std::to_string(i + 1), fmt::format("{:g}", chain.lengths[i]),
                                   text::fixed(sum / degree, 2), text::fixed(std::cos(sum), 6),
                                   text::fixed(std::sin(sum), 6)};
    text::append(cells, P[i + 1], 6);
    out += text::row(cells);
  }
  out += remark;
  out += "\nThe same through the hierarchy, K_1 = T(P_1) R(phi_1), K_(i+1) = K_i T(l_i, 0) R(phi_(i+1)):\n";
  out += text::heads({"i", "origin of K_i", "", "x axis", "", "y axis", ""});
  const auto frames = hierarchicalFrames(chain, phi);
  for (int i = 0; i < n; ++i) {
    std::vector<std::string> cells{std::to_string(i + 1)};
    text::append(cells, frames[i].translation(), 6);
    text::append(cells, frames[i].linear().col(0), 6);
    text::append(cells, frames[i].linear().col(1), 6);
    out += text::row(cells);
  }
  out += fmt::format("  X = K_{} (l_{}, 0) = {}\n\n", n, n, text::point(frames.back().translation(), 12));
  out += fmt::format("And through the general skeleton (hinges about z): X = {}\n",
                     text::point(forwardKinematics(toSkeleton(chain), phi).back().translation(), 12));
  out += fmt::format("Largest distance between the three routes: {:.2e}\n", routesApart(chain, phi));
  return out;
}

std::string steps() {
  const auto printed = [](const char* name, const char* value, const Vector2d& P) {
    return text::row({name, value, text::fixed(P.x(), 6), text::fixed(P.y(), 6)});
  };
  return derivation(chain(), phi(),
                    "On the slide:\n" + printed("P_2", "(2, 2 sqrt(3))", {2, 2 * root3}) +
                        printed("P_3", "(2 + 3 sqrt(3), 2 sqrt(3) - 3)", {2 + 3 * root3, 2 * root3 - 3}) +
                        printed("P_4", "(2 + 4 sqrt(3), 2 sqrt(3) - 2)", {2 + 4 * root3, 2 * root3 - 2}));
}

}  // namespace

std::string forwardDerivation(const PlanarChain& chain, const VectorXd& phi) {
  return derivation(chain, phi, "");
}

LectureTopic planarForwardTopic() {
  const std::string section = "10.1.2, example with 3 links";
  LectureTopic topic{.id = "planar-fk",
                     .section = "10.1 - 10.1.2",
                     .title = "Forward kinematics of a planar chain",
                     .steps = &steps,
                     .checks = {}};
  topic.checks = {
      {.id = "planar-fk-p2",
       .section = section,
       .what = "P_2 = (2, 2 sqrt(3))",
       .printed = {2, 2 * root3},
       .tolerance = {1e-12},
       .compute = [] { return pointNumber(2); }},
      {.id = "planar-fk-p3",
       .section = section,
       .what = "P_3 = (2 + 3 sqrt(3), 2 sqrt(3) - 3)",
       .printed = {2 + 3 * root3, 2 * root3 - 3},
       .tolerance = {1e-12},
       .compute = [] { return pointNumber(3); }},
      {.id = "planar-fk-p4",
       .section = section,
       .what = "P_4 = (2 + 4 sqrt(3), 2 sqrt(3) - 2)",
       .printed = {2 + 4 * root3, 2 * root3 - 2},
       .tolerance = {1e-12},
       .compute = [] { return pointNumber(4); }},
      {.id = "planar-fk-routes",
       .section = "10.1.1, hierarchical coordinate systems",
       .what = "sums, T(l, 0) R(phi) and skeleton agree",
       .printed = {1e-12},
       .tolerance = {0},
       .compute = [] { return std::vector{routesApart(chain(), phi())}; },
       .comparison = Comparison::AtMost},
      {.id = "planar-fk-dof",
       .section = "10.1, degrees of freedom",
       .what = "n + 2 for n = 3",
       .printed = {5},
       .tolerance = {0},
       .compute = [] { return std::vector<double>{static_cast<double>(degreesOfFreedom(chain()))}; }},
  };
  return topic;
}

}  // namespace gelenk
