#include "solvers/serial/seed_table.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>

#include "kinematics/configuration.h"

namespace gelenk {
namespace {

/// v turned by -azimuth about z.
void spinBack(const double* v, double cosine, double sine, double* out) {
  out[0] = cosine * v[0] + sine * v[1];
  out[1] = cosine * v[1] - sine * v[0];
  out[2] = v[2];
}

constexpr int trainingIterations = 12;

struct Sample {
  double q[maxChainDofs], frame[12];
};

/// Grows with the angle of (x, y) from 0 to 1 over the turn, without trigonometry: the perimeter of a square
/// instead of a circle.
double turnOf(double x, double y) {
  const double sum = std::abs(x) + std::abs(y);
  if (sum == 0.0) return 0.0;
  return 0.25 * (y >= 0.0 ? 1.0 - x / sum : 3.0 + x / sum);
}

}  // namespace

int SeedTable::cellOf(double radius, double height, double cosine, double turn) const {
  const auto bin = [&](double unit) { return std::clamp(static_cast<int>(unit * side_), 0, side_ - 1); };
  const int i = bin(radius / radius_), j = bin((height - lowest_) / (highest_ - lowest_)),
            k = bin(0.5 * (cosine + 1.0)), l = bin(turn);
  return ((i * side_ + j) * side_ + k) * side_ + l;
}

std::optional<SeedTable> SeedTable::build(const ChainConstants& C, int n, const SerialKernel& kernel,
                                          const SeedTableOptions& options) {
  if (n < 3 || C.revolute[0] == 0.0 || C.revolute[n - 1] == 0.0) return std::nullopt;
  const auto begin = std::chrono::steady_clock::now();
  SeedTable table;
  table.n_ = n;
  table.side_ = options.cellsPerSide;
  std::mt19937_64 random(options.seed);
  const double base[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, origin[3] = {0, 0, 0};
  double jacobian[6 * maxChainDofs];
  const auto draw = [&](Sample& s) {
    for (int i = 0; i < n; ++i)
      s.q[i] = C.seedLower[i] + (C.seedUpper[i] - C.seedLower[i]) * uniform01(random);
    s.q[0] = s.q[n - 1] = 0.0;
    kernel.frameAndJacobian(C, base, origin, s.q, s.frame, jacobian);
  };
  Sample s;
  for (int trial = 0; trial < 20'000; ++trial) {  // the region first, for the grid
    draw(s);
    table.radius_ = std::max(table.radius_, std::hypot(s.frame[9], s.frame[10]));
    table.lowest_ = trial ? std::min(table.lowest_, s.frame[11]) : s.frame[11];
    table.highest_ = trial ? std::max(table.highest_, s.frame[11]) : s.frame[11];
  }
  table.radius_ = std::max(table.radius_, 1e-9);
  table.highest_ = std::max(table.highest_, table.lowest_ + 1e-9);
  const int cells = table.side_ * table.side_ * table.side_ * table.side_;
  table.cells_.resize(cells, SeedCell{});
  table.counts_.assign(cells, 0);
  std::vector<int> seen(cells, 0);
  for (int trial = 0; trial < options.samples; ++trial) {
    draw(s);
    const double* p = s.frame + 9;
    const double radius = std::hypot(p[0], p[1]), azimuth = std::atan2(p[1], p[0]);
    const double c = radius > 0.0 ? p[0] / radius : 1.0, sn = radius > 0.0 ? p[1] / radius : 0.0;
    double x[3], y[3], z[3];
    spinBack(s.frame, c, sn, x);
    spinBack(s.frame + 3, c, sn, y);
    spinBack(s.frame + 6, c, sn, z);
    const int cell = table.cellOf(radius, p[2], z[2], turnOf(z[0], z[1]));
    int slot = table.counts_[cell];
    ++seen[cell];
    if (slot == kernelLanes) {  // a fair sample of all that came (Vitter's reservoir)
      slot = static_cast<int>(uniform01(random) * seen[cell]);
      if (slot >= kernelLanes) continue;
    } else {
      ++table.counts_[cell];
    }
    SeedCell& starts = table.cells_[cell];
    for (int i = 0; i < n; ++i) starts.q[i][slot] = static_cast<float>(s.q[i]);
    starts.q[0][slot] = static_cast<float>(-azimuth);
    for (int k = 0; k < 3; ++k)
      starts.x[k][slot] = static_cast<float>(x[k]), starts.y[k][slot] = static_cast<float>(y[k]);
  }
  for (int cell = 0; cell < cells; ++cell) table.order(C, kernel, cell);
  table.seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return table;
}

/// Greedy cover: the start that leads to most of the cell's poses first, then the one that adds most,
/// soonest.
void SeedTable::order(const ChainConstants& C, const SerialKernel& kernel, int cell) {
  constexpr int most = kernelLanes;
  const SeedCell from = cells_[cell];
  const int count = counts_[cell];
  if (count == 0) return;
  const double base[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, origin[3] = {0, 0, 0};
  const double middle = C.lower[0] > -1e299 && C.upper[0] < 1e299 ? 0.5 * (C.lower[0] + C.upper[0]) : 0.0;
  KernelTarget targets[most * most];
  double starts[most * most * maxChainDofs], frame[12], jacobian[6 * maxChainDofs], q[maxChainDofs];
  KernelAnswer answers[most * most];
  for (int t = 0; t < count; ++t) {
    for (int i = 0; i < n_; ++i) q[i] = from.q[i][t];
    q[0] = middle;  // the pose in the middle of the first joint's range
    kernel.frameAndJacobian(C, base, origin, q, frame, jacobian);
    KernelTarget target;
    for (int k = 0; k < 3; ++k)
      target.x[k] = frame[k], target.y[k] = frame[3 + k], target.z[k] = frame[6 + k],
      target.p[k] = frame[9 + k];
    LaneStarts turned;
    kernel.turnSeeds(C, target, from, count, turned);
    for (int s = 0; s < count; ++s) {
      targets[t * count + s] = target;
      for (int i = 0; i < n_; ++i) starts[(t * count + s) * n_ + i] = turned.q[i][s];
    }
  }
  kernel.batch(C, KernelTask{.attemptIterations = trainingIterations}, targets, count * count, starts, 1, 1,
               1, answers);
  unsigned covered = 0, taken = 0;
  for (int place = 0; place < count; ++place) {
    int best = -1, bestValue = -1;
    unsigned bestReach = 0;
    for (int s = 0; s < count; ++s) {
      if (taken >> s & 1) continue;
      unsigned reach = 0;
      int value = 0;
      for (int t = 0; t < count; ++t) {
        if (t == s || !answers[t * count + s].solved) continue;
        reach |= 1u << t;
        value += (covered >> t & 1 ? 1 : 16) * (2 * trainingIterations - answers[t * count + s].iterations);
      }
      if (value > bestValue) best = s, bestValue = value, bestReach = reach;
    }
    taken |= 1u << best;
    covered |= bestReach;
    for (int i = 0; i < n_; ++i) cells_[cell].q[i][place] = from.q[i][best];
    for (int k = 0; k < 3; ++k)
      cells_[cell].x[k][place] = from.x[k][best], cells_[cell].y[k][place] = from.y[k][best];
  }
}

int SeedTable::cellOf(const KernelTarget& target) const {
  const double radius = std::sqrt(target.p[0] * target.p[0] + target.p[1] * target.p[1]);
  const double c = radius > 0.0 ? target.p[0] / radius : 1.0, s = radius > 0.0 ? target.p[1] / radius : 0.0;
  double z[3];
  spinBack(target.z, c, s, z);
  return cellOf(radius, target.p[2], z[2], turnOf(z[0], z[1]));
}

bool SeedTable::lookUp(const ChainConstants& C, const SerialKernel& kernel, const KernelTarget& target,
                       LaneStarts& starts) const {
  const int cell = cellOf(target);
  starts.valid = 0;
  if (counts_[cell] == 0) return false;
  kernel.turnSeeds(C, target, cells_[cell], counts_[cell], starts);
  return true;
}

double SeedTable::filledCells() const {
  return static_cast<double>(std::count_if(counts_.begin(), counts_.end(), [](auto c) { return c > 0; })) /
         static_cast<double>(counts_.size());
}

}  // namespace gelenk
