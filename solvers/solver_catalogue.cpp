#include <array>
#include <stdexcept>

#include "solvers/methods/ball_chain.h"
#include "solvers/methods/ccd.h"
#include "solvers/methods/ceres_solver.h"
#include "solvers/methods/evolution.h"
#include "solvers/methods/fabrik.h"
#include "solvers/methods/newton.h"
#include "solvers/methods/qp.h"
#include "solvers/methods/quasi_newton.h"
#include "solvers/methods/step_rules.h"
#include "solvers/methods/task_priority.h"
#include "solvers/methods/two_link.h"
#include "solvers/peers/kdl_peer.h"
#include "solvers/problem/ik_solver.h"
#include "solvers/serial/pose_goals.h"
#include "solvers/serial/serial_pose.h"
#include "solvers/serial/spherical_wrist.h"
#include "solvers/tree/drag_solver.h"

namespace gelenk {
namespace {

constexpr std::array catalogue{
    SolverEntry{"serial-pose", "Box-limited LM with raced restarts", "Chan and Lawrence 1988; this project",
                &mergingPoseGoals<&makeSerialPose>},
    SolverEntry{"serial-pose-table", "The same with a table of starts", "this project",
                &mergingPoseGoals<&makeSerialPoseTable>},
    SolverEntry{"pseudo-inverse", "Pseudo-inverse Newton", "Lecture 10.1.4, n > m", &makePseudoInverse},
    SolverEntry{"jacobian-transpose", "Jacobian transpose", "Buss 2004", &makeJacobianTranspose},
    SolverEntry{"dls", "Damped least squares", "Wampler 1986; Buss 2004", &makeDampedLeastSquares},
    SolverEntry{"nakamura", "Damped by manipulability", "Nakamura, Hanafusa 1986", &makeNakamura},
    SolverEntry{"chiaverini", "Numerical filtering", "Maciejewski, Klein 1988; Chiaverini 1997",
                &makeChiaverini},
    SolverEntry{"sdls", "Selectively damped least squares", "Buss, Kim 2005", &makeSelectivelyDamped},
    SolverEntry{"lm-chan", "Levenberg-Marquardt, damping by the error", "Chan, Lawrence 1988", &makeLmChan},
    SolverEntry{"lm-sugihara", "Levenberg-Marquardt, robust damping", "Sugihara 2011", &makeLmSugihara},
    SolverEntry{"lm-gain-ratio", "Levenberg-Marquardt, gain ratio", "Marquardt 1963; Nielsen 1999",
                &makeLmGainRatio},
    SolverEntry{"exact-hessian", "Newton with the exact Hessian", "Nocedal, Wright 2006, ch. 3",
                &makeExactHessian},
    SolverEntry{"drag", "Exact Hessian and Gauss-Newton on the tree", "this project; Featherstone 2008",
                &makeDrag},
    SolverEntry{"halley", "Halley's method (QuIK)", "Lloyd, Irani, Ahmadi 2022", &makeHalley},
    SolverEntry{"geodesic", "Levenberg-Marquardt, geodesic acceleration", "Transtrum, Sethna 2012",
                &makeGeodesic},
    SolverEntry{"bfgs", "BFGS, projected", "Zhao, Badler 1994", &makeBfgs},
    SolverEntry{"l-bfgs", "L-BFGS, projected", "Nocedal 1980; Byrd, Lu, Nocedal, Zhu 1995", &makeLbfgs},
    SolverEntry{"qp", "Quadratic program with limits", "Escande, Mansard, Wieber 2014", &makeQpDifferential},
    SolverEntry{"task-priority", "Task priority with null space", "Siciliano, Slotine 1991",
                &makeTaskPriority},
    SolverEntry{"ceres-lm", "Ceres, Levenberg-Marquardt", "ceres-solver.org", &makeCeresLm},
    SolverEntry{"ceres-dogleg", "Ceres, dogleg", "ceres-solver.org; Powell 1970", &makeCeresDogleg},
    SolverEntry{"ceres-line-search", "Ceres, L-BFGS line search", "ceres-solver.org", &makeCeresLineSearch},
    SolverEntry{"evolution", "Evolution with gradient polishing", "Ruppel et al. 2018 (bio_ik)",
                &makeEvolution, true},
    SolverEntry{"newton-1d", "Newton, one dimension", "Lecture 10.1.4, one-dimensional Newton method",
                &makeNewton1d},
    SolverEntry{"newton", "Newton, full steps", "Lecture 10.1.4, n = m and n > m", &makeNewton},
    SolverEntry{"newton-quotient", "Newton, difference quotients", "Lecture 10.1.4, derivative",
                &makeNewtonDifferenceQuotient},
    SolverEntry{"two-link", "Two-link closed form", "Lecture 10.1.3, analytic solution", &makeTwoLink},
    SolverEntry{"ccd", "Cyclic coordinate descent", "Wang, Chen 1991", &makeCcd},
    SolverEntry{"fabrik", "Forward and backward reaching", "Aristidou, Lasenby 2011", &makeFabrik},
    SolverEntry{"ball-chain", "LM for chains of balls, J never formed", "Chan, Lawrence 1988; this project",
                &makeBallChain},
    SolverEntry{"spherical-wrist", "Closed form of six-joint arms", "Pieper 1968; Hawkins 2013",
                &mergingPoseGoals<&makeSphericalWrist>},
#ifdef GELENK_HAS_KDL
    SolverEntry{"kdl-nr", "Orocos KDL: Newton-Raphson", "Orocos KDL, ChainIkSolverPos_NR",
                &mergingPoseGoals<&makeKdlNewton>},
    SolverEntry{"kdl-nr-jl", "Orocos KDL: Newton-Raphson with limits, damped",
                "Orocos KDL, ChainIkSolverPos_NR_JL", &mergingPoseGoals<&makeKdlNewtonWithLimits>},
    SolverEntry{"kdl-lma", "Orocos KDL: Levenberg-Marquardt", "Orocos KDL, ChainIkSolverPos_LMA",
                &mergingPoseGoals<&makeKdlLevenbergMarquardt>},
#endif
};

}  // namespace

std::string_view presentName(std::string_view name) { return name == "hybrid" ? "drag" : name; }

std::span<const SolverEntry> solverCatalogue() { return catalogue; }

std::unique_ptr<IkSolver> makeSolver(std::string_view name) { return solverEntry(name).make(); }

const SolverEntry& solverEntry(std::string_view name) {
  if (name == "default") name = catalogue.front().name;
  name = presentName(name);
  std::string known;
  for (const SolverEntry& entry : catalogue) {
    if (entry.name == name) return entry;
    known += (known.empty() ? "" : ", ") + std::string(entry.name);
  }
  throw std::invalid_argument("no solver is called '" + std::string(name) + "'; there are: " + known);
}

}  // namespace gelenk
