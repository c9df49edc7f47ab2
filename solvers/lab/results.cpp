#include "solvers/lab/results.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <span>
#include <tuple>
#include <type_traits>

#include "kinematics/io/csv.h"
#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"

namespace gelenk {

namespace fs = std::filesystem;

namespace {

const std::string markerTitle = "Gelenk comparison, format 3";

/// A column: its name, and the field as text and back. Where: for messages.
template <typename Row>
struct Column {
  const char* name;
  std::string (*get)(const Row&);
  bool (*set)(Row&, const std::string&);  ///< false where the text is none
};

std::string toField(const std::string& value) { return value; }
std::string toField(bool value) { return value ? "1" : "0"; }
std::string toField(int value) { return std::to_string(value); }
std::string toField(std::uint64_t value) { return std::to_string(value); }
std::string toField(double value) { return csvNumber(value); }

bool fromField(const std::string& text, std::string& value) { return value = text, true; }
bool fromField(const std::string& text, int& value) {
  const auto number = parseInteger(text);
  return number && (value = *number, true);
}
bool fromField(const std::string& text, bool& value) {
  return (text == "0" || text == "1") && (value = text == "1", true);
}
bool fromField(const std::string& text, std::uint64_t& value) {
  if (text.empty() || text.find_first_not_of("0123456789") != std::string::npos || text.size() > 20)
    return false;
  return value = std::stoull(text), true;
}
bool fromField(const std::string& text, double& value) {
  if (text.empty())
    return value = std::numeric_limits<double>::quiet_NaN(), true;  // a value that does not exist
  const auto number = parseNumber(text);
  return number && (value = *number, true);
}

/// member: [](auto& row) -> auto& { return row.x; }
template <typename Row, auto member>
constexpr Column<Row> column(const char* name) {
  return {name, [](const Row& row) { return toField(member(row)); },
          [](Row& row, const std::string& text) { return fromField(text, member(row)); }};
}
#define COLUMN(Row, name, place)                             \
  column < Row, [](auto& row) -> auto& { return row.place; } \
  > (name)

template <typename Row>
std::span<const Column<Row>> columns();

template <>
std::span<const Column<ResultRow>> columns() {
  using R = ResultRow;
  static constexpr Column<R> all[] = {COLUMN(R, "set", set),
                                      COLUMN(R, "solver", solver),
                                      COLUMN(R, "problem", problem),
                                      COLUMN(R, "sequence", sequence),
                                      COLUMN(R, "frame", frame),
                                      COLUMN(R, "level", level),
                                      COLUMN(R, "status", status),
                                      COLUMN(R, "solved", solved),
                                      COLUMN(R, "position_error", position),
                                      COLUMN(R, "orientation_error", orientation),
                                      COLUMN(R, "residual", residual),
                                      COLUMN(R, "excess", excess),
                                      COLUMN(R, "limit_violation", limitViolation),
                                      COLUMN(R, "displacement", displacement),
                                      COLUMN(R, "shortest_displacement", shortest),
                                      COLUMN(R, "solutions", solutions),
                                      COLUMN(R, "nearest_displacement", nearest),
                                      COLUMN(R, "jump", jump),
                                      COLUMN(R, "jitter", jitter),
                                      COLUMN(R, "iterations", counters.iterations),
                                      COLUMN(R, "forward_kinematics", counters.forwardKinematics),
                                      COLUMN(R, "jacobians", counters.jacobians),
                                      COLUMN(R, "hessians", counters.hessians),
                                      COLUMN(R, "factorisations", counters.factorisations),
                                      COLUMN(R, "restarts", counters.restarts),
                                      COLUMN(R, "sigma_min", sigmaMin),
                                      COLUMN(R, "limit_margin", limitMargin),
                                      COLUMN(R, "seconds", seconds),
                                      COLUMN(R, "cpu_seconds", cpuSeconds)};
  return all;
}
template <>
std::span<const Column<TracePoint>> columns() {
  using R = TracePoint;
  static constexpr Column<R> all[] = {COLUMN(R, "set", set),           COLUMN(R, "solver", solver),
                                      COLUMN(R, "problem", problem),   COLUMN(R, "iteration", iteration),
                                      COLUMN(R, "residual", residual), COLUMN(R, "seconds", seconds)};
  return all;
}
template <>
std::span<const Column<SeedRow>> columns() {
  using R = SeedRow;
  static constexpr Column<R> all[] = {COLUMN(R, "set", set),
                                      COLUMN(R, "solver", solver),
                                      COLUMN(R, "problem", problem),
                                      COLUMN(R, "seed", seed),
                                      COLUMN(R, "solved", solved),
                                      COLUMN(R, "position_error", position),
                                      COLUMN(R, "orientation_error", orientation),
                                      COLUMN(R, "displacement", displacement),
                                      COLUMN(R, "iterations", iterations),
                                      COLUMN(R, "seconds", seconds)};
  return all;
}
template <>
std::span<const Column<Preparation>> columns() {
  using R = Preparation;
  static constexpr Column<R> all[] = {COLUMN(R, "set", set), COLUMN(R, "solver", solver),
                                      COLUMN(R, "seconds", seconds), COLUMN(R, "bytes", bytes)};
  return all;
}
template <>
std::span<const Column<SetRow>> columns() {
  using R = SetRow;
  static constexpr Column<R> all[] = {COLUMN(R, "set", set), COLUMN(R, "problems", problems),
                                      COLUMN(R, "seed", seed), COLUMN(R, "checksum", checksum)};
  return all;
}
#undef COLUMN

template <typename Row>
void writeTable(const std::string& path, const std::vector<Row>& rows) {
  std::string text = csvHeader<Row>();
  for (const Row& row : rows) text += csvLine(row);
  writeFile(path, text);
}

/// Calls read(fields, reader) for every complete record after the header.
template <typename Read>
void forEachRecord(const std::string& path, Read read) {
  if (!fs::exists(path)) return;
  const std::string text = readFile(path);
  CsvReader reader(text);
  std::vector<std::string> fields;
  reader.next(fields);
  while (reader.next(fields) && reader.complete()) read(fields, reader);
}

}  // namespace

std::string csvNumber(double value) { return std::isfinite(value) ? exactNumber(value) : std::string(); }

std::vector<std::string> valuesOf(const Record& record, const std::string& name) {
  std::vector<std::string> values;
  for (const auto& [key, value] : record)
    if (key == name) values.push_back(value);
  return values;
}

template <typename Row>
std::string csvHeader() {
  std::string line;
  for (const Column<Row>& column : columns<Row>())
    line += (line.empty() ? "" : ",") + std::string(column.name);
  return line + '\n';
}

template <typename Row>
std::string csvLine(const Row& row) {
  std::vector<std::string> fields;
  for (const Column<Row>& column : columns<Row>()) fields.push_back(column.get(row));
  return csvLine(std::span<const std::string>(fields));
}

template <typename Row>
std::vector<Row> readTable(const std::string& path) {
  const auto all = columns<Row>();
  std::vector<Row> rows;
  forEachRecord(path, [&](const std::vector<std::string>& fields, const CsvReader& reader) {
    if (fields.size() != all.size())
      throw ParseError(path, reader.line(), std::to_string(all.size()) + " fields",
                       std::to_string(fields.size()));
    Row row;
    for (std::size_t k = 0; k < all.size(); ++k)
      if (!all[k].set(row, fields[k]))
        throw ParseError(path, reader.line(), std::string("a value of '") + all[k].name + "'",
                         "'" + fields[k] + "'");
    rows.push_back(std::move(row));
  });
  return rows;
}

#define INSTANTIATE(Row)                    \
  template std::string csvHeader<Row>();    \
  template std::string csvLine(const Row&); \
  template std::vector<Row> readTable(const std::string&)
INSTANTIATE(ResultRow);
INSTANTIATE(TracePoint);
INSTANTIATE(SeedRow);
INSTANTIATE(Preparation);
INSTANTIATE(SetRow);
#undef INSTANTIATE

std::string solutionsHeader(int nq) {
  std::string header = "model,set,solver,problem,status";
  for (int k = 1; k <= nq; ++k) header += ",start_" + std::to_string(k);
  header += ",target_x,target_y,target_z,target_qw,target_qx,target_qy,target_qz";
  for (int k = 1; k <= nq; ++k) header += ",solution_" + std::to_string(k);
  return header + '\n';
}

std::vector<SolutionRow> readSolutions(const std::string& path) {
  std::vector<SolutionRow> rows;
  forEachRecord(path, [&](const std::vector<std::string>& fields, const CsvReader& reader) {
    const auto problem = fields.size() > 3 ? parseInteger(fields[3]) : std::nullopt;
    if (problem) rows.push_back({fields[1], fields[2], *problem, std::string(reader.record())});
  });
  return rows;
}

Record readRecord(const std::string& folder) {
  Record record;
  const std::string path = folder + '/' + markerName;
  if (!fs::exists(path)) return record;
  const std::string text = readFile(path);
  const auto lines = splitLines(text);
  if (lines.empty() || lines[0] != markerTitle) return record;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const std::size_t colon = lines[i].find(": ");
    if (colon == std::string_view::npos)
      throw ParseError(path, static_cast<int>(i) + 1, "name: value", "'" + std::string(lines[i]) + "'");
    record.emplace_back(lines[i].substr(0, colon), lines[i].substr(colon + 2));
  }
  return record;
}

void writeRecord(const std::string& folder, const Record& record) {
  std::string text = markerTitle + '\n';
  for (const auto& [name, value] : record) text += name + ": " + value + '\n';
  writeFile(folder + '/' + markerName, text);
}

void writeTables(const std::string& folder, Results& results, const std::string& header) {
  const auto rank = [](const std::vector<std::string>& names) {
    std::map<std::string, int> ranks;
    for (const std::string& name : names) ranks.emplace(name, static_cast<int>(ranks.size()));
    return ranks;
  };
  const std::map<std::string, int> sets = rank(valuesOf(results.record, "set")),
                                   solvers = rank(valuesOf(results.record, "solver"));
  const auto sort =
      [&](auto& rows) {  // stable: the points of a trace and the seeds of a problem keep their order
        std::stable_sort(rows.begin(), rows.end(), [&](const auto& a, const auto& b) {
          const auto place = [&](const auto& row) {
            return std::tuple(sets.at(row.set), solvers.at(row.solver), row.problem);
          };
          return place(a) < place(b);
        });
      };
  sort(results.traces);
  sort(results.seeds);
  sort(results.solutions);
  sort(results.rows);
  writeTable(folder + "/traces.csv", results.traces);
  writeTable(folder + "/seeds.csv", results.seeds);
  std::string text = header;
  for (const SolutionRow& row : results.solutions) text += row.line;
  writeFile(folder + "/solutions.csv", text);
  writeTable(folder + "/results.csv", results.rows);
}

Results readResults(const std::string& folder) {
  return {.record = readRecord(folder),
          .sets = readTable<SetRow>(folder + "/problem_sets.csv"),
          .rows = readTable<ResultRow>(folder + "/results.csv"),
          .traces = readTable<TracePoint>(folder + "/traces.csv"),
          .seeds = readTable<SeedRow>(folder + "/seeds.csv"),
          .preparations = readTable<Preparation>(folder + "/preparation.csv"),
          .solutions = readSolutions(folder + "/solutions.csv")};
}

}  // namespace gelenk
