#pragma once

#include <algorithm>
#include <cmath>

namespace gelenk {

/// The value in [lower, upper] where f is lowest, among `now`, evenly spaced samples and what golden sections
/// about the best of these find.
template <typename Function>
double lowestOn(double lower, double upper, double now, const Function& f) {
  constexpr int samples = 48, sections = 40;
  double best = now, lowest = f(now);
  const auto look = [&](double value) {
    const double cost = f(value);
    if (cost < lowest) lowest = cost, best = value;
    return cost;
  };
  const double spacing = (upper - lower) / samples;
  if (!(spacing > 0.0)) return best;
  for (int k = 0; k <= samples; ++k) look(std::min(upper, lower + k * spacing));
  double from = std::max(lower, best - spacing), to = std::min(upper, best + spacing);
  constexpr double golden = 0.6180339887498949;
  double a = to - golden * (to - from), b = from + golden * (to - from);
  double atA = look(a), atB = look(b);
  for (int k = 0; k < sections; ++k) {
    if (atA < atB) {
      to = b, b = a, atB = atA;
      a = to - golden * (to - from), atA = look(a);
    } else {
      from = a, a = b, atA = atB;
      b = from + golden * (to - from), atB = look(b);
    }
  }
  return best;
}

}  // namespace gelenk
