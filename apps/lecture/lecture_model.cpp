#include "apps/lecture/lecture_model.h"

#include <algorithm>
#include <array>

#include "apps/lecture/example.h"
#include "apps/lecture/leg_animation.h"
#include "apps/lecture/newton_runs.h"
#include "apps/lecture/slide_data.h"
#include "kinematics/configuration.h"
#include "kinematics/notation/euler.h"

namespace gelenk {
namespace {

using Eigen::VectorXd;

constexpr double degree = M_PI / 180.0;

/// One example: a name that openModel takes, and the pose; none: the model's own rest pose.
struct Beginning {
  std::string_view topic;
  const char* model;
  VectorXd (*pose)(const Skeleton&);
};

VectorXd threeBalls(const Skeleton& skeleton) {
  VectorXd q = skeleton.rest();
  for (int i = 0; i < 3; ++i)
    setBallRotation(skeleton, q, i,
                    Eigen::Quaterniond(rotationFromEuler(lectureEulerOrder(), slide::ballAngles[i])));
  return q;
}

constexpr std::array beginnings{
    Beginning{"planar-fk", "planar:0,0:4,6,2",
              [](const Skeleton&) -> VectorXd { return slide::forwardDegrees * degree; }},
    Beginning{"two-link", "planar:0,0:10,10",
              [](const Skeleton&) -> VectorXd { return slide::twoLinkDegrees * degree; }},
    Beginning{"newton-1d", "planar:0,0:10",
              [](const Skeleton&) -> VectorXd { return VectorXd::Constant(1, slide::oneLinkStart); }},
    Beginning{"newton-square", "planar:0,0:10,10",
              [](const Skeleton&) -> VectorXd { return slide::squareStart; }},
    Beginning{"pseudo-inverse", "planar", [](const Skeleton&) -> VectorXd { return slide::startAngles; }},
    Beginning{"shortest", "planar",
              [](const Skeleton&) -> VectorXd { return lectureNewtonRun().steps.back().phi; }},
    Beginning{"rotations", "balls:1,0.8,0.5", &threeBalls},
    Beginning{"dh", "panda", nullptr},
    Beginning{"leg", "figure",
              [](const Skeleton& figure) -> VectorXd {
                const LegAnimation walk = pinFeet(figure, keyframedLegs(figure, lectureLegKeys()));
                return walk.q[static_cast<std::size_t>(slide::walkStart * walk.framesPerSecond)];
              }},
};

}  // namespace

Model lectureModel(std::string_view id) {
  const std::string_view topic = findLectureTopic(id).id;
  const auto found = std::find_if(beginnings.begin(), beginnings.end(),
                                  [&](const Beginning& b) { return b.topic == topic; });
  if (found == beginnings.end()) throw std::invalid_argument("lecture:" + std::string(id) + " has no model");
  Model model = openModel(found->model);
  if (found->pose) model.skeleton = Skeleton(model.skeleton.joints(), found->pose(model.skeleton));
  return model;
}

}  // namespace gelenk
