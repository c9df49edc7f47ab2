#include "apps/commands/command_line.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <type_traits>

#include "kinematics/io/text_file.h"

namespace gelenk {
namespace {

/// What one word of an option is read as.
template <typename Value>
struct Element {
  using Type = Value;
};
template <typename Value>
struct Element<std::optional<Value>> : Element<Value> {};
template <typename Value>
struct Element<std::vector<Value>> : Element<Value> {};

/// The library that parses takes "nan" and "inf" for numbers: no command can use them.
std::string whyNoNumber(const std::string& word) {
  return parseNumber(word) ? "" : "expected a number, found " + badNumber(word);
}

/// Commands keep what is not given as an empty text: it must not look as if it were not given.
std::string whyNoWord(const std::string& word) { return word.empty() ? "expected a word, found ''" : ""; }

template <typename Whole>
std::string whyNotWhole(const std::string& word) {
  Whole value;
  const char *begin = word.data() + word.starts_with('+'), *end = word.data() + word.size();
  const auto [read, error] = std::from_chars(begin, end, value);
  return read == end && error == std::errc() ? "" : "expected a whole number, found '" + word + "'";
}

}  // namespace

Option& Option::required() { return option_->required(), *this; }
Option& Option::showDefault() { return option_->capture_default_str(), *this; }
Option& Option::oneOf(const std::vector<std::string>& words) {
  const auto fault = [words](const std::string& word) -> std::string {
    if (std::ranges::count(words, word) > 0) return "";
    return fmt::format("expected one of {}, found '{}'", fmt::join(words, ", "), word);
  };
  return option_->check(fault, fmt::format("{{{}}}", fmt::join(words, ","))), *this;
}
Option& Option::positive() {
  return demand("above 0", [](double value) { return value > 0.0; });
}
Option& Option::nonNegative() {
  return demand("of 0 or above", [](double value) { return value >= 0.0; });
}
Option& Option::range(double low, double high) {
  return demand(fmt::format("from {} to {}", low, high),
                [=](double value) { return low <= value && value <= high; });
}
Option& Option::demand(const std::string& where, std::function<bool(double)> holds) {
  const auto fault = [number = number_, where, holds](const std::string& word) -> std::string {
    const auto value = parseNumber(word);
    if (value && holds(*value)) return "";
    return fmt::format("expected {} {}, found {}", number, where, word);
  };
  return option_->check(fault, where), *this;
}
Option& Option::count(int values) { return option_->expected(values), *this; }
Option& Option::excludes(const Option& other) { return option_->excludes(other.option_), *this; }
Option& Option::commas() { return option_->delimiter(','), *this; }
Option& Option::oneAtATime() { return option_->allow_extra_args(false), *this; }
Option& Option::needs(const Option& other) { return option_->needs(other.option_), *this; }

Command Command::command(const std::string& name, const std::string& help) {
  return Command(app_->add_subcommand(name, help));
}
template <typename Value>
Option Command::option(const std::string& names, Value& value, const std::string& help) {
  CLI::Option* option = app_->add_option(names, value, help);
  using Number = typename Element<Value>::Type;
  if constexpr (std::is_floating_point_v<Number>)
    return Option(option->check(whyNoNumber), "a number");
  else if constexpr (std::is_integral_v<Number>)
    return Option(option->check(whyNotWhole<Number>), "a whole number");
  else
    return Option(option->check(whyNoWord));
}
template Option Command::option(const std::string&, std::string&, const std::string&);
template Option Command::option(const std::string&, int&, const std::string&);
template Option Command::option(const std::string&, double&, const std::string&);
template Option Command::option(const std::string&, unsigned long&, const std::string&);
template Option Command::option(const std::string&, unsigned long long&, const std::string&);
template Option Command::option(const std::string&, std::optional<double>&, const std::string&);
template Option Command::option(const std::string&, std::optional<int>&, const std::string&);
template Option Command::option(const std::string&, std::vector<std::string>&, const std::string&);
template Option Command::option(const std::string&, std::vector<double>&, const std::string&);

Option Command::flag(const std::string& names, bool& value, const std::string& help) {
  return Option(app_->add_flag(names, value, help));
}
void Command::optionsAnywhere() { app_->fallthrough(); }
void Command::notes(const std::string& text) { app_->footer(text); }
void Command::run(std::function<void()> action) { app_->callback(std::move(action)); }
bool Command::given() const { return app_->parsed(); }

CommandLine::CommandLine(const std::string& description, const std::string& version)
    : app_(std::make_unique<CLI::App>(description)) {
  app_->set_version_flag("--version", version);
  app_->require_subcommand(1);
}
CommandLine::~CommandLine() = default;
Command CommandLine::root() { return Command(app_.get()); }

void CommandLine::parse(std::vector<std::string> words) {
  std::reverse(words.begin(), words.end());  // CLI11 takes them from the back
  try {
    app_->parse(std::move(words));
  } catch (const CLI::Error& error) {
    throw UsageError(error.what());
  }
}

int CommandLine::run(int argc, char** argv) {
  try {
    app_->parse(argc, argv);
  } catch (const ExitStatus& answer) {
    return answer.status;
  } catch (const CLI::Error& error) {
    return app_->exit(error) == 0 ? 0 : 1;  // --help and --version are no mistakes
  } catch (const std::exception& error) {
    std::fprintf(stderr, "gelenk: %s\n", error.what());
    return 1;
  }
  return 0;
}

}  // namespace gelenk
