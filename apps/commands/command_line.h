#pragma once

#include <functional>
#include <initializer_list>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace gelenk {

// Subcommands and their options, declared where a command is written; command_line.cpp alone knows the
// library that parses.

/// An option or a positional argument of a command; refinements can be chained.
class Option {
 public:
  /// number: what an error calls its value, "a whole number"; empty where it is no number.
  explicit Option(CLI::Option* option, std::string number = "")
      : option_(option), number_(std::move(number)) {}
  Option& required();
  Option& showDefault();  ///< the value that it has now stands in the help text
  Option& oneOf(const std::vector<std::string>& words);  ///< other words are refused with the list
  Option& positive();                                    ///< a number above zero
  Option& nonNegative();
  Option& range(double low, double high);
  Option& frameRate() { return range(0.01, 10000.0); }  ///< frames a second
  Option& count(int values);                            ///< so many values, not more or fewer
  Option& commas();                       ///< of a list: several values in one word, between commas
  Option& oneAtATime();                   ///< of a list: every value wants the option's name before it
  Option& excludes(const Option& other);  ///< refused beside the other
  Option& needs(const Option& other);     ///< refused where the other is not given

 private:
  Option& demand(const std::string& where, std::function<bool(double)> holds);

  CLI::Option* option_;
  std::string number_;
};

/// The program or one of its commands.
class Command {
 public:
  explicit Command(CLI::App* app) : app_(app) {}
  Command command(const std::string& name, const std::string& help);

  /// names: "--name", "-n,--name", or "name" of a positional argument. value is set by parsing and must
  /// outlive it. Value: std::string, int, double, std::uint64_t, std::vector or std::optional of them as
  /// listed in command_line.cpp. Refused are what is no finite number where a number is wanted, and empty
  /// words.
  template <typename Value>
  Option option(const std::string& names, Value& value, const std::string& help);
  Option flag(const std::string& names, bool& value, const std::string& help);

  void
  optionsAnywhere();  ///< its own options may also stand behind the name of a command that is added later
  void notes(const std::string& text);     ///< below the options in the help text
  void run(std::function<void()> action);  ///< called where the command was given, after all options are set
  bool given() const;                      ///< after parsing

 private:
  CLI::App* app_;
};

/// Thrown by a command to end the program with this status and no message.
struct ExitStatus {
  int status;
};

/// The words do not fit the options.
class UsageError : public std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

/// The whole program: add commands to root(), then parse or run.
class CommandLine {
 public:
  CommandLine(const std::string& description, const std::string& version);
  ~CommandLine();
  Command root();

  /// Parses the words after the program's name and runs the chosen command. Throws UsageError, and what the
  /// command throws.
  void parse(std::vector<std::string> words);
  /// The same for main: help, version and errors are printed (one sentence on standard error); returns the
  /// exit status.
  int run(int argc, char** argv);

 private:
  std::unique_ptr<CLI::App> app_;
};

}  // namespace gelenk
