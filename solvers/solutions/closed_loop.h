#pragma once

#include "solvers/solutions/general_loop.h"

namespace gelenk {

/// Loops that fall apart: three neighbouring hinges whose axes meet in a point, or are parallel. Both leave
/// two equations that are linear in the cosine and sine of one angle with coefficients linear in those of
/// another, and a polynomial of trigonometric degree two (1 where two more axes meet or are parallel).
enum class LoopClass {
  General,
  SphericalTriple,  ///< the axes of three neighbouring joints meet in a point (Pieper 1968)
  ParallelTriple,   ///< the axes of three neighbouring joints are parallel (UR arms)
};

struct Decomposition {
  LoopClass kind = LoopClass::General;
  Cut cut;               ///< puts the three last
  int firstOfThree = 0;  ///< joint of the arm
  double misfit = 0.0;   ///< by how much the axes miss (lengths of the loop, sine of an angle)
};

/// Looks at the fixed links 0 to 4 only (5 is the goal's). Spherical wins over parallel; among several places
/// the one where more of the rest simplifies. tolerance: see misfit.
Decomposition decompose(const Loop& loop, double tolerance);

/// Solutions, at most eight, of a loop cut so that its last three hinges are the triple. Not polished.
/// `free`: bit j set where hinge j took any value because the others can make up for it (a family: axes in
/// line); the value taken is reference[j].
struct TripleSolutions {
  static constexpr int most = 16;
  int count = 0;
  std::array<Vector6d, most> u;
  std::array<unsigned char, most> free{};
};
void solveSphericalTriple(const Loop& loop, const Vector6d& reference, TripleSolutions& solutions);
void solveParallelTriple(const Loop& loop, const Vector6d& reference, TripleSolutions& solutions);

}  // namespace gelenk
