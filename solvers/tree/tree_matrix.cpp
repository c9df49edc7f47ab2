#include "solvers/tree/tree_matrix.h"

#include <algorithm>

#include "solvers/serial/simd.h"

namespace gelenk {
namespace {

/// row_i[0 .. length) -= sum_g a[g] * rows[g][0 .. length); length is a multiple of four.
template <int count>
GELENK_INLINE void subtractRows(double* __restrict row, const double* const* rows, const double* a,
                                int length) {
  for (int j = 0; j < length; j += 4) {
    Double4 sum = four(row + j);
    for (int g = 0; g < count; ++g) sum -= a[g] * four(rows[g] + j);
    four(row + j) = sum;
  }
}

}  // namespace

void TreeMatrix::setStructure(std::span<const int> parent) {
  const int n = static_cast<int>(parent.size());
  parent_.assign(parent.begin(), parent.end());
  depth_.resize(n);
  subtreeEnd_.resize(n);
  rowBegin_.resize(n);
  int total = 0;
  for (int k = 0; k < n; ++k) {
    depth_[k] = parent[k] < 0 ? 0 : depth_[parent[k]] + 1;
    subtreeEnd_[k] = k + 1;
    rowBegin_[k] = total;
    total += padded(depth_[k] + 1);
  }
  for (int k = n - 1; k > 0; --k)
    if (parent[k] >= 0) subtreeEnd_[parent[k]] = std::max(subtreeEnd_[parent[k]], subtreeEnd_[k]);
  values_.assign(total, 0.0);

  groups_.clear();
  runs_.clear();
  for (int k = 0; k < n;) {
    Group group{.first = k, .count = 1, .runBegin = static_cast<int>(runs_.size()), .runEnd = 0};
    // The next degree of freedom joins the chain where it is the only child: everything below k is below k
    // + 1.
    while (group.count < 4 && k + group.count < n && parent[k + group.count] == k + group.count - 1 &&
           subtreeEnd_[k + group.count] == subtreeEnd_[k])
      ++group.count;
    path_.clear();
    for (int a = parent[k]; a >= 0; a = parent[a]) path_.push_back(a);
    std::reverse(path_.begin(), path_.end());
    for (int d = 0; d < static_cast<int>(path_.size()); ++d) {
      if (d > 0 && path_[d] == path_[d - 1] + 1)
        ++runs_.back().length;
      else
        runs_.push_back({.depth = d, .first = path_[d], .length = 1});
    }
    group.runEnd = static_cast<int>(runs_.size());
    groups_.push_back(group);
    k += group.count;
  }
}

void TreeMatrix::isolate(int k) {
  std::fill_n(row(k), depth_[k], 0.0);
  diagonal(k) = 1.0;
  for (int below = k + 1; below < subtreeEnd_[k]; ++below) row(below)[depth_[k]] = 0.0;
}

void TreeMatrix::subtractColumn(int k, double value, double* y) const {
  const double* entries = row(k);
  int d = depth_[k];
  for (int a = parent_[k]; a >= 0; a = parent_[a]) y[a] -= value * entries[--d];
  for (int below = k + 1; below < subtreeEnd_[k]; ++below) y[below] -= value * row(below)[depth_[k]];
}

double TreeMatrix::rowTimes(int k, const double* x) const {
  const double* entries = row(k);
  double sum = entries[depth_[k]] * x[k];
  int d = depth_[k];
  for (int a = parent_[k]; a >= 0; a = parent_[a]) sum += entries[--d] * x[a];
  for (int below = k + 1; below < subtreeEnd_[k]; ++below) sum += row(below)[depth_[k]] * x[below];
  return sum;
}

GELENK_SIMD_CLONES
bool TreeMatrix::factor(double smallestPivot) {
  for (int at = static_cast<int>(groups_.size()) - 1; at >= 0; --at) {
    const Group& group = groups_[at];
    const int depth = depth_[group.first];
    double* rows[4];
    double inverse[4];
    for (int g = 0; g < group.count; ++g) rows[g] = row(group.first + g);

    // Within the chain, from its lower end: the update reaches the chain's own rows over their whole length.
    for (int g = group.count - 1; g >= 0; --g) {
      const double pivot = rows[g][depth + g];
      if (!(pivot > smallestPivot)) return false;
      inverse[g] = 1.0 / pivot;
      for (int above = g - 1; above >= 0; --above) {
        const double a = rows[g][depth + above] * inverse[g];
        subtractRows<1>(rows[above], rows + g, &a, padded(depth + above + 1));
      }
    }
    // All ancestors at once.
    for (int r = group.runBegin; r < group.runEnd; ++r) {
      const Run& run = runs_[r];
      for (int i = 0; i < run.length; ++i) {
        const int d = run.depth + i;
        double* target = row(run.first + i);
        double a[4];
        for (int g = 0; g < group.count; ++g) a[g] = rows[g][d] * inverse[g];
        switch (group.count) {
          case 1: subtractRows<1>(target, rows, a, padded(d + 1)); break;
          case 2: subtractRows<2>(target, rows, a, padded(d + 1)); break;
          case 3: subtractRows<3>(target, rows, a, padded(d + 1)); break;
          default: subtractRows<4>(target, rows, a, padded(d + 1)); break;
        }
      }
    }
    for (int g = 0; g < group.count; ++g) {
      const double pivot = rows[g][depth + g];
      for (int j = 0; j < padded(depth + g); j += 4) four(rows[g] + j) *= inverse[g];
      rows[g][depth + g] = pivot;
    }
  }
  return true;
}

GELENK_SIMD_CLONES
void TreeMatrix::solve(double* x) const {
  for (int at = static_cast<int>(groups_.size()) - 1; at >= 0; --at) {  // L^T y = x, leaves first
    const Group& group = groups_[at];
    for (int g = group.count - 1; g >= 0; --g) {
      const int k = group.first + g;
      const double* entries = row(k);
      const double value = x[k];
      for (int r = group.runBegin; r < group.runEnd; ++r) {
        const Run run = runs_[r];
        for (int i = 0; i < run.length; ++i) x[run.first + i] -= entries[run.depth + i] * value;
      }
      for (int above = 0; above < g; ++above)
        x[group.first + above] -= entries[depth_[group.first] + above] * value;
    }
  }
  for (int k = 0; k < size(); ++k) x[k] /= diagonal(k);
  for (const Group& group : groups_)  // L z = y, root first
    for (int g = 0; g < group.count; ++g) {
      const int k = group.first + g;
      const double* entries = row(k);
      double sum0 = 0.0, sum1 = 0.0;
      for (int r = group.runBegin; r < group.runEnd; ++r) {
        const Run run = runs_[r];
        int i = 0;
        for (; i + 1 < run.length; i += 2) {
          sum0 += entries[run.depth + i] * x[run.first + i];
          sum1 += entries[run.depth + i + 1] * x[run.first + i + 1];
        }
        if (i < run.length) sum0 += entries[run.depth + i] * x[run.first + i];
      }
      for (int above = 0; above < g; ++above)
        sum0 += entries[depth_[group.first] + above] * x[group.first + above];
      x[k] -= sum0 + sum1;
    }
}

GELENK_SIMD_CLONES
void TreeMatrix::solveUpper(double* Y) const {
  for (int at = static_cast<int>(groups_.size()) - 1; at >= 0; --at) {  // leaves first
    const Group& group = groups_[at];
    for (int g = group.count - 1; g >= 0; --g) {
      const int k = group.first + g;
      const double* entries = row(k);
      const Double4 value = four(Y + 4 * k);
      for (int r = group.runBegin; r < group.runEnd; ++r) {
        const Run run = runs_[r];
        for (int i = 0; i < run.length; ++i) four(Y + 4 * (run.first + i)) -= entries[run.depth + i] * value;
      }
      for (int above = 0; above < g; ++above)
        four(Y + 4 * (group.first + above)) -= entries[depth_[group.first] + above] * value;
    }
  }
}

}  // namespace gelenk
