#pragma once

// What the C++20 of this tree uses and libc++ 13, the language library of Debian 12's emscripten, lacks:
// algorithms over ranges and floating-point numbers from and to characters. Included before every file of the
// browser's build; with a newer library it is empty.
#include <version>
#if defined(_LIBCPP_VERSION) && _LIBCPP_VERSION < 14000

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <iterator>
#include <string>

namespace std {
namespace ranges {

namespace gaps {
struct Same {
  template <class T>
  constexpr T&& operator()(T&& value) const {
    return std::forward<T>(value);
  }
};
}  // namespace gaps

template <class Range, class Test, class Part = gaps::Same>
auto find_if(Range&& range, Test test, Part part = {}) {
  return std::find_if(std::begin(range), std::end(range),
                      [&](auto&& x) { return std::invoke(test, std::invoke(part, x)); });
}
template <class Range, class Value, class Part = gaps::Same>
auto find(Range&& range, const Value& value, Part part = {}) {
  return ranges::find_if(
      range, [&](auto&& x) { return x == value; }, part);
}
template <class Range, class Test, class Part = gaps::Same>
auto count_if(Range&& range, Test test, Part part = {}) {
  return std::count_if(std::begin(range), std::end(range),
                       [&](auto&& x) { return std::invoke(test, std::invoke(part, x)); });
}
template <class Range, class Value, class Part = gaps::Same>
auto count(Range&& range, const Value& value, Part part = {}) {
  return ranges::count_if(
      range, [&](auto&& x) { return x == value; }, part);
}
template <class Range, class Test, class Part = gaps::Same>
bool any_of(Range&& range, Test test, Part part = {}) {
  return ranges::find_if(range, test, part) != std::end(range);
}
template <class Range, class Test, class Part = gaps::Same>
bool none_of(Range&& range, Test test, Part part = {}) {
  return !ranges::any_of(range, test, part);
}
template <class Range, class Test, class Part = gaps::Same>
bool all_of(Range&& range, Test test, Part part = {}) {
  return !ranges::any_of(
      range, [&](auto&& x) { return !std::invoke(test, x); }, part);
}
template <class Range, class Value>
bool contains(Range&& range, const Value& value) {
  return ranges::find(range, value) != std::end(range);
}
template <class A, class B, class Test = std::equal_to<>>
bool equal(A&& a, B&& b, Test test = {}) {
  return std::equal(std::begin(a), std::end(a), std::begin(b), std::end(b), test);
}
template <class Order, class Part>
auto by(Order& order, Part& part) {
  return [&](const auto& a, const auto& b) {
    return std::invoke(order, std::invoke(part, a), std::invoke(part, b));
  };
}
template <class Range, class Order = std::less<>, class Part = gaps::Same>
auto max_element(Range&& range, Order order = {}, Part part = {}) {
  return std::max_element(std::begin(range), std::end(range), by(order, part));
}
template <class Range, class Order = std::less<>, class Part = gaps::Same>
auto min_element(Range&& range, Order order = {}, Part part = {}) {
  return std::min_element(std::begin(range), std::end(range), by(order, part));
}
template <class Range, class Order = std::less<>, class Part = gaps::Same>
void sort(Range&& range, Order order = {}, Part part = {}) {
  std::sort(std::begin(range), std::end(range), by(order, part));
}
template <class Range, class Order = std::less<>, class Part = gaps::Same>
void stable_sort(Range&& range, Order order = {}, Part part = {}) {
  std::stable_sort(std::begin(range), std::end(range), by(order, part));
}
template <class Range, class Order = std::less<>, class Part = gaps::Same>
bool is_sorted(Range&& range, Order order = {}, Part part = {}) {
  return std::is_sorted(std::begin(range), std::end(range), by(order, part));
}
template <class Range, class Out, class Function, class Part = gaps::Same>
void transform(Range&& range, Out out, Function function, Part part = {}) {
  std::transform(std::begin(range), std::end(range), out,
                 [&](auto&& x) { return std::invoke(function, std::invoke(part, x)); });
}
template <class Range, class Out>
Out copy(Range&& range, Out out) {
  return std::copy(std::begin(range), std::end(range), out);
}
template <class Range, class Value>
void fill(Range&& range, const Value& value) {
  std::fill(std::begin(range), std::end(range), value);
}
template <class Range>
void reverse(Range&& range) {
  std::reverse(std::begin(range), std::end(range));
}

}  // namespace ranges

/// As from_chars reads: no blanks and no + before it, decimal digits only, inf and nan.
inline from_chars_result from_chars(const char* first, const char* last, double& value) {
  const std::size_t all = static_cast<std::size_t>(last - first);
  std::size_t length = 0;
  while (length < all && std::strchr("+-.0123456789eEinfINFatyATY", first[length]) && first[length] != '\0')
    ++length;
  if (length == 0 || first[0] == '+') return {first, errc::invalid_argument};
  const std::string word(first, length);
  char* end = nullptr;
  const double read = std::strtod(word.c_str(), &end);
  if (end == word.c_str()) return {first, errc::invalid_argument};
  const char* after = first + (end - word.c_str());
  const bool named = word.find_first_of("nN") != std::string::npos;  // inf, nan
  if (std::isinf(read) && !named) return {after, errc::result_out_of_range};
  if (read == 0.0 && word.substr(0, static_cast<std::size_t>(end - word.c_str())).find_first_of("123456789") <
                         word.find_first_of("eE"))
    return {after, errc::result_out_of_range};
  value = read;
  return {after, errc{}};
}

/// The fewest digits that are read back as the same number: their count, as %.*e takes it.
inline int shortestDigits(double value) {
  char text[40];
  for (int digits = 0; digits < 17; ++digits) {
    std::snprintf(text, sizeof text, "%.*e", digits, value);
    if (std::strtod(text, nullptr) == value) return digits;
  }
  return 17;
}
inline to_chars_result writeTo(char* first, char* last, const std::string& text) {
  if (last - first < static_cast<std::ptrdiff_t>(text.size())) return {last, errc::value_too_large};
  return {std::copy(text.begin(), text.end(), first), errc{}};
}
inline to_chars_result to_chars(char* first, char* last, double value, chars_format format, int precision) {
  char text[512];
  std::snprintf(text, sizeof text,
                format == chars_format::fixed        ? "%.*f"
                : format == chars_format::scientific ? "%.*e"
                                                     : "%.*g",
                precision, value);
  return writeTo(first, last, text);
}
/// Plain digits: as many as it takes.
inline to_chars_result to_chars(char* first, char* last, double value, chars_format format) {
  if (!std::isfinite(value))
    return writeTo(first, last, std::isnan(value) ? "nan" : value < 0.0 ? "-inf" : "inf");
  const int digits = shortestDigits(value);
  if (format != chars_format::fixed) return to_chars(first, last, value, format, digits);
  char text[40];
  std::snprintf(text, sizeof text, "%.*e", digits, value);
  const int exponent = std::atoi(std::strchr(text, 'e') + 1);
  return to_chars(first, last, value, format, std::max(0, digits - exponent));
}
/// The shorter of plain digits and exponent, plain digits where they tie.
inline to_chars_result to_chars(char* first, char* last, double value) {
  char plain[400], power[40];
  const to_chars_result a = to_chars(plain, plain + sizeof plain, value, chars_format::fixed);
  const to_chars_result b = to_chars(power, power + sizeof power, value, chars_format::scientific);
  return a.ptr - plain <= b.ptr - power ? writeTo(first, last, std::string(plain, a.ptr))
                                        : writeTo(first, last, std::string(power, b.ptr));
}

}  // namespace std

#endif
