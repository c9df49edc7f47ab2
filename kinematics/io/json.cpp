#include "kinematics/io/json.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "kinematics/io/parse_error.h"

namespace gelenk {
namespace {

constexpr std::size_t deepestNesting = 200;

[[noreturn]] void mismatch(const char* expected, const Json& found) {
  std::string text = found.dump();
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  throw std::invalid_argument(std::string("expected ") + expected + ", found " + text);
}

/// Takes what nlohmann's parser reads and builds the tree of it.
class Builder : public nlohmann::json_sax<nlohmann::json> {
 public:
  Builder(std::string_view text, const std::string& file) : text_(text), file_(file) {}
  Json result() && { return std::move(root_); }

  bool null() override { return add({}); }
  bool boolean(bool value) override { return add(value); }
  bool number_integer(std::int64_t value) override { return add(value); }
  bool number_unsigned(std::uint64_t value) override {
    return value <= static_cast<std::uint64_t>(INT64_MAX) ? add(static_cast<std::int64_t>(value))
                                                          : add(static_cast<double>(value));
  }
  bool number_float(double value, const std::string&) override { return add(value); }
  bool string(std::string& value) override { return add(std::move(value)); }
  bool binary(nlohmann::json::binary_t&) override { return false; }  // not in texts
  bool start_object(std::size_t) override { return open(Json::object()); }
  bool start_array(std::size_t) override { return open(Json::list()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool key(std::string& name) override {
    if (open_.back()->find(name))
      throw ParseError(file_, 0, "every key once", "\"" + name + "\" twice in one object");
    key_ = std::move(name);
    return true;
  }
  bool parse_error(std::size_t position, const std::string& token,
                   const nlohmann::json::exception&) override {
    const std::string_view before = text_.substr(0, std::min(position, text_.size()));
    const int line = 1 + static_cast<int>(std::count(before.begin(), before.end(), '\n'));
    throw ParseError(file_, line, "JSON", token.empty() ? "the end of the file" : "'" + token + "'");
  }

 private:
  Json& place(Json value) {
    if (open_.empty()) return root_ = std::move(value);
    if (open_.back()->isObject()) return (*open_.back())[key_] = std::move(value);
    open_.back()->push(std::move(value));
    return (*open_.back())[open_.back()->size() - 1];
  }
  bool add(Json value) {
    place(std::move(value));
    return true;
  }
  bool open(Json value) {
    if (open_.size() >= deepestNesting)
      throw ParseError(file_, 0, "at most 200 nested lists and objects", "more");
    open_.push_back(&place(std::move(value)));
    return true;
  }
  bool close() {
    open_.pop_back();
    return true;
  }

  std::string_view text_;
  const std::string& file_;
  Json root_;
  std::vector<Json*>
      open_;  ///< from the root down; only the last one grows, so the others stay where they are
  std::string key_;
};

void write(const Json& value, int indent, int depth, std::string& out) {
  const auto newLine = [&](int level) {
    if (indent >= 0) out += '\n' + std::string(static_cast<std::size_t>(indent * level), ' ');
  };
  const auto leaf = [&](const nlohmann::json& library) {
    try {
      out += library.dump();
    } catch (const nlohmann::json::exception&) {
      throw std::invalid_argument("a text is not UTF-8 and cannot be written as JSON");
    }
  };
  if (value.isList() || value.isObject()) {
    const bool list = value.isList();
    out += list ? '[' : '{';
    for (std::size_t i = 0; i < value.size(); ++i) {
      if (i > 0) out += ',';
      newLine(depth + 1);
      if (!list) {
        leaf(value.members()[i].key);
        out += indent >= 0 ? ": " : ":";
      }
      write(list ? value.entries()[i] : value.members()[i].value, indent, depth + 1, out);
    }
    if (!value.empty()) newLine(depth);
    out += list ? ']' : '}';
  } else if (value.isNull()) {
    out += "null";
  } else if (value.isTruth()) {
    out += value.truth() ? "true" : "false";
  } else if (value.isInteger()) {
    out += std::to_string(value.integer());
  } else if (value.isNumber()) {
    leaf(value.number());
  } else {
    leaf(value.text());
  }
}

}  // namespace

Json::Json(bool value) : value_(value) {}
Json::Json(double value) : value_(value) {}
Json::Json(std::int64_t value) : value_(value) {}
Json::Json(std::string value) : value_(std::move(value)) {}
Json::Json(std::string_view value) : value_(std::string(value)) {}
Json::Json(const char* value) : value_(std::string(value)) {}
Json::Json(std::initializer_list<Member> members) : value_(Object(members)) {}
Json Json::list(std::initializer_list<Json> entries) {
  Json list;
  list.value_ = List(entries);
  return list;
}
Json::Json(const Json&) = default;
Json::Json(Json&&) noexcept = default;
Json& Json::operator=(const Json&) = default;
Json& Json::operator=(Json&&) noexcept = default;
Json::~Json() = default;

Json Json::parse(std::string_view text, const std::string& file) {
  Builder builder(text, file);
  nlohmann::json::sax_parse(text.begin(), text.end(), &builder);
  return std::move(builder).result();
}

std::string Json::dump(int indent) const {
  std::string out;
  write(*this, indent, 0, out);
  return out;
}

bool Json::truth() const {
  if (!isTruth()) mismatch("true or false", *this);
  return std::get<bool>(value_);
}
double Json::number() const {
  if (!isNumber()) mismatch("a number", *this);
  return isInteger() ? static_cast<double>(std::get<std::int64_t>(value_)) : std::get<double>(value_);
}
std::int64_t Json::integer() const {
  if (!isInteger()) mismatch("an integer", *this);
  return std::get<std::int64_t>(value_);
}
const std::string& Json::text() const {
  if (!isText()) mismatch("a text", *this);
  return std::get<std::string>(value_);
}
const Json::List& Json::entries() const {
  if (!isList()) mismatch("a list [...]", *this);
  return std::get<List>(value_);
}
const Json::Object& Json::members() const {
  if (!isObject()) mismatch("an object {...}", *this);
  return std::get<Object>(value_);
}
std::size_t Json::size() const {
  return isList() ? std::get<List>(value_).size() : isObject() ? std::get<Object>(value_).size() : 0;
}

void Json::push(Json entry) {
  if (isNull()) value_ = List();
  if (!isList()) mismatch("a list [...]", *this);
  std::get<List>(value_).push_back(std::move(entry));
}
const Json& Json::operator[](std::size_t entry) const {
  if (entry >= entries().size())
    mismatch(("a list of more than " + std::to_string(entry) + " entries").c_str(), *this);
  return entries()[entry];
}
Json& Json::operator[](std::size_t entry) { return const_cast<Json&>(std::as_const(*this)[entry]); }

const Json* Json::find(std::string_view key) const {
  const Object& all = members();
  const auto it = std::find_if(all.begin(), all.end(), [&](const Member& m) { return m.key == key; });
  return it == all.end() ? nullptr : &it->value;
}
const Json& Json::at(std::string_view key) const {
  if (const Json* value = find(key)) return *value;
  mismatch(("an entry \"" + std::string(key) + "\"").c_str(), *this);
}
Json& Json::operator[](std::string_view key) {
  if (isNull()) value_ = Object();
  if (const Json* value = find(key)) return const_cast<Json&>(*value);
  std::get<Object>(value_).push_back({std::string(key), Json()});
  return std::get<Object>(value_).back().value;
}

bool operator==(const Json& a, const Json& b) {
  return a.isNumber() && b.isNumber() && a.isInteger() != b.isInteger() ? a.number() == b.number()
                                                                        : a.value_ == b.value_;
}
bool operator==(const Json::Member& a, const Json::Member& b) { return a.key == b.key && a.value == b.value; }

}  // namespace gelenk
