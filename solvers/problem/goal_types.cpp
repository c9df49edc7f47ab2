#include <stdexcept>

#include "solvers/problem/goal_type.h"

namespace gelenk {
namespace {

#define GELENK_ADDRESS(Kind, type) &type,
constexpr const GoalType* table[] = {GELENK_GOAL_TYPES(GELENK_ADDRESS)};
#undef GELENK_ADDRESS

struct Finite {
  bool operator()(int) const { return true; }
  bool operator()(double x) const { return std::isfinite(x); }
  bool operator()(const Eigen::Vector3d& x) const { return x.allFinite(); }
  bool operator()(const Eigen::Quaterniond& x) const { return x.coeffs().allFinite(); }
  bool operator()(const Eigen::VectorXd& x) const { return x.allFinite(); }
  bool operator()(const std::vector<Eigen::Vector3d>& x) const {
    for (const Eigen::Vector3d& p : x)
      if (!p.allFinite()) return false;
    return true;
  }
};

bool fieldIsFinite(const Goal& goal, const GoalField& field) {
  return std::visit([&](auto member) { return Finite()(goal.*member); }, field.member);
}

bool same(int a, int b) { return a == b; }
bool same(double a, double b) { return a == b; }
bool same(const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return a == b; }
bool same(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) { return a.coeffs() == b.coeffs(); }
bool same(const Eigen::VectorXd& a, const Eigen::VectorXd& b) { return a.size() == b.size() && a == b; }
bool same(const std::vector<Eigen::Vector3d>& a, const std::vector<Eigen::Vector3d>& b) { return a == b; }

std::string whyNotJoint(const Goal& goal, const Skeleton& skeleton, const GoalField& field) {
  const int joint = goal.*std::get<int Goal::*>(field.member);
  if (joint >= 0 && joint < skeleton.jointCount()) return {};
  return std::string(field.name) + " " + std::to_string(joint) + " is not one of the skeleton's " +
         std::to_string(skeleton.jointCount());
}

std::string whyNotField(const Goal& goal, const Skeleton& skeleton, const GoalField& field) {
  using Meaning = GoalField::Meaning;
  const std::string name(field.name);
  if (!fieldIsFinite(goal, field)) return name + " must be finite";
  switch (field.meaning) {
    case Meaning::Rotation:
      return (goal.*std::get<Eigen::Quaterniond Goal::*>(field.member)).norm() > 0.0
                 ? ""
                 : name + " must not be zero";
    case Meaning::AxisInJoint:
    case Meaning::Direction:
      return (goal.*std::get<Eigen::Vector3d Goal::*>(field.member)).norm() > 0.0
                 ? ""
                 : name + " must not be zero";
    case Meaning::Length:
      return goal.*std::get<double Goal::*>(field.member) >= 0.0 ? "" : name + " must not be below 0";
    case Meaning::Polygon:
      return (goal.*std::get<std::vector<Eigen::Vector3d> Goal::*>(field.member)).size() >= 3
                 ? ""
                 : name + " needs three points or more";
    case Meaning::Posture:
      return goal.posture.size() == skeleton.nq()
                 ? ""
                 : name + " needs nq = " + std::to_string(skeleton.nq()) + " values, found " +
                       std::to_string(goal.posture.size());
    default: return {};
  }
}

}  // namespace

std::span<const GoalType* const> goalTypes() { return table; }

const GoalType& goalType(GoalKind kind) { return *table[static_cast<int>(kind)]; }

const GoalType& goalType(std::string_view name) {
  std::string names;
  for (const GoalType* type : table) {
    if (type->name == name) return *type;
    names += (names.empty() ? "" : ", ") + std::string(type->name);
  }
  throw std::invalid_argument("no kind of goal '" + std::string(name) + "'; there are " + names);
}

bool isFinite(const Goal& goal) {
  if (!std::isfinite(goal.weight) || goal.weight < 0.0) return false;
  for (const GoalField& field : goalType(goal.kind).fields)
    if (!fieldIsFinite(goal, field)) return false;
  return true;
}

bool asksTheSame(const Goal& a, const Goal& b) {
  if (a.kind != b.kind) return false;
  for (const GoalField& field : goalType(a.kind).fields)
    if (!std::visit([&](auto member) { return same(a.*member, b.*member); }, field.member)) return false;
  return true;
}

std::string whyMisplaced(const Goal& goal, const Skeleton& skeleton) {
  const GoalType& type = goalType(goal.kind);
  const std::string prefix = "a goal of kind " + std::string(type.name) + ": ";
  for (const GoalField& field : type.fields)
    if (field.meaning == GoalField::Meaning::Joint)
      if (const std::string why = whyNotJoint(goal, skeleton, field); !why.empty()) return prefix + why;
  if (type.needsMasses) {
    if (!goal.masses) return prefix + "the model has no masses";
    if (static_cast<int>(goal.masses->mass.size()) != skeleton.jointCount())
      return prefix + "masses of another skeleton";
  }
  return type.whyNot ? type.whyNot(goal, skeleton) : std::string();
}

std::string whyInvalid(const Goal& goal, const Skeleton& skeleton) {
  if (const std::string why = whyMisplaced(goal, skeleton); !why.empty()) return why;
  const GoalType& type = goalType(goal.kind);
  const std::string prefix = "a goal of kind " + std::string(type.name) + ": ";
  if (!std::isfinite(goal.weight) || goal.weight < 0.0)
    return prefix + "its weight must be finite and not below 0";
  for (const GoalField& field : type.fields)
    if (const std::string why = whyNotField(goal, skeleton, field); !why.empty()) return prefix + why;
  return {};
}

}  // namespace gelenk
