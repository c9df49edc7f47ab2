#include "apps/sandbox/solver_lessons.h"

#include <algorithm>
#include <iterator>

namespace gelenk {
namespace {

constexpr SolverLesson lessons[] = {
    {"serial-pose", "serial-pose", "(J^T J + D) dq = J^T r",
     "Levenberg and Marquardt's step within the joints' limits. Starts that do not get on are given up, "
     "others "
     "race in their place."},
    {"serial-pose-table", "serial-pose", "(J^T J + D) dq = J^T r",
     "The same method, started from the nearest places of a table of poses that is made once for the arm."},
    {"pseudo-inverse", "pseudo-inverse", "dq = J^T (J J^T)^-1 r",
     "Of all steps that meet the linearised goal the shortest. Near singular poses it becomes long: it is "
     "cut, "
     "and directions that are nearly lost are left out."},
    {"jacobian-transpose", "jacobian-transpose", "dq = a J^T r",
     "Down the slope of the squared error, as far as the linearised error falls: cheap, without an inverse, "
     "slow near the end."},
    {"dls", "dls", "dq = J^T (J J^T + lambda^2 I)^-1 r",
     "Damping keeps the step finite at singular poses, at the cost of slower convergence everywhere."},
    {"nakamura", "nakamura", "lambda^2 = lambda_0^2 (1 - w/w_0)^2, w < w_0",
     "Damped least squares whose damping comes in only where the manipulability w is small."},
    {"chiaverini", "chiaverini", "lambda_i^2 = lambda_max^2 (1 - (sigma_i/epsilon)^2)",
     "Only directions that are nearly lost, those with a singular value below epsilon, are damped."},
    {"sdls", "sdls", "|dq_i| <= gamma_i, dq_i = (u_i r/sigma_i) v_i",
     "Every direction of motion has a limit of its own: by how far the joints would move the goals for it."},
    {"lm-chan", "lm-chan", "(J^T J + lambda E I) dq = J^T r, E = |r|^2/2",
     "Damped by the squared error: calm far from the goal, fast near it."},
    {"lm-sugihara", "lm-sugihara", "(J^T J + (E + w) I) dq = J^T r",
     "Damped by the squared error E and a small bias w, so that the step exists at singular poses too."},
    {"lm-gain-ratio", "lm-gain-ratio", "(J^T J + mu I) dq = J^T r",
     "The damping falls while the cost falls as predicted, and grows after a step that fails."},
    {"exact-hessian", "exact-hessian", "(H + s I) dq = J^T r",
     "Newton's method with the true second derivatives H; the shift s keeps every step downhill. Fast also "
     "where the goal is out of reach."},
    {"drag", "drag", "min w |t - x|^2 + lambda |q - q_0|^2 + kappa |dq|^2",
     "True second derivatives on the tree, from frame to frame. A weak pull towards the rest pose settles "
     "what "
     "the goals leave open."},
    {"halley", "halley", "(A^T A + mu I) dq = A^T r, A = J + dJ/2",
     "Levenberg and Marquardt's step, taken again with the Jacobian of its middle: fewer iterations, each "
     "dearer."},
    {"geodesic", "geodesic", "dq = d_1 + d_2/2",
     "Levenberg and Marquardt's step and its acceleration: the way follows the bend of the valley."},
    {"bfgs", "bfgs", "dq = a B J^T r",
     "Learns the inverse curvature B from the slopes that it has met, with a search for the step's length "
     "a."},
    {"l-bfgs", "l-bfgs", "dq = a B J^T r",
     "BFGS that remembers the last few steps alone: little to store where there are many joints."},
    {"qp", "qp", "min |J dq - r|^2 + mu |dq|^2 within the limits",
     "Joint limits are constraints of every step, not a clamp after it."},
    {"task-priority", "task-priority", "dq = J_1^+ r_1 + (J_2 N_1)^+ (r_2 - J_2 J_1^+ r_1)",
     "Goals in levels: a lower one moves only what the higher ones leave free, their null space N."},
    {"ceres-lm", "ceres-lm", "min |r(q)|^2", "The library Ceres: Levenberg and Marquardt in a trust region."},
    {"ceres-dogleg", "ceres-dogleg", "min |r(q)|^2",
     "The library Ceres: from the steepest descent to Gauss and Newton's step, as far as the trust region "
     "reaches."},
    {"ceres-line-search", "ceres-line-search", "min |r(q)|^2",
     "The library Ceres: L-BFGS with a search along its direction."},
    {"evolution", "evolution", "min |r(q)|^2",
     "Poses are crossed and mutated, the best polished by a few Levenberg and Marquardt steps. Draws random "
     "numbers; finds solutions that lie far away."},
    {"newton-1d", "newton", "phi^(i+1) = phi^i - (f(phi^i) - X) / (f'(phi^i))",
     "The slide's method for one joint: the next angle is where the tangent meets X."},
    {"newton", "newton", "phi^(i+1) = phi^i - D_f^+ (f(phi^i) - X)",
     "The slide's method, full steps, nothing added: what the other methods improve on."},
    {"newton-quotient", "newton", "phi^(i+1) = phi^i - D_f^+ (f(phi^i) - X)",
     "The slide's method with a Jacobian by difference quotients, column by column."},
    {"two-link", "two-link", "cos phi_2 = (r^2 - l_1^2 - l_2^2) / (2 l_1 l_2)",
     "The slide's closed form for arms and legs of two links: both elbows, no iteration."},
    {"ccd", "ccd", "min |t - x(q_i)|^2",
     "One joint after the other, from the effector to the root, takes the value that alone is best."},
    {"fabrik", "fabrik", "|p_(i+1) - p_i| = l_i",
     "Points at fixed distances are pulled along the chain, back from the target and forward from the root."},
    {"ball-chain", "fabrik", "dq = J^T (J J^T + lambda I)^-1 r",
     "Damped least squares for chains of balls, whose J J^T follows from where the joints are: J is never "
     "formed."},
    {"closed-form", "closed-form", "f(q) = X",
     "Every solution from the arm's algebra; of those within the limits the one nearest to the start."},
    {"kdl-nr", "kdl", "dq = J^+ r",
     "The library Orocos KDL, for comparison: Newton's method, without limits."},
    {"kdl-nr-jl", "kdl", "dq = J^T (J J^T + lambda^2 I)^-1 r",
     "The library Orocos KDL, for comparison: damped steps, clamped to the limits."},
    {"kdl-lma", "kdl", "(J^T J + mu I) dq = J^T r",
     "The library Orocos KDL, for comparison: Levenberg and Marquardt."},
};

}  // namespace

const SolverLesson* solverLesson(std::string_view solver) {
  const auto found = std::ranges::find(lessons, solver, &SolverLesson::solver);
  return found == std::end(lessons) ? nullptr : &*found;
}

}  // namespace gelenk
