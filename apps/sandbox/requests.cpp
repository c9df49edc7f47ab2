#include "apps/sandbox/requests.h"

#include <fmt/format.h>

#include "apps/document/scene_file.h"
#include "apps/sandbox/sandbox_state.h"
#include "solvers/problem/goal_text.h"

namespace gelenk {
namespace {

Eigen::Vector3d point(const Json& value, const char* what) {
  if (!value.is_array() || value.size() != 3 || !value[0].is_number() || !value[1].is_number() ||
      !value[2].is_number())
    throw std::invalid_argument(fmt::format("{} must be three numbers, found {}", what, value.dump()));
  return Eigen::Vector3d(value[0].get<double>(), value[1].get<double>(), value[2].get<double>());
}

/// q, goals by name, solver, theme: what is given is set.
Json set(Sandbox& sandbox, const Json& request) {
  Session& session = sandbox.session();
  if (request.contains("solver")) session.setSolver(request["solver"].get<std::string>());
  if (request.contains("theme")) {
    const auto theme = request["theme"].get<std::string>();
    if (theme != "dark" && theme != "light")
      throw std::invalid_argument("a theme is light or dark, not '" + theme + "'");
    session.theme() = theme == "dark" ? Theme::Dark : Theme::Light;
  }
  if (request.contains("q")) {
    const auto q = request["q"].get<std::vector<double>>();
    session.remember();
    session.setPose(Eigen::Map<const Eigen::VectorXd>(q.data(), static_cast<Eigen::Index>(q.size())));
  }
  if (request.contains("goals")) {
    session.remember();
    for (const Json& wanted : request["goals"]) {
      if (wanted.contains("goal")) {  // of any kind, as a text
        session.addGoal(
            goalFromText(wanted["goal"].get<std::string>(), session.skeleton(), session.model().masses));
        continue;
      }
      const auto name = wanted.at("name").get<std::string>();
      std::optional<GoalId> goal = session.findGoal(name);
      if (!goal) goal = session.addJointGoal(session.skeleton().jointIndex(name));
      if (wanted.contains("target")) session.setTarget(*goal, point(wanted["target"], "a target"));
      const std::string state = wanted.value("state", "");
      if (state == "pinned")
        session.setState(*goal, GoalState::Pinned);
      else if (state == "held")
        session.setState(*goal, GoalState::Held);
      else if (state == "free")
        session.removeGoal(*goal);
      else if (!state.empty())
        throw std::invalid_argument("a goal's state is free, held or pinned, not '" + state + "'");
    }
  }
  return Json::object();
}

}  // namespace

Json poseMessage(const Sandbox& sandbox) {
  const Json all = Json::parse(sandbox.status());
  Json some;
  for (const char* key : {"model", "solver", "q", "goals", "dragging", "error", "reached"})
    some[key] = all[key];
  return some;
}

std::string checkedRequest(const Json& request) {
  if (!request.is_object() || request.value("gelenk", 0) != messageVersion)
    throw std::invalid_argument(fmt::format("messages are objects with \"gelenk\": {}", messageVersion));
  return request.at("do").get<std::string>();
}

std::optional<Json> answerRequest(Sandbox& sandbox, const std::string& what, const Json& request) {
  if (what == "get") return poseMessage(sandbox);
  if (what == "set") return set(sandbox, request);
  if (what == "status") return Json::parse(sandbox.status());
  if (what == "scene") {
    Json reply;
    reply["text"] = formatScene(sandbox.document(), sandbox.session().model());
    return reply;
  }
  if (what == "open") {
    if (!sandbox.open(request.at("file").get<std::string>()))
      throw std::runtime_error(sandbox.state().notices.back().words);
    return Json::object();
  }
  if (what == "say") {
    sandbox.say(request.at("text"), request.value("error", false));
    return Json::object();
  }
  return std::nullopt;
}

}  // namespace gelenk
