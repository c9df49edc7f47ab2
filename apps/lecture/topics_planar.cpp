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
      fmt::format("Given: P1 = {}, l = {}, phi = {} degrees\n", text::point(chain.base),
                  text::point(VectorXd::Map(chain.lengths.data(), n)), text::point(phi / degree));
  out += fmt::format("Degrees of freedom n + 2 = {}\n\n", degreesOfFreedom(chain));
  out += "P_(i+1) = P_i + l_i (cos, sin)(phi_1 + ... + phi_i)\n";
  const auto P = linkPoints(chain, phi);
  double sum = 0.0;
  for (int i = 0; i < n; ++i) {
    sum += phi[i] / degree;
    out += fmt::format("  P{} = {} + {} (cos {:g}, sin {:g}) = {} + {} {} = {}\n", i + 2, text::point(P[i]),
                       chain.lengths[i], sum, sum, text::point(P[i]), chain.lengths[i],
                       text::point(Vector2d(std::cos(sum * degree), std::sin(sum * degree))),
                       text::point(P[i + 1], 15));
  }
  out += remark;
  out += "\nThe same through the hierarchy, K_1 = T(P1) R(phi_1), K_(i+1) = K_i T(l_i, 0) R(phi_(i+1)):\n";
  const auto frames = hierarchicalFrames(chain, phi);
  for (int i = 0; i < n; ++i)
    out +=
        fmt::format("  K_{}: origin {}, x axis {}, y axis {}\n", i + 1, text::point(frames[i].translation()),
                    text::point(frames[i].linear().col(0)), text::point(frames[i].linear().col(1)));
  out += fmt::format("  X = K_{} (l_{}, 0) = {}\n\n", n, n, text::point(frames.back().translation(), 15));
  out += fmt::format("And through the general skeleton (hinges about z): X = {}\n",
                     text::point(forwardKinematics(toSkeleton(chain), phi).back().translation(), 15));
  out += fmt::format("Largest distance between the three routes: {:.2e}\n", routesApart(chain, phi));
  return out;
}

std::string steps() {
  return derivation(
      chain(), phi(),
      fmt::format("  on the slide: P2 = (2, 2 sqrt3) = {}, P3 = (2 + 3 sqrt3, 2 sqrt3 - 3) = {}, P4 = (2 + 4 "
                  "sqrt3, 2 sqrt3 - 2) = {}\n",
                  text::point(Vector2d(2, 2 * root3), 15),
                  text::point(Vector2d(2 + 3 * root3, 2 * root3 - 3), 15),
                  text::point(Vector2d(2 + 4 * root3, 2 * root3 - 2), 15)));
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
       .what = "P2 = (2, 2 sqrt3)",
       .printed = {2, 2 * root3},
       .tolerance = {1e-12},
       .compute = [] { return pointNumber(2); }},
      {.id = "planar-fk-p3",
       .section = section,
       .what = "P3 = (2 + 3 sqrt3, 2 sqrt3 - 3)",
       .printed = {2 + 3 * root3, 2 * root3 - 3},
       .tolerance = {1e-12},
       .compute = [] { return pointNumber(3); }},
      {.id = "planar-fk-p4",
       .section = section,
       .what = "P4 = (2 + 4 sqrt3, 2 sqrt3 - 2)",
       .printed = {2 + 4 * root3, 2 * root3 - 2},
       .tolerance = {1e-12},
       .compute = [] { return pointNumber(4); }},
      {.id = "planar-fk-routes",
       .section = "10.1.1, hierarchical coordinate systems",
       .what = "sums, T(l,0) R(phi) and skeleton agree",
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
