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
struct TripleSolutions {
  static constexpr int most = 16;
  int count = 0;
  double u[6][most];   ///< radians, [-pi, pi]; of every hinge a row
  double error[most];  ///< of the closed loop: lengths and radians
  /// Bit j: hinge j took any value because the others can make up for it (a family: axes in line); the value
  /// taken is the reference's.
  unsigned char free[most];
  bool alike = false;  ///< two of them may be the same: branches merge here

  Vector6d at(int k) const;
  void set(int k, const Vector6d& angles);
  void move(int from, int to);
};

/// The middle hinge of a triple, by a value that is known before it is: middle + size cos(u5 - phase), the
/// cosine between axes 4 and 6, or the square of the distance between them.
struct TripleBend {
  double middle = 0.0, size = 0.0, cos = 1.0, sin = 0.0;  ///< cosine and sine of the phase
  double alongGap = 0.0,
         againstGap = 0.0;  ///< spherical: by how much that cosine stays away from 1, from -1
};

/// A decomposed loop: what does not change with the goal. The branches are solved side by side, four of the
/// first three hinges and then both bends of the triple; the same turns close the loop, which is the error.
class TripleLoop {
 public:
  /// goalLink: the link that `solve` puts in (one of 0, 1, 2 and 5; links 3 and 4 lie within the triple).
  TripleLoop(LoopClass kind, const Loop& loop, int goalLink);

  void solve(const Eigen::Isometry3d& goal, const Vector6d& reference, TripleSolutions& out) const;
  const Loop& loop() const { return loop_; }

 private:
  template <class Make>
  void solveBehind(const Make& frontAt, const Eigen::Isometry3d& goal, const Vector6d& reference,
                   TripleSolutions& out) const;
  const Eigen::Isometry3d& link(int j, const Eigen::Isometry3d& goal) const {
    return j == goalLink_ ? goal : loop_.link[j];
  }

  LoopClass kind_;
  Loop loop_;
  int goalLink_;
  double before_ = 0.0, after_ = 0.0;  ///< spherical: where the axes meet, on axes 4 and 6
  TripleBend bend_;
};

}  // namespace gelenk
