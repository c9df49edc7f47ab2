#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

namespace gelenk {

/// Nearest neighbour among fixed points of any dimension. Equal distances give the smaller index.
template <int dimension>
class KdTree {
 public:
  using Point = Eigen::Matrix<double, dimension, 1>;

  explicit KdTree(std::vector<Point> points) : points_(std::move(points)) {
    order_.resize(points_.size());
    std::iota(order_.begin(), order_.end(), 0);
    nodes_.reserve(2 * points_.size() / leafSize + 2);
    if (!points_.empty()) build(0, static_cast<int>(points_.size()));
  }

  bool empty() const { return points_.empty(); }

  /// Index of the nearest point, -1 where there is none within sqrt(bound).
  int nearest(const Point& p, double bound = std::numeric_limits<double>::infinity()) const {
    int best = -1;
    if (!nodes_.empty()) search(0, p, bound, best);
    return best;
  }

 private:
  static constexpr int leafSize = 8;
  struct Node {
    int begin, end;  ///< of order_; a leaf where right == 0
    int right = 0;   ///< the left child follows its parent
    int axis = 0;
    double split = 0.0;
  };

  int build(int begin, int end) {
    const int index = static_cast<int>(nodes_.size());
    nodes_.push_back({.begin = begin, .end = end});
    if (end - begin <= leafSize) return index;
    Point low = points_[order_[begin]], high = low;
    for (int i = begin; i < end; ++i) {
      low = low.cwiseMin(points_[order_[i]]);
      high = high.cwiseMax(points_[order_[i]]);
    }
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const int middle = (begin + end) / 2;
    std::nth_element(
        order_.begin() + begin, order_.begin() + middle, order_.begin() + end, [&](int a, int b) {
          return points_[a][axis] != points_[b][axis] ? points_[a][axis] < points_[b][axis] : a < b;
        });
    nodes_[index].axis = axis;
    nodes_[index].split = points_[order_[middle]][axis];
    build(begin, middle);
    nodes_[index].right = build(middle, end);
    return index;
  }

  void search(int at, const Point& p, double& bound, int& best) const {
    const Node& node = nodes_[at];
    if (node.right == 0) {
      for (int i = node.begin; i < node.end; ++i) {
        const double d = (points_[order_[i]] - p).squaredNorm();
        if (d < bound || (d == bound && order_[i] < best)) bound = d, best = order_[i];
      }
      return;
    }
    const double side = p[node.axis] - node.split;
    search(side < 0.0 ? at + 1 : node.right, p, bound, best);
    if (side * side <= bound) search(side < 0.0 ? node.right : at + 1, p, bound, best);
  }

  std::vector<Point> points_;
  std::vector<int> order_;
  std::vector<Node> nodes_;
};

}  // namespace gelenk
