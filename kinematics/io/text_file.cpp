#include "kinematics/io/text_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <system_error>

#include "kinematics/io/parse_error.h"

namespace gelenk {

std::string readFile(const std::string& path) {
  struct stat status;
  if (stat(path.c_str(), &status) == 0 && S_ISDIR(status.st_mode))
    throw std::system_error(EISDIR, std::generic_category(), "cannot read " + path);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
  if (!file) throw std::system_error(errno, std::generic_category(), "cannot open " + path);
  std::string content;
  char block[1 << 16];
  while (const std::size_t n = std::fread(block, 1, sizeof block, file.get())) content.append(block, n);
  if (std::ferror(file.get())) throw std::system_error(errno, std::generic_category(), "cannot read " + path);
  return content;
}

void writeFile(const std::string& path, std::string_view content) {
  const std::string temporary = path + ".tmp" + std::to_string(getpid());
  const auto fail = [&](const char* what) {
    const int reason = errno;
    std::remove(temporary.c_str());
    throw std::system_error(reason, std::generic_category(), std::string(what) + " " + path);
  };
  std::FILE* file = std::fopen(temporary.c_str(), "wb");
  if (!file) fail("cannot write");
  const bool written = std::fwrite(content.data(), 1, content.size(), file) == content.size();
  if (std::fclose(file) != 0 || !written) fail("cannot write");
  if (std::rename(temporary.c_str(), path.c_str()) != 0) fail("cannot replace");
}

std::string_view plainText(std::string_view text, const std::string& file) {
  using namespace std::string_view_literals;
  struct Encoding {
    std::string_view name, mark, letters;  ///< letters: which of the first four bytes are zero in Latin text
  };
  static constexpr Encoding others[] = {{"UTF-32LE", "\xff\xfe\0\0"sv, "x000"},
                                        {"UTF-32BE", "\0\0\xfe\xff"sv, "000x"},
                                        {"UTF-16LE", "\xff\xfe"sv, "x0x0"},
                                        {"UTF-16BE", "\xfe\xff"sv, "0x0x"}};
  std::string zeros;
  for (const char byte : text.substr(0, 4)) zeros += byte == '\0' ? '0' : 'x';
  for (const Encoding& other : others)
    if (text.starts_with(other.mark) || zeros == other.letters)
      throw ParseError(file, 1, "text in UTF-8", std::string(other.name) + ": save it as UTF-8");
  if (text.starts_with("\xef\xbb\xbf"sv)) text.remove_prefix(3);
  return text;
}

std::vector<std::string_view> splitLines(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    lines.push_back(line);
    if (end == std::string_view::npos) break;
    text.remove_prefix(end + 1);
  }
  return lines;
}

std::vector<std::string_view> splitWords(std::string_view line) {
  std::vector<std::string_view> words;
  std::size_t at = 0;
  while ((at = line.find_first_not_of(" \t\r\f\v", at)) != std::string_view::npos) {
    const std::size_t end = std::min(line.find_first_of(" \t\r\f\v", at), line.size());
    words.push_back(line.substr(at, end - at));
    at = end;
  }
  return words;
}

std::optional<double> parseNumber(std::string_view word) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size()) return std::nullopt;
  if (error == std::errc::result_out_of_range) {  // an underflow reads as 0, an overflow is no number
    const std::size_t exponent = word.find_first_of("eE");
    if (exponent != std::string_view::npos && exponent + 1 < word.size() && word[exponent + 1] == '-')
      return 0.0;
    return std::nullopt;
  }
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<int> parseInteger(std::string_view word) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  int value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

std::string badNumber(std::string_view word) {
  constexpr std::size_t longest = 60;
  const std::string quoted =
      "'" + std::string(word.substr(0, longest)) + (word.size() > longest ? "...'" : "'");
  const auto because = [&](const std::string& reason) { return quoted + " (" + reason + ")"; };
  std::string lower;
  for (const char c : word) lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const bool digits = lower.find_first_of("0123456789") != std::string::npos;
  if (lower.find("nan") != std::string::npos || lower.find("ind") != std::string::npos)
    return because("not a number");
  if (lower.find("inf") != std::string::npos) return because("infinity");
  if (!digits) return quoted;
  const std::size_t e = lower.find_first_of("ed");
  if (e != std::string::npos && e > 0 && (lower[e - 1] == '+' || lower[e - 1] == '-'))
    return because("the sign of an exponent stands after the e");
  if (e != std::string::npos && lower[e] == 'd') return because("an exponent begins with e");
  if (e != std::string::npos && lower.find_first_of("0123456789", e) == std::string::npos)
    return because("an exponent without digits");
  if (lower.find(',') != std::string::npos) return because("the decimal point is a point, not a comma");
  if (std::count(lower.begin(), lower.end(), '.') > 1) return because("two decimal points");
  if (lower.starts_with("0x")) return because("numbers are decimal");
  if (lower.find_first_not_of("0123456789.e+-") == std::string::npos && e != std::string::npos)
    return because("too large, or not one number");
  return because("other characters in a number");
}

std::string exactNumber(double value) {
  char buffer[32];
  const auto [end, error] = std::to_chars(buffer, buffer + sizeof buffer, value);
  return std::string(buffer, end);
}

}  // namespace gelenk
