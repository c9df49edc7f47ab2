#pragma once

#include <Eigen/Core>
#include <vector>

namespace gelenk {

/// Why a solver stopped. That it stopped and that the goal is reached are different facts: judge.h decides
/// the second.
enum class Stop {
  Converged,    ///< every goal within its tolerance and all limits kept, by the solver's own evaluation
  Stationary,   ///< no descent direction is left and the cost rises or stays in all: the best point near the
                ///< start of a goal that is not met
  Saddle,       ///< no slope is left, but the cost curves downwards somewhere and no way there was found
  Stalled,      ///< steps or progress too small without being stationary
  Budget,       ///< iterations or time spent
  Failure,      ///< a numerical breakdown; q is the last good configuration
  Unsupported,  ///< this solver does not do such problems; q is the start
};
const char* toString(Stop stop);

/// Work done, counted by the evaluator and the solver.
struct Counters {
  int iterations = 0;
  int forwardKinematics = 0;
  int jacobians = 0;
  int hessians = 0;
  int factorisations = 0;
  int restarts = 0;

  Counters& operator+=(const Counters& other) {
    iterations += other.iterations;
    forwardKinematics += other.forwardKinematics;
    jacobians += other.jacobians;
    hessians += other.hessians;
    factorisations += other.factorisations;
    restarts += other.restarts;
    return *this;
  }
};

struct IterationRecord {
  Eigen::VectorXd q;
  double residual = 0.0;  ///< weighted root of the summed squares before the step, metres and radians alike;
                          ///< the last record of an attempt describes where it ended and has no step
  double stepNorm = 0.0;  ///< |dq|
  double damping = 0.0;   ///< lambda or mu where the method has one
  double seconds = 0.0;   ///< since the solve began
};

enum class TraceLevel { Off, Residuals, Full };  ///< Full keeps q of every iteration

struct Budget {
  int maxIterations = 200;  ///< of one attempt; every restart has as many again
  double maxSeconds =
      1.0;           ///< of the whole solve; answers are the same from run to run as long as it does not bind
  int restarts = 0;  ///< random restarts allowed beyond the first attempt
  unsigned long long seed = 1;  ///< of the restarts and of stochastic solvers
};

struct IkReport {
  Eigen::VectorXd q;
  Stop why = Stop::Failure;
  double residual = 0.0;  ///< at q, as the solver sees it
  Counters counters;
  double seconds = 0.0;
  std::vector<IterationRecord> trace;
};

}  // namespace gelenk
