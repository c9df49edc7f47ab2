#include "skinning/io/gltf_joints.h"

#include <cmath>
#include <stdexcept>

namespace gelenk {

namespace {

using Value = tinygltf::Value;

Value listed(const std::vector<double>& numbers) {
  Value::Array out;
  for (const double x : numbers) out.emplace_back(x);
  return Value(std::move(out));
}

std::vector<double> numbersOf(const Value& object, const std::string& key, std::size_t count) {
  const Value& list = object.Get(key);
  std::vector<double> out;
  if (list.IsArray())
    for (std::size_t k = 0; k < list.ArrayLen(); ++k)
      if (const Value& entry = list.Get(k); entry.IsNumber()) out.push_back(entry.GetNumberAsDouble());
  if (out.size() != count)
    throw std::invalid_argument(std::to_string(count) + " numbers were expected in '" + key + "'");
  return out;
}

double numberOf(const Value& object, const std::string& key, double otherwise) {
  if (!object.Has(key)) return otherwise;
  const double value = object.Get(key).IsNumber() ? object.Get(key).GetNumberAsDouble() : NAN;
  if (!std::isfinite(value)) throw std::invalid_argument("'" + key + "' is no number");
  return value;
}

void putLimit(Value::Object& object, const char* key, double value) {
  if (std::isfinite(value)) object[key] = Value(value);
}

}  // namespace

Value withMotion(const Joint& joint, const std::vector<double>& rest) {
  Value::Object motion;
  Value::Array axes;
  for (std::size_t k = 0; k < joint.axes.size(); ++k) {
    const AxisDof& dof = joint.axes[k];
    Value::Object axis;
    axis[dof.kind == AxisDof::Kind::Rotation ? "turn" : "move"] =
        listed({dof.axis.x(), dof.axis.y(), dof.axis.z()});
    putLimit(axis, "lower", dof.lower);
    putLimit(axis, "upper", dof.upper);
    axis["rest"] = Value(rest[k]);
    axes.emplace_back(std::move(axis));
  }
  if (axes.empty() && !joint.ball) motion["fixed"] = Value(true);  // the reader passes over empty objects
  if (!axes.empty()) motion["axes"] = Value(std::move(axes));
  if (joint.ball) {
    Value::Object ball;
    ball["rest"] = listed({rest.end() - 4, rest.end()});
    if (const auto& limit = joint.ballLimit) {
      ball["swingCentre"] = listed({limit->swingCentre.x(), limit->swingCentre.y()});
      ball["swingRadii"] = listed({limit->swingRadii.x(), limit->swingRadii.y()});
      putLimit(ball, "twistLower", limit->twistLower);
      putLimit(ball, "twistUpper", limit->twistUpper);
    }
    motion["ball"] = Value(std::move(ball));
  }
  Value::Object extras;
  extras["gelenk"] = Value(std::move(motion));
  return Value(std::move(extras));
}

std::optional<JointMotion> motionOf(const Value& extras) {
  if (!extras.IsObject() || !extras.Has("gelenk")) return {};
  const Value& motion = extras.Get("gelenk");
  const bool hasAxes = motion.IsObject() && motion.Has("axes");
  if (!motion.IsObject() || (hasAxes && !motion.Get("axes").IsArray()))
    throw std::invalid_argument("extras.gelenk with a list of axes was expected");
  JointMotion out;
  const Value axes = hasAxes ? motion.Get("axes") : Value(Value::Array{});
  for (std::size_t k = 0; k < axes.ArrayLen(); ++k) {
    const Value& axis = axes.Get(k);
    if (!axis.IsObject()) throw std::invalid_argument("an axis was expected");
    const bool turns = axis.Has("turn");
    AxisDof dof{.kind = turns ? AxisDof::Kind::Rotation : AxisDof::Kind::Translation};
    const std::vector<double> direction = numbersOf(axis, turns ? "turn" : "move", 3);
    dof.axis = Eigen::Vector3d::Map(direction.data());
    dof.lower = numberOf(axis, "lower", -unlimited);
    dof.upper = numberOf(axis, "upper", unlimited);
    out.axes.push_back(dof);
    out.rest.push_back(numberOf(axis, "rest", 0.0));
  }
  if (!motion.Has("ball")) return out;
  const Value& ball = motion.Get("ball");
  if (!ball.IsObject()) throw std::invalid_argument("a ball was expected");
  out.ball = true;
  const std::vector<double> rest = numbersOf(ball, "rest", 4);
  out.rest.insert(out.rest.end(), rest.begin(), rest.end());
  if (!ball.Has("swingRadii")) return out;
  const std::vector<double> centre = numbersOf(ball, "swingCentre", 2),
                            radii = numbersOf(ball, "swingRadii", 2);
  out.ballLimit = BallLimit{.swingCentre = {centre[0], centre[1]},
                            .swingRadii = {radii[0], radii[1]},
                            .twistLower = numberOf(ball, "twistLower", -unlimited),
                            .twistUpper = numberOf(ball, "twistUpper", unlimited)};
  return out;
}

}  // namespace gelenk
