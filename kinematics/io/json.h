#pragma once

#include <concepts>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace gelenk {

/// A JSON value: null, truth, number (integers apart), text, list, or object whose members keep their order.
/// `Json{{"name", "arm"}, {"q", {}}}` is an object; Json::list({1.0, 2.0}) and Json(vector) are lists.
/// Reading what is not there or of another kind throws std::invalid_argument: "expected a number, found "x"".
class Json {
 public:
  struct Member;
  using List = std::vector<Json>;
  using Object = std::vector<Member>;

  Json() = default;  ///< null
  Json(std::nullptr_t) {}
  Json(bool value);
  Json(double value);
  Json(std::int64_t value);
  template <std::integral Integer>
  Json(Integer value) : Json(static_cast<std::int64_t>(value)) {}
  Json(std::string value);
  Json(std::string_view value);
  Json(const char* value);
  Json(std::initializer_list<Member> members);
  template <typename Entry>
  Json(const std::vector<Entry>& entries) : Json(list()) {
    for (const Entry& entry : entries) push(entry);
  }
  static Json list(std::initializer_list<Json> entries = {});
  static Json object() { return Json(std::initializer_list<Member>{}); }

  Json(const Json&);
  Json(Json&&) noexcept;
  Json& operator=(const Json&);
  Json& operator=(Json&&) noexcept;
  ~Json();

  /// The value of a text; file names it in messages. Throws ParseError with the line: no JSON, a key twice in
  /// one object, lists and objects nested more than 200 deep, or anything after the value.
  static Json parse(std::string_view text, const std::string& file = "JSON");
  /// indent < 0: on one line. Numbers are written so that they read back to the same bits, those that are not
  /// finite as null. Throws std::invalid_argument where a text is not UTF-8.
  std::string dump(int indent = -1) const;

  bool isNull() const { return value_.index() == 0; }
  bool isTruth() const { return value_.index() == 1; }
  bool isInteger() const { return value_.index() == 2; }
  bool isNumber() const { return isInteger() || value_.index() == 3; }
  bool isText() const { return value_.index() == 4; }
  bool isList() const { return value_.index() == 5; }
  bool isObject() const { return value_.index() == 6; }

  bool truth() const;
  double number() const;         ///< of an integer too
  std::int64_t integer() const;  ///< only of a number without fraction or exponent
  const std::string& text() const;
  const List& entries() const;    ///< of a list
  const Object& members() const;  ///< of an object
  std::size_t size() const;       ///< entries or members; 0 of anything else
  bool empty() const { return size() == 0; }

  void push(Json entry);  ///< at the end of a list; null becomes a list
  const Json& operator[](std::size_t entry) const;
  Json& operator[](std::size_t entry);

  const Json* find(std::string_view key) const;  ///< null where the object has no such member
  const Json& at(std::string_view key) const;
  Json& operator[](
      std::string_view key);  ///< adds the member, as null, where it is absent; null becomes an object

  friend bool operator==(const Json& a, const Json& b);

 private:
  std::variant<std::monostate, bool, std::int64_t, double, std::string, List, Object> value_;
};

struct Json::Member {
  std::string key;
  Json value;
  friend bool operator==(const Member& a, const Member& b);
};

}  // namespace gelenk
