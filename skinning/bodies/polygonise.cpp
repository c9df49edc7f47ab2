#include "skinning/bodies/polygonise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <thread>

namespace gelenk {

using Eigen::Vector3d;
using Eigen::Vector3i;

namespace {

#ifdef __EMSCRIPTEN__
constexpr int mostThreads = 1;  // a page has none beside its own
#else
constexpr int mostThreads = 64;
#endif

/// body(k) for k in [0, count), shared out in equal runs. Each k must write to its own place only.
template <typename Body>
void parallelFor(int count, int threads, const Body& body) {
  std::vector<std::thread> workers;
  const int runs = std::clamp(threads, 1, std::max(1, std::min(mostThreads, count)));
  const auto run = [&](int r) {
    for (int k = r; k < count; k += runs) body(k);
  };
  for (int r = 1; r < runs; ++r) workers.emplace_back(run, r);
  run(0);
  for (std::thread& worker : workers) worker.join();
}

// ----------------------------------------------------------------------------------------------------
// Warp

Vector3d pull(const Vector3d& q, const Vector3d& centre, double strength, double reach) {
  const Vector3d d = q - centre;
  const double r = d.norm();
  if (r < 1e-6 * reach) return strength * d;
  const double e = r < 20.0 * reach ? std::exp(-2.0 * r / reach) : 0.0;  // tanh = (1 - e) / (1 + e)
  const double ratio = reach * (1.0 - e) / ((1.0 + e) * r);
  return strength * ratio * d;
}

class Warp {
 public:
  explicit Warp(const std::vector<GridLens>& lenses) {
    for (auto lens = lenses.rbegin(); lens != lenses.rend();
         ++lens) {  // the last one's output is the body's space
      Stage stage{{}, 1.0 - 1.0 / lens->magnification, lens->reach};
      std::vector<Vector3d> wanted;
      for (const Vector3d& c : lens->centres) wanted.push_back(back(c));
      stage.centres = wanted;
      for (int i = 0; i < 60; ++i) {  // centres that lie where they should after the pull of the others
        std::vector<Vector3d> moved = wanted;
        for (std::size_t a = 0; a < moved.size(); ++a)
          for (std::size_t b = 0; b < moved.size(); ++b)
            if (a != b) moved[a] += pull(stage.centres[a], stage.centres[b], stage.strength, stage.reach);
        stage.centres = moved;
      }
      stages_.insert(stages_.begin(), stage);
    }
  }

  Vector3d operator()(Vector3d q) const {
    for (const Stage& stage : stages_) {
      Vector3d sum = Vector3d::Zero();
      for (const Vector3d& c : stage.centres) sum += pull(q, c, stage.strength, stage.reach);
      q -= sum;
    }
    return q;
  }

  /// A box that holds every q with W(q) in the given box. Stage for stage q_d = p_d + sum kappa L tanh(r / L)
  /// / r (q - c)_d, and tanh(r) / r falls with r >= |(q - c)_d|: so q_d <= t implies q_d <= max p_d + sum
  /// kappa L tanh(max(t - c_d, 0) / L). Begun with the largest pull there can be, each round tightens a true
  /// bound.
  Eigen::AlignedBox3d preimage(Eigen::AlignedBox3d box) const {
    for (auto stage = stages_.rbegin(); stage != stages_.rend(); ++stage)
      for (int d = 0; d < 3; ++d)
        for (const double sign : {-1.0, 1.0}) {
          double& face = sign < 0.0 ? box.min()[d] : box.max()[d];
          const double from = sign * face, farthest = std::abs(stage->strength) * stage->reach;
          double bound = from + farthest * static_cast<double>(stage->centres.size());
          for (int i = 0; i < 30 && stage->strength > 0.0; ++i) {
            double pulls = 0.0;
            for (const Vector3d& c : stage->centres)
              pulls += farthest * std::tanh(std::max(bound - sign * c[d], 0.0) / stage->reach);
            bound = from + pulls;
          }
          face = sign * bound;
        }
    return box;
  }

  /// q with W(q) = p, by fixed-point iteration.
  Vector3d back(Vector3d p) const {
    for (auto stage = stages_.rbegin(); stage != stages_.rend(); ++stage) {
      Vector3d q = p;
      for (int i = 0; i < 100; ++i) {
        Vector3d sum = Vector3d::Zero();
        for (const Vector3d& c : stage->centres) sum += pull(q, c, stage->strength, stage->reach);
        const Vector3d before = q;
        q = p + sum;
        if (q == before) break;
      }
      p = q;
    }
    return p;
  }

 private:
  struct Stage {
    std::vector<Vector3d> centres;
    double strength, reach;
  };
  std::vector<Stage> stages_;
};

// ----------------------------------------------------------------------------------------------------
// Cells and loops

Vector3i corner(int c) { return {c & 1, c >> 1 & 1, c >> 2 & 1}; }

/// Corners of the edges: edge 4 d + k runs along axis d from its k-th low corner.
constexpr std::array<std::array<int, 2>, 12> cellEdges = {
    {{0, 1}, {2, 3}, {4, 5}, {6, 7}, {0, 2}, {1, 3}, {4, 6}, {5, 7}, {0, 4}, {1, 5}, {2, 6}, {3, 7}}};

/// For each pattern of inside corners: to which loop each crossed edge belongs (-1: not crossed), and how
/// many loops there are.
struct LoopTable {
  std::array<std::array<std::int8_t, 12>, 256> loop;
  std::array<std::int8_t, 256> count;
};

int edgeBetween(int a, int b) {
  for (int e = 0; e < 12; ++e)
    if ((cellEdges[e][0] == a && cellEdges[e][1] == b) || (cellEdges[e][0] == b && cellEdges[e][1] == a))
      return e;
  return -1;
}

LoopTable makeLoopTable() {
  constexpr std::array<std::array<int, 4>, 6> faces = {
      {{0, 2, 6, 4}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 5, 7, 6}}};
  LoopTable table{};
  for (int pattern = 0; pattern < 256; ++pattern) {
    const auto inside = [&](int corner) { return (pattern >> corner & 1) != 0; };
    std::array<std::vector<int>, 12> joined;  // crossed edges that share a face and are connected across it
    const auto join = [&](int e, int f) { joined[e].push_back(f), joined[f].push_back(e); };
    for (const auto& face : faces) {
      std::vector<int> crossed;
      for (int k = 0; k < 4; ++k)
        if (inside(face[k]) != inside(face[(k + 1) % 4]))
          crossed.push_back(edgeBetween(face[k], face[(k + 1) % 4]));
      if (crossed.size() == 2) join(crossed[0], crossed[1]);
      if (crossed.size() == 4)  // two inside corners at a diagonal: cut each off
        for (int k = 0; k < 4; ++k)
          if (inside(face[k]))
            join(edgeBetween(face[(k + 3) % 4], face[k]), edgeBetween(face[k], face[(k + 1) % 4]));
    }
    table.loop[pattern].fill(-1);
    for (int e = 0; e < 12; ++e) {
      if (joined[e].empty() || table.loop[pattern][e] >= 0) continue;
      std::vector<int> open{e};
      while (!open.empty()) {
        const int at = open.back();
        open.pop_back();
        if (table.loop[pattern][at] >= 0) continue;
        table.loop[pattern][at] = table.count[pattern];
        open.insert(open.end(), joined[at].begin(), joined[at].end());
      }
      ++table.count[pattern];
    }
  }
  return table;
}

// ----------------------------------------------------------------------------------------------------
// Grid

constexpr int side = 8;  // samples of a block along each axis
constexpr int volume = side * side * side;

struct Block {
  bool active = false;
  bool inside = false;  ///< sign of an inactive one
  BodyShape::Region region;
  std::vector<double> values;    ///< volume of them where active
  std::vector<int> firstVertex;  ///< of the cell whose low corner is the sample
};

/// Samples of F on the warped grid. In the symmetric case sample x = 8 lies half a cell right of the plane of
/// symmetry and the block layer x = 0 is the image of layer 1.
class Grid {
 public:
  Grid(const BodyShape& shape, const PolygoniseOptions& options)
      : shape_(shape), options_(options), warp_(options.lenses) {
    if (!(options.cell > 0.0)) throw std::invalid_argument("the cell of a grid must be positive");
    Eigen::AlignedBox3d box = firstBox(shape.bounds());
    do {  // where parts blend the surface bulges out of the box of the parts
      layOut(box);
      fill();
      activateMixedCells();
      box.min().array() -= side * options.cell;
      box.max().array() += side * options.cell;
    } while (surfaceReachesTheRim());
  }

  const Warp& warp() const { return warp_; }
  int blockCount() const { return static_cast<int>(block_.size()); }
  const Block& block(int b) const { return block_[b]; }
  Block& block(int b) { return block_[b]; }
  int firstLayer() const { return options_.symmetric ? 1 : 0; }

  Vector3i firstSample(int b) const {
    return side * Vector3i(b % blocks_.x(), b / blocks_.x() % blocks_.y(), b / (blocks_.x() * blocks_.y()));
  }
  Vector3i sampleOf(int b, int k) const {
    return firstSample(b) + Vector3i(k % side, k / side % side, k / (side * side));
  }
  /// Block of a sample, or -1 outside the grid.
  int blockOf(const Vector3i& s) const {
    if ((s.array() < 0).any() || (s.array() >= side * blocks_.array()).any()) return -1;
    return s.x() / side + blocks_.x() * (s.y() / side + blocks_.y() * (s.z() / side));
  }
  static int offset(const Vector3i& s) {
    return s.x() % side + side * (s.y() % side + side * (s.z() % side));
  }
  double value(const Vector3i& s) const {
    const int b = blockOf(s);
    if (b < 0) return 1e9;
    return block_[b].active ? block_[b].values[offset(s)] : block_[b].inside ? -1e9 : 1e9;
  }
  Vector3d point(const Vector3d& sample) const { return origin_ + options_.cell * sample; }

 private:
  /// Begins at the preimage of points on the box's faces and grows by whole blocks to what is proven to hold
  /// the preimage of all of it: so a surface that the first one holds keeps its vertices.
  Eigen::AlignedBox3d firstBox(const Eigen::AlignedBox3d& body) const {
    Eigen::AlignedBox3d box;
    constexpr int steps = 6;
    for (int i = 0; i <= steps; ++i)
      for (int j = 0; j <= steps; ++j)
        for (int k = 0; k <= steps; ++k) {
          if (i % steps && j % steps && k % steps) continue;
          const Vector3d t = Vector3d(i, j, k) / steps;
          box.extend(warp_.back(body.min() + t.cwiseProduct(body.sizes())));
        }
    const Eigen::AlignedBox3d proven = warp_.preimage(body);
    const double block = side * options_.cell;
    const auto blocks = [&](double length) { return std::max(0.0, std::ceil(length / block)); };
    for (int d = 0; d < 3; ++d) {
      box.min()[d] -= block * blocks(box.min()[d] - proven.min()[d]);
      box.max()[d] += block * blocks(proven.max()[d] - box.max()[d]);
    }
    return box;
  }

  void layOut(const Eigen::AlignedBox3d& box) {
    const double h = options_.cell;
    origin_ = box.min().array() - 2.0 * h;
    const Vector3d size = box.sizes().array() + 4.0 * h;
    double cells = 1.0;
    for (int d = 0; d < 3; ++d) {
      cells *= std::ceil(size[d] / (side * h)) * side;
      if (!(cells <= 0x1p28)) throw std::invalid_argument("the grid has too many cells: take larger ones");
      blocks_[d] = std::max(1, static_cast<int>(std::ceil(size[d] / (side * h))));
    }
    if (options_.symmetric) {
      blocks_.x() = 1 + std::max(1, static_cast<int>(std::ceil((box.max().x() + 2.0 * h) / (side * h))));
      origin_.x() = (0.5 - side) * h;
    }
    block_.assign(static_cast<std::size_t>(blocks_.prod()), Block{});
  }

  void fill() {
    const double radius = 0.5 * std::sqrt(3.0) * side * options_.cell;
    parallelFor(blockCount(), options_.threads, [&](int b) {
      const Vector3i first = firstSample(b);
      if (first.x() / side < firstLayer()) return;
      const Vector3d middle = point(first.cast<double>().array() + 0.5 * (side - 1));
      const Vector3d p = warp_(middle);
      double inBody = 0.0;  // radius of the warped block
      for (int c = 0; c < 8; ++c) {
        const Vector3d end = middle.array() + side * options_.cell * (corner(c).cast<double>().array() - 0.5);
        inBody = std::max(inBody, 1.15 * (warp_(end) - p).norm());
      }
      Block& block = block_[b];
      block.region = shape_.region(p, std::min(inBody, radius));
      const double value = shape_.value(p, block.region);
      block.inside = value < 0.0;
      if (std::abs(value) <= 1.6 * std::min(inBody, radius)) activate(b);
    });
    mirrorFirstLayer();
  }

  void activate(int b) {
    Block& block = block_[b];
    block.active = true;
    block.values.resize(volume);
    for (int c = 0; c < 8; ++c) sampleCube(block, firstSample(b) + side / 2 * corner(c), side / 2, 0.0);
  }

  /// F at the samples of a cube; where it cannot change its sign within the cube or to the next sample, its
  /// sign alone. radius: of the cube and what is next to it, in the body; of the largest ones it is found
  /// here.
  void sampleCube(Block& block, const Vector3i& first, int size, double radius) {
    const Vector3d middle = first.cast<double>().array() + 0.5 * (size - 1);
    const Vector3d p = warp_(point(middle));
    const double value = shape_.value(p, block.region);
    if (size == 1) {
      block.values[offset(first)] = value;
      return;
    }
    if (radius == 0.0)
      for (int c = 0; c < 8; ++c)
        radius = std::max(
            radius,
            1.25 * (warp_(point(middle.array() + (size + 1) * (corner(c).cast<double>().array() - 0.5))) - p)
                       .norm());
    if (std::abs(value) > 1.6 * radius) {
      for (int k = 0; k < size * size * size; ++k)
        block.values[offset(first + Vector3i(k % size, k / size % size, k / (size * size)))] =
            std::copysign(1e9, value);
      return;
    }
    const int half = size / 2;
    for (int c = 0; c < 8; ++c)
      sampleCube(block, first + half * corner(c), half, radius * 1.2 * (half + 1) / (size + 1));
  }

  void mirrorFirstLayer() {
    for (int b = 0; b < blockCount() && options_.symmetric; ++b) {
      if (firstSample(b).x() != 0) continue;
      const Block& right = block_[b + 1];
      block_[b] = right;
      for (int k = 0; right.active && k < volume; ++k)
        block_[b].values[k] = right.values[k - k % side + (side - 1 - k % side)];
    }
  }

  /// Blocks were left out by a bound on how fast F grows. Where it fails, a cell between such a block and
  /// another sees both signs: sample those too, until no such cell is left.
  void activateMixedCells() {
    const auto isMixed = [&](const Vector3i& cell) {
      bool in = false, out = false;
      for (int c = 0; c < 8; ++c) (value(cell + corner(c)) < 0.0 ? in : out) = true;
      return in && out;
    };
    const auto meetsItsLike = [&](int b) {  // all blocks that share its last samples' cells are as it is
      for (int c = 1; c < 8; ++c) {
        const int other = blockOf(firstSample(b) + side * corner(c));
        const bool inside = other >= 0 && block_[other].inside, active = other >= 0 && block_[other].active;
        if (active || inside != block_[b].inside) return false;
      }
      return true;
    };
    for (bool changed = true; changed;) {
      changed = false;
      for (int b = 0; b < blockCount(); ++b) {
        if (block_[b].active || firstSample(b).x() / side < firstLayer() || meetsItsLike(b)) continue;
        bool mixed = false;
        for (int k = 0; k < volume && !mixed; ++k) mixed = isMixed(sampleOf(b, k));
        if (mixed) activate(b), changed = true;
      }
      if (changed) mirrorFirstLayer();
    }
  }

  /// A sample of the outermost layer lies inside. The mirrored layer is no rim.
  bool surfaceReachesTheRim() const {
    const Vector3i last = side * blocks_.array() - 1;
    for (int b = 0; b < blockCount(); ++b) {
      const Vector3i first = firstSample(b);
      const bool atRim = (first.array() == 0).any() || (first.array() + side > last.array()).any();
      if (!atRim || (!block_[b].active && !block_[b].inside)) continue;
      for (int k = 0; k < volume; ++k) {
        const Vector3i s = sampleOf(b, k);
        const bool low = (s.x() == 0 && !options_.symmetric) || s.y() == 0 || s.z() == 0;
        if ((low || (s.array() == last.array()).any()) && value(s) < 0.0) return true;
      }
    }
    return false;
  }

  const BodyShape& shape_;
  const PolygoniseOptions& options_;
  Warp warp_;
  Vector3d origin_;
  Vector3i blocks_;
  std::vector<Block> block_;
};

// ----------------------------------------------------------------------------------------------------
// Surface

/// The surface while it is being made; in the symmetric case its half with x >= 0, open along x = 0.
struct Surface {
  std::vector<Vector3d> positions;
  std::vector<int> blockOf;  ///< whose region describes F around the vertex
  std::vector<char> onPlane;
  std::vector<std::array<int, 3>> triangles;
};

int patternOf(const Grid& grid, const Vector3i& cell, std::array<double, 8>& values) {
  int pattern = 0;
  for (int c = 0; c < 8; ++c) {
    values[c] = grid.value(cell + corner(c));
    if (values[c] < 0.0) pattern |= 1 << c;
  }
  return pattern;
}

Surface contour(Grid& grid, bool symmetric) {
  static const LoopTable table = makeLoopTable();
  Surface surface;
  const int firstX = symmetric ? side - 1 : 0;  // the cell that the plane of symmetry cuts in halves
  std::array<double, 8> values;
  for (int b = 0; b < grid.blockCount(); ++b) {
    if (!grid.block(b).active) continue;
    grid.block(b).firstVertex.assign(volume, -1);
    for (int k = 0; k < volume; ++k) {
      const Vector3i cell = grid.sampleOf(b, k);
      if (cell.x() < firstX) continue;
      const int pattern = patternOf(grid, cell, values);
      if (pattern == 0 || pattern == 255) continue;
      grid.block(b).firstVertex[k] = static_cast<int>(surface.positions.size());
      for (int loop = 0; loop < table.count[pattern]; ++loop) {
        Vector3d sum = Vector3d::Zero();
        int crossings = 0;
        for (int e = 0; e < 12; ++e) {
          if (table.loop[pattern][e] != loop) continue;
          const auto [low, high] = cellEdges[e];
          Vector3d at(low & 1, low >> 1 & 1, low >> 2 & 1);
          at[e / 4] += values[low] / (values[low] - values[high]);
          sum += at;
          ++crossings;
        }
        const bool onPlane = symmetric && cell.x() == firstX;
        Vector3d q = grid.point(cell.cast<double>() + sum / crossings);
        if (onPlane) q.x() = 0.0;
        Vector3d p = grid.warp()(q);
        if (onPlane) p.x() = 0.0;
        surface.positions.push_back(p);
        surface.blockOf.push_back(b);
        surface.onPlane.push_back(onPlane);
      }
    }
  }

  const auto vertexAt = [&](const Vector3i& cell, int edge) {
    std::array<double, 8> around;
    const int pattern = patternOf(grid, cell, around);
    return grid.block(grid.blockOf(cell)).firstVertex[Grid::offset(cell)] + table.loop[pattern][edge];
  };
  for (int b = 0; b < grid.blockCount(); ++b) {
    if (!grid.block(b).active) continue;
    for (int k = 0; k < volume; ++k) {
      const Vector3i s = grid.sampleOf(b, k);
      if (symmetric && s.x() < side) continue;
      const bool inside = grid.value(s) < 0.0;
      for (int d = 0; d < 3; ++d) {
        if ((grid.value(s + Vector3i::Unit(d)) < 0.0) == inside) continue;
        // The four cells around the edge, counter-clockwise seen from its far end; within each, the edge's
        // number.
        const int e1 = (d + 1) % 3, e2 = (d + 2) % 3;
        std::array<int, 4> quad;
        constexpr std::array<std::array<int, 2>, 4> around = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
        for (int c = 0; c < 4; ++c) {
          const Vector3i shift = around[c][0] * Vector3i::Unit(e1) + around[c][1] * Vector3i::Unit(e2);
          const int low = shift.x() + 2 * shift.y() + 4 * shift.z();
          quad[c] = vertexAt(s - shift, edgeBetween(low, low + (1 << d)));
        }
        if (!inside) std::swap(quad[1], quad[3]);
        const auto& p = surface.positions;
        const bool along02 =
            (p[quad[0]] - p[quad[2]]).squaredNorm() <= (p[quad[1]] - p[quad[3]]).squaredNorm();
        const int r = along02 ? 0 : 1;
        surface.triangles.push_back({quad[r], quad[r + 1], quad[r + 2]});
        surface.triangles.push_back({quad[r], quad[r + 2], quad[(r + 3) % 4]});
      }
    }
  }
  return surface;
}

// ----------------------------------------------------------------------------------------------------
// Relaxation

/// Triangles around each vertex, as one list with offsets.
struct Fans {
  std::vector<int> start, triangles;
  explicit Fans(const Surface& surface)
      : start(surface.positions.size() + 1, 0), triangles(3 * surface.triangles.size()) {
    for (const auto& t : surface.triangles)
      for (const int v : t) ++start[v + 1];
    for (std::size_t v = 1; v < start.size(); ++v) start[v] += start[v - 1];
    std::vector<int> next(start.begin(), start.end() - 1);
    for (std::size_t t = 0; t < surface.triangles.size(); ++t)
      for (const int v : surface.triangles[t]) triangles[next[v]++] = static_cast<int>(t);
  }
};

bool holds(const std::array<int, 3>& t, int v) { return t[0] == v || t[1] == v || t[2] == v; }

int opposite(const std::array<int, 3>& t, int a, int b) {
  for (const int v : t)
    if (v != a && v != b) return v;
  return -1;
}

double angleAt(const Vector3d& apex, const Vector3d& a, const Vector3d& b) {
  return std::atan2((a - apex).cross(b - apex).norm(), (a - apex).dot(b - apex));
}

Vector3d areaNormal(const std::vector<Vector3d>& p, const std::array<int, 3>& t) {
  return (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]);
}

/// Flips edges whose opposite angles sum to more than pi, none near another in the same round, so that the
/// fans stay true.
void flipEdges(Surface& surface) {
  const Fans fans(surface);
  const auto& p = surface.positions;
  std::vector<char> touched(p.size(), false);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const int a = surface.triangles[t][k], b = surface.triangles[t][(k + 1) % 3],
                c = surface.triangles[t][(k + 2) % 3];
      if (touched[a] || touched[b] || touched[c]) break;
      int other = -1;
      for (int f = fans.start[a]; f < fans.start[a + 1]; ++f)
        if (fans.triangles[f] != static_cast<int>(t) && holds(surface.triangles[fans.triangles[f]], b))
          other = fans.triangles[f];
      if (other < static_cast<int>(t)) continue;  // seen from the other side, or on the border
      const int d = opposite(surface.triangles[other], a, b);
      if (touched[d] || (surface.onPlane[c] && surface.onPlane[d])) continue;
      if (angleAt(p[c], p[a], p[b]) + angleAt(p[d], p[a], p[b]) <= M_PI + 1e-6) continue;
      bool exists = false;
      for (int f = fans.start[c]; f < fans.start[c + 1]; ++f)
        exists |= holds(surface.triangles[fans.triangles[f]], d);
      if (exists) continue;
      const std::array<int, 3> first{a, d, c}, second{d, b, c};
      const Vector3d before = areaNormal(p, surface.triangles[t]) + areaNormal(p, surface.triangles[other]);
      const Vector3d n1 = areaNormal(p, first), n2 = areaNormal(p, second);
      if (n1.dot(before) <= 0.5 * n1.norm() * before.norm() ||
          n2.dot(before) <= 0.5 * n2.norm() * before.norm())
        continue;
      surface.triangles[t] = first;
      surface.triangles[other] = second;
      for (const int v : {a, b, c, d}) touched[v] = true;
      break;
    }
  }
}

/// Moves every vertex within the tangent plane towards the mean of its triangles weighted by area, then onto
/// F = 0.
void smooth(Surface& surface, const BodyShape& shape, const Grid& grid, const PolygoniseOptions& options,
            double tangential) {
  const Fans fans(surface);
  const auto& p = surface.positions;
  std::vector<Vector3d> moved(p.size());
  parallelFor(static_cast<int>(p.size()), options.threads, [&](int v) {
    Vector3d centroid = Vector3d::Zero(), normal = Vector3d::Zero();
    double area = 0.0;
    for (int f = fans.start[v]; f < fans.start[v + 1]; ++f) {
      const auto& t = surface.triangles[fans.triangles[f]];
      const Vector3d n = areaNormal(p, t);
      const double a = n.norm();
      centroid += a / 3.0 * (p[t[0]] + p[t[1]] + p[t[2]]);
      normal += n;
      area += a;
    }
    moved[v] = p[v];
    if (!(area > 0.0) || !(normal.norm() > 0.0)) return;
    Vector3d step = centroid / area - p[v];
    if (surface.onPlane[v]) normal.x() = 0.0, step.x() = 0.0;  // the other half adds the mirror image
    normal.normalize();
    step -= step.dot(normal) * normal;
    moved[v] += tangential * step;
    const FieldSample f = shape.sample(moved[v], grid.block(surface.blockOf[v]).region);
    Vector3d toSurface = -f.value / std::max(f.gradient.squaredNorm(), 1e-2) * f.gradient;
    if (surface.onPlane[v]) toSurface.x() = 0.0;
    const double longest = 0.25 * options.cell;
    if (toSurface.norm() > longest) toSurface *= longest / toSurface.norm();
    moved[v] += toSurface;
    if (!surface.onPlane[v] && options.symmetric) moved[v].x() = std::max(moved[v].x(), 0.05 * p[v].x());
  });
  surface.positions = std::move(moved);
}

Mesh wholeMesh(Surface surface, bool symmetric, std::vector<int>* partner) {
  Mesh mesh{
      .positions = std::move(surface.positions), .triangles = std::move(surface.triangles), .normals = {}};
  const int half = static_cast<int>(mesh.positions.size());
  std::vector<int> image(half);
  for (int v = 0; v < half; ++v) image[v] = v;
  if (symmetric) {
    for (int v = 0; v < half; ++v) {
      if (surface.onPlane[v]) continue;
      image[v] = static_cast<int>(mesh.positions.size());
      const Vector3d p = mesh.positions[v];
      mesh.positions.emplace_back(-p.x(), p.y(), p.z());
      image.push_back(v);
    }
    const std::size_t count = mesh.triangles.size();
    for (std::size_t t = 0; t < count; ++t) {
      const auto [a, b, c] = mesh.triangles[t];
      mesh.triangles.push_back({image[a], image[c], image[b]});
    }
  }
  computeNormals(mesh);
  if (symmetric)  // sums in another order differ in the last bit
    for (int v = 0; v < half; ++v) {
      if (image[v] == v)
        mesh.normals[v].x() = 0.0, mesh.normals[v].normalize();
      else
        mesh.normals[image[v]] = Vector3d(-mesh.normals[v].x(), mesh.normals[v].y(), mesh.normals[v].z());
    }
  if (partner) *partner = std::move(image);
  return mesh;
}

/// No edge runs twice in one direction. Two cells that share an ambiguous face can be joined by two edges of
/// the dual: four triangles would meet there.
bool edgesAreManifold(const Surface& surface) {
  std::vector<std::uint64_t> edges;
  edges.reserve(3 * surface.triangles.size());
  for (const auto& t : surface.triangles)
    for (int k = 0; k < 3; ++k)
      edges.push_back(static_cast<std::uint64_t>(t[k]) << 32 | static_cast<std::uint32_t>(t[(k + 1) % 3]));
  std::sort(edges.begin(), edges.end());
  return std::adjacent_find(edges.begin(), edges.end()) == edges.end();
}

Mesh relaxed(const BodyShape& shape, const Grid& grid, Surface surface, const PolygoniseOptions& options,
             std::vector<int>* partner) {
  for (int round = 0; round < options.relaxationRounds; ++round) {
    flipEdges(surface);
    smooth(surface, shape, grid, options, 0.8);
  }
  if (options.relaxationRounds > 0) {
    flipEdges(surface);
    smooth(surface, shape, grid, options, 0.0);
  }
  return wholeMesh(std::move(surface), options.symmetric, partner);
}

}  // namespace

Mesh polygonise(const BodyShape& shape, const PolygoniseOptions& wanted, std::vector<int>* partner) {
  PolygoniseOptions options = wanted;
  constexpr int attempts = 12;
  for (int attempt = 0;; ++attempt) {
    Grid grid(shape, options);
    Surface surface = contour(grid, options.symmetric);
    if (edgesAreManifold(surface)) return relaxed(shape, grid, std::move(surface), options, partner);
    if (attempt == attempts) throw std::runtime_error("no grid gave a manifold surface: take smaller cells");
    options.cell *= 0.973;
  }
}

}  // namespace gelenk
