#include <algorithm>
#include <array>
#include <atomic>
#include <stdexcept>
#include <type_traits>

#include "kinematics/io/text_file.h"
#include "solvers/ceres/ceres_solver.h"
#include "solvers/default_solver.h"
#include "solvers/methods/ball_chain.h"
#include "solvers/methods/ccd.h"
#include "solvers/methods/evolution.h"
#include "solvers/methods/fabrik.h"
#include "solvers/methods/newton.h"
#include "solvers/methods/qp.h"
#include "solvers/methods/quasi_newton.h"
#include "solvers/methods/step_rules.h"
#include "solvers/methods/task_priority.h"
#include "solvers/methods/two_link.h"
#include "solvers/own_entries.h"
#include "solvers/peers/kdl_peer.h"
#include "solvers/problem/ik_solver.h"
#include "solvers/serial/pose_goals.h"
#include "solvers/serial/serial_pose.h"
#include "solvers/solutions/closed_form_solver.h"
#include "solvers/tree/drag_solver.h"

namespace gelenk {
namespace {

using Wrapper = std::unique_ptr<IkSolver> (*)(std::unique_ptr<IkSolver>);
std::unique_ptr<IkSolver> asItIs(std::unique_ptr<IkSolver> solver) { return solver; }

template <typename P>
P parametersTaken(std::unique_ptr<IkSolver> (*)(const P&));

/// A row from a maker: of no parameters, or of one struct of them (parameters.h). wrap: what the solver is
/// put into.
template <auto make, Wrapper wrap = &asItIs>
constexpr SolverEntry row(std::string_view name, std::string_view title, std::string_view reference,
                          bool stochastic = false) {
  if constexpr (std::is_invocable_v<decltype(make)>) {
    return {name, title, reference, {}, [](const ParameterValues&) { return wrap(make()); }, stochastic};
  } else {
    using P = decltype(parametersTaken(make));
    return {name,
            title,
            reference,
            parametersOf<P>,
            [](const ParameterValues& values) { return wrap(make(withValues<P>(values))); },
            stochastic};
  }
}

constexpr std::array catalogue{
    row<&makeSerialPose, &mergingPoseGoals>("serial-pose", "Box-limited LM with raced restarts",
                                            "Chan and Lawrence 1988; this project"),
    row<&makeSerialPoseTable, &mergingPoseGoals>("serial-pose-table", "The same with a table of starts",
                                                 "this project"),
    row<&makePseudoInverse>("pseudo-inverse", "Pseudo-inverse Newton", "Lecture 10.1.4, n > m"),
    row<&makeJacobianTranspose>("jacobian-transpose", "Jacobian transpose", "Buss 2004"),
    row<&makeDampedLeastSquares>("dls", "Damped least squares", "Wampler 1986; Buss 2004"),
    row<&makeNakamura>("nakamura", "Damped by manipulability", "Nakamura, Hanafusa 1986"),
    row<&makeChiaverini>("chiaverini", "Numerical filtering", "Maciejewski, Klein 1988; Chiaverini 1997"),
    row<&makeSelectivelyDamped>("sdls", "Selectively damped least squares", "Buss, Kim 2005"),
    row<&makeLmChan>("lm-chan", "Levenberg-Marquardt, damping by the error", "Chan, Lawrence 1988"),
    row<&makeLmSugihara>("lm-sugihara", "Levenberg-Marquardt, robust damping", "Sugihara 2011"),
    row<&makeLmGainRatio>("lm-gain-ratio", "Levenberg-Marquardt, gain ratio", "Marquardt 1963; Nielsen 1999"),
    row<&makeExactHessian>("exact-hessian", "Newton with the exact Hessian", "Nocedal, Wright 2006, ch. 3"),
    row<&makeDrag>("drag", "Drag solver", "Exact Hessian and Gauss-Newton on the tree; Featherstone 2008"),
    row<&makeHalley>("halley", "Halley's method (QuIK)", "Lloyd, Irani, Ahmadi 2022"),
    row<&makeGeodesic>("geodesic", "Levenberg-Marquardt, geodesic acceleration", "Transtrum, Sethna 2012"),
    row<&makeBfgs>("bfgs", "BFGS, projected", "Zhao, Badler 1994"),
    row<&makeLbfgs>("l-bfgs", "L-BFGS, projected", "Nocedal 1980; Byrd, Lu, Nocedal, Zhu 1995"),
    row<&makeQpDifferential>("qp", "Quadratic program with limits", "Escande, Mansard, Wieber 2014"),
    row<&makeTaskPriority>("task-priority", "Task priority with null space", "Siciliano, Slotine 1991"),
#ifdef GELENK_HAS_CERES
    row<&makeCeresLm>("ceres-lm", "Ceres, Levenberg-Marquardt", "ceres-solver.org"),
    row<&makeCeresDogleg>("ceres-dogleg", "Ceres, dogleg", "ceres-solver.org; Powell 1970"),
    row<&makeCeresLineSearch>("ceres-line-search", "Ceres, L-BFGS line search", "ceres-solver.org"),
#endif
    row<&makeEvolution>("evolution", "Evolution with gradient polishing", "Ruppel et al. 2018 (bio_ik)",
                        true),
    row<&makeNewton1d>("newton-1d", "Newton, one dimension", "Lecture 10.1.4, one-dimensional Newton method"),
    row<&makeNewton>("newton", "Newton, full steps", "Lecture 10.1.4, n = m and n > m"),
    row<&makeNewtonDifferenceQuotient>("newton-quotient", "Newton, difference quotients",
                                       "Lecture 10.1.4, derivative"),
    row<&makeTwoLink>("two-link", "Two-link closed form", "Lecture 10.1.3, analytic solution"),
    row<&makeCcd>("ccd", "Cyclic coordinate descent", "Wang, Chen 1991"),
    row<&makeFabrik>("fabrik", "Forward and backward reaching", "Aristidou, Lasenby 2011"),
    row<&makeBallChain>("ball-chain", "LM for chains of balls, J never formed",
                        "Chan, Lawrence 1988; this project"),
    row<&makeClosedForm, &mergingPoseGoals>("closed-form", "Nearest of the complete set",
                                            "Pieper 1968; Raghavan, Roth 1990"),
#ifdef GELENK_HAS_KDL
    row<&makeKdlNewton, &mergingPoseGoals>("kdl-nr", "Orocos KDL: Newton-Raphson",
                                           "Orocos KDL, ChainIkSolverPos_NR"),
    row<&makeKdlNewtonWithLimits, &mergingPoseGoals>(
        "kdl-nr-jl", "Orocos KDL: Newton-Raphson with limits, damped", "Orocos KDL, ChainIkSolverPos_NR_JL"),
    row<&makeKdlLevenbergMarquardt, &mergingPoseGoals>("kdl-lma", "Orocos KDL: Levenberg-Marquardt",
                                                       "Orocos KDL, ChainIkSolverPos_LMA"),
#endif
};

/// Solvers that stand on a part which this build was made without, by the beginning of their names.
struct MissingPart {
  std::string_view prefix, library, option;
};
constexpr std::array missingParts{
#ifndef GELENK_HAS_CERES
    MissingPart{"ceres-", "Ceres Solver", "GELENK_CERES"},
#endif
#ifndef GELENK_HAS_KDL
    MissingPart{"kdl-", "Orocos KDL", "GELENK_PEERS"},
#endif
    MissingPart{},
};

constexpr SolverEntry fitting =
    row<&makeFitting>("default", "The solver that fits the problem", "serial-pose, else drag");

/// The table and, behind it, what the program added. Entries never move: spans and pointers stay good.
struct Entries {
  std::array<SolverEntry, catalogue.size() + mostOwnEntries> list;
  std::atomic<std::size_t> count = catalogue.size();
  Entries() { std::copy(catalogue.begin(), catalogue.end(), list.begin()); }
};
Entries& entries() {
  static Entries all;
  return all;
}

/// The name in front of a choice's brackets.
std::string_view nameOf(std::string_view text) { return text.substr(0, text.find('[')); }

double valueOf(std::string_view text, std::string_view word) {
  const auto value = parseNumber(word);
  if (!value)
    throw std::invalid_argument("'" + std::string(text) + "': expected a number, found '" +
                                std::string(word) + "'");
  return *value;
}

}  // namespace

std::string_view presentName(std::string_view name) {
  return name == "hybrid" ? "drag" : name == "spherical-wrist" ? "closed-form" : name;
}

std::span<const SolverEntry> solverCatalogue() { return {entries().list.data(), entries().count}; }

bool isBuiltIn(std::string_view name) {
  return std::any_of(catalogue.begin(), catalogue.end(),
                     [&](const SolverEntry& e) { return e.name == name; });
}

void putEntry(int slot, const SolverEntry& entry) {
  Entries& all = entries();
  all.list[catalogue.size() + slot] = entry;
  all.count = std::max<std::size_t>(all.count, catalogue.size() + slot + 1);
}

std::unique_ptr<IkSolver> SolverEntry::make(const ParameterValues& values) const {
  validate(name, parameters, values);
  return build(values);
}

const SolverEntry& solverEntry(std::string_view text) {
  const std::string_view name = presentName(nameOf(text));
  if (name == fitting.name) return fitting;
  std::string known;
  for (const SolverEntry& entry : solverCatalogue()) {
    if (entry.name == name) return entry;
    known += (known.empty() ? "" : ", ") + std::string(entry.name);
  }
  for (const MissingPart& part : missingParts)
    if (!part.prefix.empty() && name.starts_with(part.prefix))
      throw std::invalid_argument(
          "the solver '" + std::string(name) + "' needs " + std::string(part.library) +
          ", which this build was made without (CMake option " + std::string(part.option) + ")");
  throw std::invalid_argument("no solver is called '" + std::string(name) + "'; there are: " + known);
}

SolverSpec withParameter(SolverSpec choice, std::string_view parameter, double value) {
  const std::string name(parameter);
  validate(choice.entry->name, choice.entry->parameters, {{name, value}});
  const auto row = std::find_if(choice.entry->parameters.begin(), choice.entry->parameters.end(),
                                [&](const Parameter& p) { return p.name == parameter; });
  if (value == row->value)
    choice.values.erase(name);
  else
    choice.values[name] = value;
  return choice;
}

SolverSpec solverSpec(std::string_view text) {
  SolverSpec choice{.name = std::string(presentName(nameOf(text))), .entry = &solverEntry(text)};
  const std::size_t open = text.find('[');
  if (open == std::string_view::npos) return choice;
  if (text.back() != ']')
    throw std::invalid_argument("'" + std::string(text) + "': expected a solver such as dls[lambda=0.1]");
  std::string_view rest = text.substr(open + 1, text.size() - open - 2);
  while (true) {
    const std::string_view one = rest.substr(0, rest.find(','));
    const std::size_t equals = one.find('=');
    if (equals == std::string_view::npos)
      throw std::invalid_argument("'" + std::string(text) + "': expected parameter=value, found '" +
                                  std::string(one) + "'");
    choice = withParameter(choice, one.substr(0, equals), valueOf(text, one.substr(equals + 1)));
    if (one.size() == rest.size()) return choice;
    rest.remove_prefix(one.size() + 1);
  }
}

std::string toText(const SolverSpec& choice) {
  std::string inner;
  for (const Parameter& parameter : choice.entry->parameters)
    if (const auto found = choice.values.find(parameter.name); found != choice.values.end())
      inner += (inner.empty() ? "" : ",") + found->first + '=' + exactNumber(found->second);
  return choice.name + (inner.empty() ? "" : '[' + inner + ']');
}

ParameterSetting parameterSetting(std::string_view text) {
  const std::size_t equals = text.find('='), dot = text.substr(0, equals).find('.');
  if (equals == std::string_view::npos || dot == std::string_view::npos)
    throw std::invalid_argument("'" + std::string(text) +
                                "': expected SOLVER.PARAMETER=VALUE, such as dls.lambda=0.1");
  ParameterSetting setting{.entry = &solverEntry(text.substr(0, dot)),
                           .parameter = std::string(text.substr(dot + 1, equals - dot - 1)),
                           .value = valueOf(text, text.substr(equals + 1))};
  validate(setting.entry->name, setting.entry->parameters, {{setting.parameter, setting.value}});
  return setting;
}

std::unique_ptr<IkSolver> makeSolver(std::string_view text) {
  const SolverSpec choice = solverSpec(text);
  return choice.entry->make(choice.values);
}

std::unique_ptr<IkSolver> makeSolver(std::string_view name, const ParameterValues& values) {
  return solverEntry(name).make(values);
}

}  // namespace gelenk
