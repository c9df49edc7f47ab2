#include "apps/document/scene_v1.h"

#include <array>

namespace gelenk {

Json fromVersion1(Json tree, const std::string& file) {
  const JsonEntry root(file, tree, "");
  Json out{{"format", root.at("format").value()}, {"version", 2}};
  for (const char* same : {"model", "q", "goals"})
    if (const auto entry = root.find(same)) out[same] = entry->value();
  if (const auto goals = root.find("goals")) {
    int id = 0;
    for (std::size_t i = 0; i < goals->list().size(); ++i)
      if (out["goals"][i].is_object()) out["goals"][i]["id"] = ++id;
  }
  if (const auto solver = root.find("solver")) out["solver"] = {{"name", solver->text()}};
  for (const char* part : {"camera", "show", "theme", "selected"})
    if (const auto entry = root.find(part)) out["view"][part] = entry->value();
  const auto panels = root.find("panels");
  if (!panels) return out;
  constexpr std::array<std::pair<const char*, const char*>, 4> names{
      {{"Binding", "weights"}, {"Muscles", "muscles"}, {"Motion", "playback"}, {"Lab", "lab"}}};
  for (const auto& [title, name] : names)
    if (const auto entry = panels->find(title)) out[name] = entry->value();
  if (const auto lecture = panels->find("Lecture")) {
    const auto state = lecture->find("scene");
    out["lecture"] = {{"topic", lecture->at("topic").value()}, {"state", state ? state->value() : Json("")}};
    if (lecture->at("topic").text() == "dh" && state)  // the table's text; the model's name is a robot's
      out["model"] = {{"name", "dh:" + state->text()}};
  }
  return out;
}

}  // namespace gelenk
