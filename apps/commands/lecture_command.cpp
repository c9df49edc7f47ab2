#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "apps/commands/command_line.h"
#include "apps/commands/commands.h"
#include "apps/lecture/example.h"
#include "apps/lecture/text_table.h"

namespace gelenk {
namespace {

using json = nlohmann::ordered_json;

struct Request {
  std::string id;
  bool steps = false, list = false, asJson = false, asMarkdown = false;
};

struct Row {
  const LectureCheck* check;
  LectureVerdict verdict;
};

/// The whole list, one topic, or one check.
std::vector<Row> rowsOf(const Request& request) {
  std::vector<Row> rows;
  const LectureTopic* only = request.id.empty() ? nullptr : &findLectureTopic(request.id);
  for (const LectureTopic& topic : lectureTopics()) {
    if (only && only != &topic) continue;
    for (const LectureCheck& check : topic.checks)
      if (!only || only->id == request.id || check.id == request.id)
        rows.push_back({&check, evaluate(check)});
  }
  return rows;
}

std::string numbers(const std::vector<double>& values, int digits) {
  std::string out;
  for (const double value : values) out += (out.empty() ? "" : " ") + fmt::format("{:.{}g}", value, digits);
  return out;
}

std::string printedText(const LectureCheck& check) {
  const char* sign = check.comparison == Comparison::AtMost    ? "<= "
                     : check.comparison == Comparison::AtLeast ? ">= "
                                                               : "";
  return sign + numbers(check.printed, 7) + (check.corrected.empty() ? "" : " (!)");
}

const char* word(bool ok) { return ok ? "ok" : "DIFFERS"; }

void printTable(const std::vector<Row>& rows) {
  fmt::print("{:<30} {:<42} {:<44} {:<52} {:>10}  {}\n", "example", "section", "printed", "computed",
             "difference", "verdict");
  for (const auto& [check, verdict] : rows) {
    fmt::print("{:<30} {:<42} {:<44} {:<52} {:>10.2e}  {}\n", check->id, check->section, printedText(*check),
               numbers(verdict.computed, 11), verdict.difference, word(verdict.ok));
    if (!check->note.empty()) fmt::print("{:<30} note: {}\n", "", check->note);
  }
}

void printMarkdown(const std::vector<Row>& rows) {
  fmt::print(
      "| example | section | what | printed | computed | difference | verdict | note "
      "|\n|---|---|---|---|---|---|---|---|\n");
  const auto cell = [](std::string text) {
    for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.insert(at, "\\");
    return text;
  };
  for (const auto& [check, verdict] : rows)
    fmt::print("| {} | {} | {} | {} | {} | {:.2e} | {} | {} |\n", check->id, check->section,
               cell(check->what), printedText(*check), numbers(verdict.computed, 11), verdict.difference,
               word(verdict.ok), cell(check->note));
}

void printJson(const std::vector<Row>& rows) {
  json array = json::array();
  for (const auto& [check, verdict] : rows) {
    const char* comparison = check->comparison == Comparison::Equal    ? "equal"
                             : check->comparison == Comparison::AtMost ? "at most"
                                                                       : "at least";
    array.push_back({{"id", check->id},
                     {"section", check->section},
                     {"what", check->what},
                     {"printed", check->printed},
                     {"corrected", check->corrected},
                     {"computed", verdict.computed},
                     {"tolerance", check->tolerance},
                     {"comparison", comparison},
                     {"difference", verdict.difference},
                     {"ok", verdict.ok},
                     {"note", check->note}});
  }
  fmt::print("{}\n", array.dump(2));
}

void printList() {
  for (const LectureTopic& topic : lectureTopics()) {
    fmt::print("{:<16} {:<34} {}\n", topic.id, topic.section, topic.title);
    for (const LectureCheck& check : topic.checks) fmt::print("    {:<32} {}\n", check.id, check.what);
  }
}

void run(const Request& request) {
  if (request.list) return printList();
  if (request.steps) {
    for (const LectureTopic& topic : lectureTopics())
      if (request.id.empty() || &topic == &findLectureTopic(request.id))
        fmt::print("=== {}: {} (lecture {})\n\n{}\n", topic.id, topic.title, topic.section,
                   padded(topic.steps()));
    return;
  }
  const std::vector<Row> rows = rowsOf(request);
  if (request.asJson)
    printJson(rows);
  else if (request.asMarkdown)
    printMarkdown(rows);
  else
    printTable(rows);
  const auto bad = std::count_if(rows.begin(), rows.end(), [](const Row& row) { return !row.verdict.ok; });
  if (!request.asJson && !request.asMarkdown)
    fmt::print("{} of {} agree with the lecture\n", rows.size() - static_cast<std::size_t>(bad), rows.size());
  if (bad > 0) throw ExitStatus{1};
}

}  // namespace

void addLectureCommand(Command& app) {
  auto request = std::make_shared<Request>();
  Command command = app.command("lecture", "Every example of the lecture, printed against computed values");
  command.option("id", request->id, "One topic or one example; all where it is left out");
  command.flag("--steps", request->steps, "Print the whole derivation with every intermediate value");
  command.flag("--list", request->list, "List topics and examples");
  command.flag("--json", request->asJson, "Print JSON: an array of objects");
  command.flag("--markdown", request->asMarkdown, "Print a Markdown table");
  command.run([request] { run(*request); });
}

}  // namespace gelenk
