#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace gelenk {

/// A symmetric matrix over the degrees of freedom of a forest, whose entry (i, j) can differ from zero only
/// where one of the two lies above the other. Its factors L^T D L fill nothing in (Featherstone, Rigid Body
/// Dynamics Algorithms, 6.5).
///
/// Degrees of freedom are numbered depth first, parents before children. Row k holds the entries (k, i) for
/// the ancestors i of k ordered from the root, entry `depth` by `depth`, and ends with the diagonal; it is
/// padded to whole blocks of four, so that every inner loop runs over contiguous memory without remainder.
/// What stands in the padding is finite and unused.
class TreeMatrix {
 public:
  /// parent[k] < k is the degree of freedom above k, -1 for none. Allocates only where the size outgrows all
  /// earlier ones.
  void setStructure(std::span<const int> parent);

  int size() const { return static_cast<int>(depth_.size()); }
  int depth(int k) const { return depth_[k]; }
  int parent(int k) const { return parent_[k]; }
  /// One past the last degree of freedom below k: the subtree of k is [k, subtreeEnd(k)).
  int subtreeEnd(int k) const { return subtreeEnd_[k]; }
  /// Doubles from one row's begin to the depth d, rounded up to the padding.
  static constexpr int padded(int length) { return (length + 3) & ~3; }

  double* row(int k) { return values_.data() + rowBegin_[k]; }
  const double* row(int k) const { return values_.data() + rowBegin_[k]; }
  double& diagonal(int k) { return values_[rowBegin_[k] + depth_[k]]; }
  double diagonal(int k) const { return values_[rowBegin_[k] + depth_[k]]; }

  /// Copies the values (not the structure, which must be the same).
  void copyValues(const TreeMatrix& other) { values_ = other.values_; }

  /// Replaces row and column k by those of the identity.
  void isolate(int k);
  /// y -= value * column k, except at k itself. y: size().
  void subtractColumn(int k, double value, double* y) const;
  /// (row k) . x with the whole symmetric row. x: size().
  double rowTimes(int k, const double* x) const;

  /// In place: the strict rows become L, the diagonal D. False, with the values spoilt, where a pivot is <=
  /// smallestPivot or not a number.
  bool factor(double smallestPivot);
  /// x <- (L^T D L)^-1 x after factor(). x: size().
  void solve(double* x) const;
  /// The first third of it for four columns at once: Y <- L^-T Y. Y: size() times four, the columns of a dof
  /// side by side.
  void solveUpper(double* Y) const;

 private:
  struct Run {  ///< ancestors of equal step: depths [depth, depth + length) are the degrees of freedom
                ///< [first, ...)
    int depth, first, length;
  };
  /// A chain of up to four degrees of freedom, each the only child of the one before, eliminated together.
  struct Group {
    int first, count;
    int runBegin, runEnd;  ///< runs of the ancestors above `first`
  };

  std::vector<int> parent_, depth_, subtreeEnd_, rowBegin_;
  std::vector<Run> runs_;
  std::vector<Group> groups_;
  std::vector<int> path_;
  std::vector<double> values_;
};

}  // namespace gelenk
