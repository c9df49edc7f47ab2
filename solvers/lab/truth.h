#pragma once

#include <map>
#include <memory>
#include <string>

#include "solvers/problem/ik_problem.h"

namespace gelenk {

/// What is known of all solutions of a problem.
struct Truth {
  std::string solutions;  ///< how many there are within the limits, images by whole turns apart; "family"
                          ///< where they are curves; empty where it is not known
  double nearest;  ///< |difference(start, nearest solution)|; NaN where there is none or it is not known
};

/// Knows the complete sets (solvers/solutions) of problems with one goal, the pose or place of an arm's end:
/// finite ones, and the nearest member of the families of seven joints. What is prepared for a skeleton and a
/// goal's joint is kept as long as this object; the skeletons must live as long.
class TruthFinder {
 public:
  TruthFinder();
  ~TruthFinder();
  Truth of(const IkProblem& problem);

 private:
  struct Arm;
  std::map<std::pair<const Skeleton*, int>, std::unique_ptr<Arm>> arms_;
};

}  // namespace gelenk
