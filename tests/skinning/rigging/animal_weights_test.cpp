#include <gtest/gtest.h>

#include <cmath>

#include "skinning/rigging/auto_rig.h"
#include "skinning/rigging/fit/rig_skeleton.h"
#include "skinning/rigging/fit/template_body.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

/// What of a vertex's weight goes along when a joint turns.
double carried(const RiggedBody& body, int joint, std::size_t vertex) {
  double sum = 0.0;
  for (const auto& [j, w] : body.weights[vertex])
    if (body.skeleton.isAncestor(joint, j)) sum += w;
  return sum;
}

/// The template with its own joints, not fitted.
RiggedBody riggedAtRest(const TemplateBody& body) {
  std::vector<Vector3d> joints;
  for (const TemplateJoint& joint : body.joints) joints.push_back(joint.position);
  Placement placement;
  placement.maps = restMaps(body);
  RiggedBody out;
  out.skeleton = rigSkeleton(rigJoints(body, RigTemplate::Quadruped, placement, joints));
  weigh(body.surface, out);
  return out;
}

struct Animal {
  const char* name;
  const TemplateBody& body;
  RiggedBody rigged;

  Vector3d at(const std::string& joint) const {
    return restFrames(rigged.skeleton)[rigged.skeleton.jointIndex(joint)].translation();
  }
  double leg(const std::string& joint, std::size_t vertex) const {
    return carried(rigged, rigged.skeleton.jointIndex(joint), vertex);
  }
  double length() const { return at("head").z() - at("tail_root").z(); }
};

const std::vector<Animal>& animals() {
  static const std::vector<Animal> all = [] {
    std::vector<Animal> out;
    for (const auto& [name, body] :
         {std::pair("hoofed", &hoofedTemplate()), {"cattle", &cattleTemplate()}, {"pawed", &pawedTemplate()}})
      out.push_back({name, *body, riggedAtRest(*body)});
    return out;
  }();
  return all;
}

TEST(AnimalRig, ThePelvisLiesBetweenTheHipsAndTheChestBetweenTheShoulders) {
  for (const Animal& animal : animals()) {
    EXPECT_LT((animal.at("pelvis") - 0.5 * (animal.at("hip_l") + animal.at("hip_r"))).norm(), 1e-12);
    EXPECT_LT((animal.at("chest") - 0.5 * (animal.at("fshoulder_l") + animal.at("fshoulder_r"))).norm(),
              1e-12);
  }
}

// Parts of a template blend by their own girth: an animal's hocks are no knobs.
TEST(AnimalRig, TheTemplatesHaveSlimJoints) {
  for (const Animal& animal : animals())
    for (const std::string joint : {"fankle_l", "hock_l"}) {
      double girth = 0.0;
      for (const Vector3d& p : animal.body.surface.positions)
        if (const Vector3d arm = p - animal.at(joint); std::abs(arm.y()) < 0.02 && arm.norm() < 0.07)
          girth = std::max(girth, std::abs(arm.x()));
      EXPECT_GT(girth, 0.01) << animal.name << " " << joint;
      EXPECT_LT(girth, 0.033) << animal.name << " " << joint;
    }
}

// Foxes' tails are twice as long as dogs': the bone reaches the tip.
TEST(AnimalRig, ATailIsFollowedToItsTip) {
  const Animal& animal = animals()[2];
  const Vector3d root = animal.at("tail_root"), tip = animal.at("tail"), along = (tip - root).normalized();
  constexpr double longer = 0.15;
  Mesh mesh = animal.body.surface;
  for (Vector3d& p : mesh.positions)
    if (const double t = along.dot(p - root) / (tip - root).norm(); t > 0.3 && p.z() < root.z())
      if ((p - root - along * along.dot(p - root)).norm() < 0.06) p += (t - 0.3) / 0.7 * longer * along;
  const RiggedBody rigged = rigBody(mesh, {.skeleton = RigTemplate::Quadruped});
  const Vector3d found = restFrames(rigged.skeleton)[rigged.skeleton.jointIndex("tail")].translation();
  EXPECT_NEAR(along.dot(found - tip), longer, 0.05);
}

// When a leg swings forwards the belly between the legs stays the trunk's, from the knees to the breast.
TEST(AnimalWeights, NoLegCarriesTheMiddleOfTheBelly) {
  for (const Animal& animal : animals()) {
    const double from = animal.at("knee_l").z() + 0.05 * animal.length(),
                 to = animal.at("fshoulder_l").z() + 0.06 * animal.length();
    const double middle = 0.5 * (animal.at("hip_l").y() + animal.at("fshoulder_l").y());
    int found = 0;
    for (std::size_t v = 0; v < animal.body.surface.positions.size(); ++v) {
      const Vector3d& p = animal.body.surface.positions[v];
      if (p.y() > middle || std::abs(p.x()) > 0.01 || p.z() < from || p.z() > to) continue;
      ++found;
      EXPECT_LT(animal.leg("hip_l", v), 0.22) << animal.name << " " << p.transpose();
      EXPECT_LT(animal.leg("fshoulder_l", v), 0.25) << animal.name << " " << p.transpose();
    }
    EXPECT_GT(found, 5) << animal.name;
  }
}

// The skin over shoulder and croup goes along with the leg by shares: a narrow seam creases there.
TEST(AnimalWeights, ShoulderAndCroupAreSharedWithTheTrunk) {
  for (const Animal& animal : animals())
    for (const std::string joint : {"fshoulder_l", "hip_l"}) {
      int moved = 0, shared = 0;
      for (std::size_t v = 0; v < animal.body.surface.positions.size(); ++v) {
        const double w = animal.leg(joint, v);
        moved += w > 0.1;
        shared += w > 0.1 && w < 0.9;
      }
      EXPECT_GT(shared, 0.39 * moved) << animal.name << " " << joint;
    }
}

}  // namespace
}  // namespace gelenk
