#pragma once

#include <ceres/solver.h>

namespace gelenk {

/// Levenberg-Marquardt on a small dense problem to rounding, without a word.
inline ceres::Solver::Options smallDenseOptions(int maxIterations) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = maxIterations;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-15;
  options.logging_type = ceres::SILENT;
  return options;
}

}  // namespace gelenk
