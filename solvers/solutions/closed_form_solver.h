#pragma once

#include <memory>

#include "solvers/problem/ik_solver.h"

namespace gelenk {

/// "closed-form": of the complete set of an arm of up to six revolute joints the solution within limits that
/// is nearest to the start (angles by whole turns included). One pose goal, or one position goal where the
/// arm has at most three joints. Without a solution within limits the answer is that of serial-pose, which is
/// the closest pose where there is none.
std::unique_ptr<IkSolver> makeClosedForm();

}  // namespace gelenk
