#pragma once

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace gelenk {

using Json = nlohmann::ordered_json;

/// A place in the tree of a JSON file, able to say what is wrong with it: every reader throws ParseError with
/// the file, the entry, what was expected and what was found.
class JsonEntry {
 public:
  JsonEntry(const std::string& file, const Json& value, std::string path)
      : file_(file), value_(value), path_(std::move(path)) {}

  [[noreturn]] void fail(const std::string& expected, const std::string& found) const;
  [[noreturn]] void fail(const std::string& expected) const;

  std::optional<JsonEntry> find(const char* key) const;
  JsonEntry at(const char* key) const;
  std::vector<JsonEntry> list() const;
  std::vector<JsonEntry> list(std::size_t size) const;
  std::vector<std::pair<std::string, JsonEntry>> members() const;
  double number() const;  ///< finite
  double number(double lower, double upper) const;
  int integer() const;
  int integer(int lower, int upper) const;
  bool boolean() const;
  std::string text() const;
  Eigen::VectorXd vector(Eigen::Index size) const;
  Eigen::Vector3d point() const { return vector(3); }
  Eigen::Vector3d direction() const;  ///< of unit length to 1e-9
  Eigen::Quaterniond unitQuaternion() const;
  /// Table of (value, name).
  template <typename Table>
  auto oneOf(const Table& table) const {
    const std::string word = text();
    std::string known;
    for (const auto& [value, name] : table) {
      if (word == name) return value;
      known += (known.empty() ? "" : ", ") + std::string(name);
    }
    fail("one of " + known, "'" + word + "'");
  }
  const Json& value() const { return value_; }

 private:
  const std::string& file_;
  const Json& value_;
  std::string path_;
};

/// The tree of a text. Throws ParseError with the line; entries nest at most 200 deep.
Json parseJson(std::string_view text, const std::string& file);

/// Lists of numbers in one line each, everything else a line an entry.
std::string formatJson(const Json& tree);

template <typename Vector>
Json toJson(const Eigen::MatrixBase<Vector>& v) {
  Json list = Json::array();
  for (Eigen::Index i = 0; i < v.size(); ++i) list.push_back(v.derived().coeff(i));
  return list;
}
inline Json toJson(const Eigen::Quaterniond& q) { return {q.w(), q.x(), q.y(), q.z()}; }

}  // namespace gelenk
