#include "apps/document/json_entry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kinematics/io/parse_error.h"

namespace gelenk {
namespace {

constexpr int deepestNesting = 200;

std::string shown(const Json& value) {
  const std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  return text.size() > 60 ? text.substr(0, 57) + "..." : text;
}

bool isFlat(const Json& list) {
  return std::ranges::all_of(list, [](const Json& entry) { return entry.is_number(); });
}

void format(const Json& value, int indent, std::string& out) {
  if (!value.is_structured() || value.empty() || (value.is_array() && isFlat(value))) {
    out += value.dump();
    return;
  }
  const std::string line = "\n" + std::string(indent + 1, ' ');
  out += value.is_object() ? "{" : "[";
  bool first = true;
  for (const auto& [key, entry] : value.items()) {
    out += (first ? "" : ",") + line;
    if (value.is_object()) out += Json(key).dump() + ": ";
    format(entry, indent + 1, out);
    first = false;
  }
  out += "\n" + std::string(indent, ' ') + (value.is_object() ? "}" : "]");
}

}  // namespace

void JsonEntry::fail(const std::string& expected, const std::string& found) const {
  throw ParseError(file_, 0, (path_.empty() ? "" : path_ + ": ") + expected, found);
}
void JsonEntry::fail(const std::string& expected) const { fail(expected, shown(value_)); }

std::optional<JsonEntry> JsonEntry::find(const char* key) const {
  if (!value_.is_object()) fail("an object {...}");
  const auto it = value_.find(key);
  if (it == value_.end()) return std::nullopt;
  return JsonEntry(file_, *it, path_.empty() ? key : path_ + "." + key);
}

JsonEntry JsonEntry::at(const char* key) const {
  if (const auto entry = find(key)) return *entry;
  fail(fmt::format("an entry \"{}\"", key), "none");
}

std::vector<JsonEntry> JsonEntry::list() const {
  if (!value_.is_array()) fail("a list [...]");
  std::vector<JsonEntry> entries;
  for (std::size_t i = 0; i < value_.size(); ++i)
    entries.emplace_back(file_, value_[i], fmt::format("{}[{}]", path_, i));
  return entries;
}

std::vector<JsonEntry> JsonEntry::list(std::size_t size) const {
  auto entries = list();
  if (entries.size() != size)
    fail(fmt::format("a list of {} entries", size), fmt::format("{}", entries.size()));
  return entries;
}

std::vector<std::pair<std::string, JsonEntry>> JsonEntry::members() const {
  if (!value_.is_object()) fail("an object {...}");
  std::vector<std::pair<std::string, JsonEntry>> members;
  for (const auto& [key, value] : value_.items())
    members.emplace_back(key, JsonEntry(file_, value, path_.empty() ? key : path_ + "." + key));
  return members;
}

double JsonEntry::number() const {
  if (!value_.is_number()) fail("a number");
  const double x = value_.get<double>();
  if (!std::isfinite(x)) fail("a finite number");
  return x;
}

double JsonEntry::number(double lower, double upper) const {
  const double x = number();
  if (!(x >= lower && x <= upper))
    fail(fmt::format("a number from {} to {}", lower, upper), fmt::format("{}", x));
  return x;
}

int JsonEntry::integer() const {
  if (!value_.is_number_integer() || value_.get<double>() < -2147483648.0 ||
      value_.get<double>() > 2147483647.0)
    fail("an integer of 32 bits");
  return value_.get<int>();
}

int JsonEntry::integer(int lower, int upper) const {
  const int i = integer();
  if (i < lower || i > upper)
    fail(fmt::format("an integer from {} to {}", lower, upper), fmt::format("{}", i));
  return i;
}

bool JsonEntry::boolean() const {
  if (!value_.is_boolean()) fail("true or false");
  return value_.get<bool>();
}

std::string JsonEntry::text() const {
  if (!value_.is_string()) fail("a text");
  return value_.get<std::string>();
}

Eigen::VectorXd JsonEntry::vector(Eigen::Index size) const {
  const std::vector<JsonEntry> entries = list();
  if (static_cast<Eigen::Index>(entries.size()) != size)
    fail(fmt::format("{} numbers", size), fmt::format("{}", entries.size()));
  Eigen::VectorXd v(size);
  for (Eigen::Index i = 0; i < size; ++i) v[i] = entries[i].number();
  return v;
}

Eigen::Vector3d JsonEntry::direction() const {
  const Eigen::Vector3d v = point();
  if (std::abs(v.norm() - 1.0) > 1e-9) fail("a vector of unit length");
  return v;
}

Eigen::Quaterniond JsonEntry::unitQuaternion() const {
  const Eigen::VectorXd v = vector(4);
  if (std::abs(v.norm() - 1.0) > 1e-9)
    fail("a unit quaternion (w, x, y, z)", fmt::format("length {}", v.norm()));
  return {v[0], v[1], v[2], v[3]};
}

Json parseJson(std::string_view text, const std::string& file) {
  try {
    return Json::parse(
        text, [&](int depth, Json::parse_event_t, Json&) {  // writing and telling a tree recurse
          if (depth > deepestNesting)
            throw ParseError(file, 0, fmt::format("entries nested at most {} deep", deepestNesting), "more");
          return true;
        });
  } catch (const Json::parse_error& error) {
    const int line = 1 + static_cast<int>(std::count(text.begin(),
                                                     text.begin() + std::min(error.byte, text.size()), '\n'));
    throw ParseError(
        file, line, "JSON",
        error.byte >= text.size() ? "the end of the file" : "a character that does not belong there");
  } catch (const Json::out_of_range&) {  // thrown for nothing else while reading
    throw ParseError(file, 0, "numbers that a double can hold", "a larger one");
  }
}

std::string formatJson(const Json& tree) {
  std::string out;
  format(tree, 0, out);
  return out + "\n";
}

}  // namespace gelenk
