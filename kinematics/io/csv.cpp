#include "kinematics/io/csv.h"

#include <algorithm>

namespace gelenk {

std::string csvField(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

std::string csvLine(std::span<const std::string> fields) {
  std::string line;
  for (const std::string& field : fields) line += (&field == fields.data() ? "" : ",") + csvField(field);
  return line + '\n';
}

bool CsvReader::next(std::vector<std::string>& fields) {
  fields.clear();
  if (rest_.empty()) return false;
  line_ = nextLine_;
  fields.emplace_back();
  std::size_t at = 0;
  bool quoted = false, wasQuoted = false;  // the carriage return of a quoted field is its own
  complete_ = false;
  for (; at < rest_.size() && !complete_; ++at) {
    const char c = rest_[at];
    if (quoted) {
      const bool doubled = c == '"' && at + 1 < rest_.size() && rest_[at + 1] == '"';
      if (c != '"')
        fields.back() += c;
      else if (doubled)
        fields.back() += rest_[++at];
      else
        quoted = false;
    } else if (c == '"' && fields.back().empty()) {
      quoted = wasQuoted = true;
    } else if (c == ',') {
      fields.emplace_back();
      wasQuoted = false;
    } else if (c == '\n') {
      complete_ = true;
      if (!wasQuoted && !fields.back().empty() && fields.back().back() == '\r') fields.back().pop_back();
    } else {
      fields.back() += c;
    }
  }
  record_ = rest_.substr(0, at);
  rest_.remove_prefix(at);
  nextLine_ += static_cast<int>(std::count(record_.begin(), record_.end(), '\n'));
  return true;
}

}  // namespace gelenk
