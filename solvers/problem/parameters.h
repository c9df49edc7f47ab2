#pragma once

#include <array>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <variant>

namespace gelenk {

/// A constant of a method that its user may change: a row of a solver's table of parameters.
struct Parameter {
  std::string_view name;     ///< as typed: "lambda" in dls.lambda=0.1
  double value = 0.0;        ///< the default
  double lower = 0.0;        ///< of the range; both ends belong to it
  double upper = 0.0;        ///< likewise
  std::string_view unit;     ///< "rad", "m", ...; "1" for a ratio or a count
  std::string_view source;   ///< of the default: a paper, or "ours" where it was chosen here by experiment
  std::string_view meaning;  ///< one sentence
  bool whole = false;        ///< whole numbers only
};

/// Values by parameter; what is not named keeps its default.
using ParameterValues = std::map<std::string, double, std::less<>>;

/// Throws std::invalid_argument for a parameter that is not in the table (those that are are listed), a value
/// outside its range or not finite, a broken number where whole ones are asked for. owner: the solver's name.
void validate(std::string_view owner, std::span<const Parameter> table, const ParameterValues& values);

/// "lambda (0.05 m; 0 to 10), largest-step (0.5 rad; ...)" for messages.
std::string listed(std::span<const Parameter> table);

// A method keeps its parameters in a plain struct P whose initialisers are the defaults, and names them once:
//   static constexpr auto fields() { return std::to_array<ParameterField<P>>({{&P::lambda, "lambda", ...}});
//   }
// Everything else follows from there: the catalogue's table, and P from values by name.

template <typename P>
struct ParameterField {
  std::variant<double P::*, int P::*> member;
  std::string_view name;
  double lower, upper;
  std::string_view unit, source, meaning;
};

namespace detail {

template <typename P>
constexpr auto parameterTable() {
  constexpr auto fields = P::fields();
  std::array<Parameter, fields.size()> table;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const ParameterField<P>& f = fields[i];
    const double value = std::visit([](auto member) { return static_cast<double>(P{}.*member); }, f.member);
    table[i] = {f.name, value, f.lower, f.upper, f.unit, f.source, f.meaning, f.member.index() == 1};
  }
  return table;
}

}  // namespace detail

template <typename P>
inline constexpr auto parametersOf = detail::parameterTable<P>();

/// The struct with the named values put in; they must be valid.
template <typename P>
P withValues(const ParameterValues& values) {
  P parameters;
  for (const ParameterField<P>& field : P::fields())
    if (const auto found = values.find(field.name); found != values.end())
      std::visit(
          [&](auto member) {
            parameters.*member = static_cast<std::decay_t<decltype(parameters.*member)>>(found->second);
          },
          field.member);
  return parameters;
}

}  // namespace gelenk
