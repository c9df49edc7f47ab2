#include "solvers/seed_table.h"

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

/// The angle's representative within [lower, upper] nearest to the range's middle; NaN where there is none.
double intoRange(double angle, double lower, double upper) {
  if (lower <= -1e299 || upper >= 1e299) return std::remainder(angle, 2.0 * M_PI);
  const double middle = 0.5 * (lower + upper);
  const double wrapped = middle + std::remainder(angle - middle, 2.0 * M_PI);
  return wrapped >= lower && wrapped <= upper ? wrapped : std::nan("");
}

struct Sample {
  double q[maxChainDofs], frame[12];
};

}  // namespace

int SeedTable::cellOf(double radius, double height, double cosine, double azimuth) const {
  const auto bin = [&](double unit) { return std::clamp(static_cast<int>(unit * side_), 0, side_ - 1); };
  const int i = bin(radius / radius_), j = bin((height - lowest_) / (highest_ - lowest_)), k = bin(0.5 * (cosine + 1.0)),
            l = bin(azimuth / (2.0 * M_PI) + 0.5);
  return ((i * side_ + j) * side_ + k) * side_ + l;
}

std::optional<SeedTable> SeedTable::build(const ChainConstants& C, int n, const SerialKernel& kernel, const SeedTableOptions& options) {
  if (n < 3 || C.revolute[0] == 0.0 || C.revolute[n - 1] == 0.0) return std::nullopt;
  const auto begin = std::chrono::steady_clock::now();
  SeedTable table;
  table.n_ = n;
  table.side_ = options.cellsPerSide;
  table.perCell_ = options.entriesPerCell;
  std::mt19937_64 random(options.seed);
  const double base[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, origin[3] = {0, 0, 0};
  double jacobian[6 * maxChainDofs];
  const auto draw = [&](Sample& s) {
    for (int i = 0; i < n; ++i) s.q[i] = C.seedLower[i] + (C.seedUpper[i] - C.seedLower[i]) * uniform01(random);
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
  table.entries_.resize(static_cast<size_t>(cells) * table.perCell_);
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
    const int cell = table.cellOf(radius, p[2], z[2], std::atan2(z[1], z[0]));
    int slot = table.counts_[cell];
    ++seen[cell];
    if (slot == table.perCell_) {  // a fair sample of all that came (Vitter's reservoir)
      slot = static_cast<int>(uniform01(random) * seen[cell]);
      if (slot >= table.perCell_) continue;
    } else {
      ++table.counts_[cell];
    }
    Entry& entry = table.entries_[static_cast<size_t>(cell) * table.perCell_ + slot];
    for (int i = 0; i < n; ++i) entry.q[i] = static_cast<float>(s.q[i]);
    entry.q[0] = static_cast<float>(-azimuth);
    for (int k = 0; k < 3; ++k) entry.x[k] = static_cast<float>(x[k]), entry.y[k] = static_cast<float>(y[k]);
    entry.radius = static_cast<float>(radius);
    entry.height = static_cast<float>(p[2]);
  }
  table.seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return table;
}

int SeedTable::lookUp(const ChainConstants& C, const KernelTarget& target, int most, double* starts) const {
  const double radius = std::sqrt(target.p[0] * target.p[0] + target.p[1] * target.p[1]);
  const double c = radius > 0.0 ? target.p[0] / radius : 1.0, s = radius > 0.0 ? target.p[1] / radius : 0.0;
  const double azimuth = std::atan2(s, c);
  double x[3], y[3], z[3];
  spinBack(target.x, c, s, x);
  spinBack(target.y, c, s, y);
  spinBack(target.z, c, s, z);
  const int cell = cellOf(radius, target.p[2], z[2], std::atan2(z[1], z[0]));
  struct Candidate {
    double distance, first, last;
    const Entry* entry;
  };
  Candidate found[256];
  int count = 0;
  for (int slot = 0; slot < counts_[cell]; ++slot) {
    const Entry& entry = entries_[static_cast<size_t>(cell) * perCell_ + slot];
    const double xx = entry.x[0] * x[0] + entry.x[1] * x[1] + entry.x[2] * x[2], xy = entry.x[0] * y[0] + entry.x[1] * y[1] + entry.x[2] * y[2];
    const double yx = entry.y[0] * x[0] + entry.y[1] * x[1] + entry.y[2] * x[2], yy = entry.y[0] * y[0] + entry.y[1] * y[1] + entry.y[2] * y[2];
    const double ez[3] = {entry.x[1] * entry.y[2] - entry.x[2] * entry.y[1], entry.x[2] * entry.y[0] - entry.x[0] * entry.y[2],
                          entry.x[0] * entry.y[1] - entry.x[1] * entry.y[0]};
    const double cosineRoll = xx + yy, sineRoll = xy - yx;  // the roll that brings the entry's frame nearest to the target's
    Candidate& candidate = found[count];
    candidate.first = intoRange(entry.q[0] + azimuth, C.lower[0], C.upper[0]);
    candidate.last = intoRange(std::atan2(sineRoll, cosineRoll), C.lower[n_ - 1], C.upper[n_ - 1]);
    if (std::isnan(candidate.first) || std::isnan(candidate.last)) continue;
    const double trace = std::sqrt(cosineRoll * cosineRoll + sineRoll * sineRoll) + ez[0] * z[0] + ez[1] * z[1] + ez[2] * z[2];
    const double dr = radius - entry.radius, dh = target.p[2] - entry.height;
    candidate.distance = dr * dr + dh * dh + (3.0 - trace);
    candidate.entry = &entry;
    ++count;
  }
  const int given = std::min(count, most);
  std::partial_sort(found, found + given, found + count, [](const Candidate& a, const Candidate& b) { return a.distance < b.distance; });
  for (int k = 0; k < given; ++k) {
    double* row = starts + static_cast<size_t>(k) * n_;
    for (int i = 1; i + 1 < n_; ++i) row[i] = found[k].entry->q[i];
    row[0] = found[k].first;
    row[n_ - 1] = found[k].last;
  }
  return given;
}

double SeedTable::filledCells() const {
  return static_cast<double>(std::count_if(counts_.begin(), counts_.end(), [](auto c) { return c > 0; })) / static_cast<double>(counts_.size());
}

}  // namespace gelenk
