#include "kinematics/io/dh_text.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"

namespace gelenk {
namespace {

/// A number, or a multiple or fraction of pi: 1.5, pi, -pi/2, 3pi/4, 0.5pi.
std::optional<double> parseAngle(std::string_view word) {
  const std::size_t at = word.find("pi");
  if (at == std::string_view::npos) return parseNumber(word);
  std::string_view factor = word.substr(0, at), rest = word.substr(at + 2);
  double value = M_PI;
  if (factor == "-")
    value = -value;
  else if (!factor.empty() && factor != "+") {
    const std::optional<double> number = parseNumber(factor);
    if (!number) return std::nullopt;
    value *= *number;
  }
  if (rest.empty()) return value;
  const std::optional<double> divisor = rest.front() == '/' ? parseNumber(rest.substr(1)) : std::nullopt;
  if (!divisor || *divisor == 0.0) return std::nullopt;
  return value / *divisor;
}

/// Reads line by line; knows where it is, so that every complaint carries the line.
class DhReader {
 public:
  DhReader(std::string_view text, std::string file) : text_(text), file_(std::move(file)) {}

  DhTable read() {
    for (const std::string_view line : splitLines(plainText(text_, file_))) {
      ++line_;
      words_ = splitWords(line.substr(0, line.find('#')));
      if (!words_.empty()) readLine();
    }
    if (!sawConvention_) fail(0, "'dh modified' or 'dh standard' as the first line", "no such line");
    if (table_.rows.empty()) fail(0, "at least one row 'revolute|prismatic|fixed a alpha d phi'", "none");
    if (restLine_ > 0 && table_.rest->size() != table_.variableCount())
      fail(restLine_, std::to_string(table_.variableCount()) + " values of the rest pose, one a moving row",
           std::to_string(table_.rest->size()));
    if (restLine_ > 0) scaleRest();
    return table_;
  }

 private:
  [[noreturn]] void fail(int line, const std::string& expected, const std::string& found) const {
    throw ParseError(file_, line, expected, found);
  }

  void readLine() {
    const std::string_view key = words_[0];
    if (!sawConvention_ && key != "dh")
      fail(line_, "'dh modified' or 'dh standard' first", "'" + std::string(key) + "'");
    if (key == "dh")
      readConvention();
    else if (key == "name")
      readName();
    else if (key == "angles")
      readUnit();
    else if (key == "base")
      table_.base = readPlace();
    else if (key == "tool")
      table_.tool = readPlace();
    else if (key == "rest")
      readRest();
    else
      readRow();
  }

  void readConvention() {
    if (sawConvention_) fail(line_, "one line 'dh' only", "a second one");
    sawConvention_ = true;
    if (words_.size() != 2 || (words_[1] != "modified" && words_[1] != "standard"))
      fail(line_, "'dh modified' or 'dh standard'", found());
    table_.convention = words_[1] == "modified" ? DhConvention::Modified : DhConvention::Standard;
  }

  void readName() {
    if (words_.size() != 2) fail(line_, "'name' and one word", found());
    table_.name = words_[1];
  }

  void readUnit() {
    if (words_.size() != 2 || (words_[1] != "radians" && words_[1] != "degrees"))
      fail(line_, "'angles radians' or 'angles degrees'", found());
    if (!table_.rows.empty()) fail(line_, "the unit of angles before the first row", "it after a row");
    angleUnit_ = words_[1] == "degrees" ? M_PI / 180.0 : 1.0;
  }

  Eigen::Isometry3d readPlace() const {
    if (words_.size() != 4 && words_.size() != 8)
      fail(line_, "'" + std::string(words_[0]) + " x y z' (metres), or with a quaternion 'x y z qw qx qy qz'",
           count());
    Eigen::Isometry3d place = Eigen::Isometry3d::Identity();
    place.translation() = Eigen::Vector3d(number(1, "x"), number(2, "y"), number(3, "z"));
    if (words_.size() == 8) {
      const Eigen::Quaterniond q(number(4, "qw"), number(5, "qx"), number(6, "qy"), number(7, "qz"));
      if (!(std::abs(q.norm() - 1.0) < 1e-6))
        fail(line_, "a quaternion qw qx qy qz of length 1", "length " + exactNumber(q.norm()));
      place.linear() = q.normalized().toRotationMatrix();
    }
    return place;
  }

  void readRest() {
    if (restLine_ > 0) fail(line_, "one line 'rest' only", "a second one");
    restLine_ = line_;
    Eigen::VectorXd rest(static_cast<Eigen::Index>(words_.size()) - 1);
    for (std::size_t i = 1; i < words_.size(); ++i) {
      const std::optional<double> value = parseAngle(words_[i]);
      if (!value) fail(line_, "a number as value " + std::to_string(i) + " of the rest pose", quoted(i));
      rest[static_cast<Eigen::Index>(i) - 1] = *value;
      restIsPi_.push_back(words_[i].find("pi") != std::string_view::npos);
    }
    table_.rest = rest;
  }

  /// The unit of angles applies to turning joints; which those are is known only at the end.
  void scaleRest() {
    Eigen::Index at = 0;
    for (const DhRow& row : table_.rows) {
      if (row.kind == DhJoint::Fixed) continue;
      if (row.kind == DhJoint::Revolute && !restIsPi_[at]) (*table_.rest)[at] *= angleUnit_;
      ++at;
    }
  }

  void readRow() {
    DhRow row;
    if (words_[0] == "revolute")
      row.kind = DhJoint::Revolute;
    else if (words_[0] == "prismatic")
      row.kind = DhJoint::Prismatic;
    else if (words_[0] == "fixed")
      row.kind = DhJoint::Fixed;
    else
      fail(line_, "'revolute', 'prismatic', 'fixed', 'name', 'angles', 'base', 'tool' or 'rest'", quoted(0));
    const bool mayHaveLimits = row.kind != DhJoint::Fixed;
    if (words_.size() != 5 && !(mayHaveLimits && words_.size() == 7))
      fail(line_,
           mayHaveLimits ? "the four parameters a alpha d phi, and both limits or none"
                         : "the four parameters a alpha d phi",
           count());
    row.a = number(1, "a");
    row.alpha = angle(2, "alpha");
    row.d = number(3, "d");
    row.phi = angle(4, "phi");
    if (words_.size() == 7) {
      const bool turns = row.kind == DhJoint::Revolute;
      row.lower = turns ? angle(5, "lower limit") : number(5, "lower limit");
      row.upper = turns ? angle(6, "upper limit") : number(6, "upper limit");
      if (row.lower > row.upper)
        fail(line_, "a lower limit not above the upper one", quoted(5) + " above " + quoted(6));
    }
    table_.rows.push_back(row);
  }

  double number(std::size_t i, const std::string& what) const {
    const std::optional<double> value = parseNumber(words_[i]);
    if (!value) fail(line_, "a number for " + what, badNumber(words_[i]));
    return *value;
  }
  double angle(std::size_t i, const std::string& what) const {
    const std::optional<double> value = parseAngle(words_[i]);
    if (!value) fail(line_, "a number (or a multiple of pi) for " + what, quoted(i));
    return words_[i].find("pi") == std::string_view::npos ? *value * angleUnit_ : *value;
  }

  std::string quoted(std::size_t i) const { return "'" + std::string(words_[i]) + "'"; }
  std::string count() const {
    return std::to_string(words_.size() - 1) + (words_.size() == 2 ? " value" : " values");
  }
  std::string found() const {
    std::string line;
    for (const std::string_view word : words_) line += (line.empty() ? "" : " ") + std::string(word);
    return "'" + line + "'";
  }

  std::string_view text_;
  std::string file_;
  std::vector<std::string_view> words_;
  int line_ = 0, restLine_ = 0;
  bool sawConvention_ = false;
  double angleUnit_ = 1.0;
  std::vector<bool> restIsPi_;
  DhTable table_;
};

std::string formatPlace(const char* key, const Eigen::Isometry3d& place) {
  if (place.matrix().isIdentity(0.0)) return {};
  std::string line = key;
  for (int k = 0; k < 3; ++k) line += " " + exactNumber(place.translation()[k]);
  if (!place.linear().isIdentity(0.0)) {
    const Eigen::Quaterniond q(place.linear());
    for (const double value : {q.w(), q.x(), q.y(), q.z()}) line += " " + exactNumber(value);
  }
  return line + "\n";
}

}  // namespace

DhTable parseDhTable(std::string_view text, const std::string& file) { return DhReader(text, file).read(); }

DhTable readDhTable(const std::string& path) { return parseDhTable(readFile(path), path); }

std::string formatDhTable(const DhTable& table) {
  validate(table);
  std::string text = std::string("dh ") + toString(table.convention) + "\n";
  if (!table.name.empty()) text += "name " + table.name + "\n";
  text += "angles radians\n" + formatPlace("base", table.base) + "# kind a alpha d phi [lower upper]\n";
  for (const DhRow& row : table.rows) {
    text += toString(row.kind);
    for (const double value : {row.a, row.alpha, row.d, row.phi}) text += " " + exactNumber(value);
    if (std::isfinite(row.lower) != std::isfinite(row.upper))
      throw std::invalid_argument("a row of a DH table has both limits or none; one has " +
                                  exactNumber(row.lower) + " and " + exactNumber(row.upper));
    if (std::isfinite(row.lower) && std::isfinite(row.upper))
      text += " " + exactNumber(row.lower) + " " + exactNumber(row.upper);
    text += "\n";
  }
  text += formatPlace("tool", table.tool);
  if (table.rest) {
    text += "rest";
    for (const double value : *table.rest) text += " " + exactNumber(value);
    text += "\n";
  }
  return text;
}

}  // namespace gelenk
