#include "apps/document/described_model.h"

#include <array>
#include <cmath>
#include <utility>

#include "apps/document/json_entry.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Kind = AxisDof::Kind;

constexpr std::string_view prefix = "joints:";
constexpr std::array axisKinds{std::pair(Kind::Rotation, "rotation"),
                               std::pair(Kind::Translation, "translation")};

// ---- written

/// Rows 1 to 3 of a frame, row by row.
Json frameToJson(const Isometry3d& frame) {
  const Eigen::Matrix<double, 3, 4, Eigen::RowMajor> rows = frame.matrix().topRows<3>();
  return toJson(rows.reshaped<Eigen::RowMajor>());
}

/// Ends of a range that are none are left out.
void putRange(Json& out, double lower, double upper) {
  if (std::isfinite(lower)) out["lower"] = lower;
  if (std::isfinite(upper)) out["upper"] = upper;
}

Json jointToJson(const Joint& joint) {
  Json axes = Json::array();
  for (const AxisDof& dof : joint.axes) {
    Json axis{{"kind", axisKinds[dof.kind == Kind::Translation].second}, {"axis", toJson(dof.axis)}};
    putRange(axis, dof.lower, dof.upper);
    axes.push_back(axis);
  }
  Json out{{"name", joint.name},
           {"parent", joint.parent},
           {"offset", frameToJson(joint.parentFromZero)},
           {"axes", axes},
           {"ball", joint.ball}};
  if (const auto& limit = joint.ballLimit) {
    Json ball{{"centre", toJson(limit->swingCentre)}, {"radii", toJson(limit->swingRadii)}};
    putRange(ball, limit->twistLower, limit->twistUpper);
    out["limit"] = ball;
  }
  if (const auto& follows = joint.coupling)
    out["mimic"] = {
        {"joint", follows->source}, {"multiplier", follows->multiplier}, {"offset", follows->offset}};
  return out;
}

Json skinToJson(const Skin& skin) {
  Json positions = Json::array(), triangles = Json::array(), joints = Json::array(), weights = Json::array(),
       frames = Json::array();
  const auto append = [](Json& list, const auto& row) {
    for (const auto value : row) list.push_back(value);
  };
  for (const auto& p : skin.mesh.positions) append(positions, p);
  for (const auto& t : skin.mesh.triangles) append(triangles, t);
  for (const Influences& row : skin.influences) {
    append(joints, row.joints);
    append(weights, row.weights);
  }
  for (const Isometry3d& frame : skin.jointFromRestWorld) frames.push_back(frameToJson(frame));
  return {{"positions", positions},
          {"triangles", triangles},
          {"joints", joints},
          {"weights", weights},
          {"joint_from_rest_world", frames}};
}

// ---- read

Isometry3d readFrame(const JsonEntry& entry) {
  Isometry3d out = Isometry3d::Identity();
  out.matrix().topRows<3>().reshaped<Eigen::RowMajor>() = entry.vector(12);
  return out;
}

double end(const JsonEntry& entry, const char* key, double none) {
  const auto found = entry.find(key);
  return found ? found->number() : none;
}

Joint readJoint(const JsonEntry& entry) {
  Joint joint{.name = entry.at("name").text(),
              .parent = entry.at("parent").integer(),
              .parentFromZero = readFrame(entry.at("offset")),
              .ball = entry.at("ball").boolean()};
  for (const JsonEntry& axis : entry.at("axes").list())
    joint.axes.push_back({.kind = axis.at("kind").oneOf(axisKinds),
                          .axis = axis.at("axis").direction(),
                          .lower = end(axis, "lower", -unlimited),
                          .upper = end(axis, "upper", unlimited)});
  if (const auto limit = entry.find("limit"))
    joint.ballLimit = BallLimit{.swingCentre = limit->at("centre").vector(2),
                                .swingRadii = limit->at("radii").vector(2),
                                .twistLower = end(*limit, "lower", -unlimited),
                                .twistUpper = end(*limit, "upper", unlimited)};
  if (const auto follows = entry.find("mimic"))
    joint.coupling = Coupling{.source = follows->at("joint").integer(),
                              .multiplier = follows->at("multiplier").number(),
                              .offset = follows->at("offset").number()};
  return joint;
}

Skin readSkin(const JsonEntry& entry, int jointCount) {
  Mesh mesh;
  const std::vector<JsonEntry> positions = entry.at("positions").list();
  if (positions.empty() || positions.size() % 3) entry.at("positions").fail("three numbers a vertex");
  const std::size_t count = positions.size() / 3;
  for (std::size_t v = 0; v < count; ++v)
    mesh.positions.emplace_back(positions[3 * v].number(), positions[3 * v + 1].number(),
                                positions[3 * v + 2].number());
  const std::vector<JsonEntry> corners = entry.at("triangles").list();
  if (corners.size() % 3) entry.at("triangles").fail("three vertices a triangle");
  const auto vertex = [&](std::size_t i) { return corners[i].integer(0, static_cast<int>(count) - 1); };
  for (std::size_t i = 0; i < corners.size(); i += 3)
    mesh.triangles.push_back({vertex(i), vertex(i + 1), vertex(i + 2)});
  const std::vector<JsonEntry> joints = entry.at("joints").list(4 * count),
                               weights = entry.at("weights").list(4 * count);
  std::vector<Influences> influences(count);
  for (std::size_t i = 0; i < 4 * count; ++i) {
    influences[i / 4].joints[i % 4] = joints[i].integer(0, jointCount - 1);
    influences[i / 4].weights[i % 4] = weights[i].number(0.0, 1.0);
  }
  Skin skin = bindSkin(std::move(mesh), Frames(jointCount, Isometry3d::Identity()), std::move(influences));
  const std::vector<JsonEntry> frames = entry.at("joint_from_rest_world").list(jointCount);
  for (int i = 0; i < jointCount; ++i) skin.jointFromRestWorld[i] = readFrame(frames[i]);
  return skin;
}

}  // namespace

std::string jointsDescription(const Model& model) {
  Json joints = Json::array();
  for (const Joint& joint : model.skeleton.joints()) joints.push_back(jointToJson(joint));
  Json tree{{"name", model.name},       {"planar", model.planar}, {"up", toJson(model.up)},
            {"handles", model.handles}, {"pins", model.pins},     {"rest", toJson(model.skeleton.rest())},
            {"joints", joints}};
  if (model.skin) tree["skin"] = skinToJson(*model.skin);
  return std::string(prefix) + tree.dump();
}

std::optional<Model> parseJointsDescription(const std::string& description) {
  if (!description.starts_with(prefix)) return std::nullopt;
  const std::string file = "the model's joints";
  const Json tree = parseJson(std::string_view(description).substr(prefix.size()), file);
  const JsonEntry root(file, tree, "");
  std::vector<Joint> joints;
  for (const JsonEntry& joint : root.at("joints").list()) joints.push_back(readJoint(joint));
  if (joints.empty()) root.at("joints").fail("at least one joint");
  Eigen::Index nq = 0;
  for (const Joint& joint : joints) nq += static_cast<Eigen::Index>(joint.axes.size()) + (joint.ball ? 4 : 0);
  Model model{.name = root.at("name").text(),
              .skeleton = Skeleton(std::move(joints), root.at("rest").vector(nq)),
              .planar = root.at("planar").boolean(),
              .up = root.at("up").direction()};
  for (const auto& [list, key] : {std::pair(&model.handles, "handles"), std::pair(&model.pins, "pins")})
    for (const JsonEntry& name : root.at(key).list()) {
      model.skeleton.jointIndex(name.text());
      list->push_back(name.text());
    }
  if (const auto skin = root.find("skin")) model.skin = readSkin(*skin, model.skeleton.jointCount());
  return model;
}

}  // namespace gelenk
