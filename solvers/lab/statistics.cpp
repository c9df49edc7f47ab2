#include "solvers/lab/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

namespace gelenk {

Interval wilsonInterval(int successes, int trials) {
  if (trials <= 0) return {0.0, 1.0};
  constexpr double z = 1.959963984540054;  // 97.5 % quantile of the normal distribution
  const double n = trials, p = successes / n, z2 = z * z;
  const double middle = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
  const double half = z / (1.0 + z2 / n) * std::sqrt(p * (1.0 - p) / n + z2 / (4.0 * n * n));
  return {successes == 0 ? 0.0 : std::max(0.0, middle - half),
          successes == trials ? 1.0 : std::min(1.0, middle + half)};
}

double mcNemar(int onlyFirst, int onlySecond) {
  const int n = onlyFirst + onlySecond, k = std::min(onlyFirst, onlySecond);
  if (n == 0) return 1.0;
  double tail = 0.0;  // P(X <= k), X binomial (n, 1/2)
  for (int i = 0; i <= k; ++i)
    tail +=
        std::exp(std::lgamma(n + 1.0) - std::lgamma(i + 1.0) - std::lgamma(n - i + 1.0) - n * std::log(2.0));
  return std::min(1.0, 2.0 * tail);
}

double quantile(std::vector<double> values, double p) {
  std::erase_if(values, [](double x) { return std::isnan(x); });
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const double at = p * static_cast<double>(values.size() - 1);
  const std::size_t low = static_cast<std::size_t>(at), high = std::min(low + 1, values.size() - 1);
  if (low == high || values[low] == values[high]) return values[low];
  return values[low] + (at - static_cast<double>(low)) * (values[high] - values[low]);
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  int count = 0;
  for (double x : values) {
    if (std::isnan(x)) continue;
    sum += x;
    ++count;
  }
  return count > 0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
}

double standardDeviation(const std::vector<double>& values) {
  const double middle = mean(values);
  double sum = 0.0;
  int count = 0;
  for (double x : values) {
    if (std::isnan(x)) continue;
    sum += (x - middle) * (x - middle);
    ++count;
  }
  return count > 1 ? std::sqrt(sum / (count - 1)) : std::numeric_limits<double>::quiet_NaN();
}

RatioEstimate pairedRatio(const std::vector<double>& first, const std::vector<double>& second,
                          std::uint64_t seed) {
  const std::size_t n = std::min(first.size(), second.size());
  RatioEstimate estimate;
  if (n == 0) return estimate;
  const double top = std::accumulate(first.begin(), first.begin() + static_cast<std::ptrdiff_t>(n), 0.0);
  const double bottom = std::accumulate(second.begin(), second.begin() + static_cast<std::ptrdiff_t>(n), 0.0);
  estimate.ratio = top / bottom;
  std::mt19937_64 random(seed);
  std::vector<double> ratios(1000);
  for (double& ratio : ratios) {
    double a = 0.0, b = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t pick = random() % n;
      a += first[pick];
      b += second[pick];
    }
    ratio = a / b;
  }
  estimate.interval = {quantile(ratios, 0.025), quantile(ratios, 0.975)};
  return estimate;
}

std::vector<std::vector<double>> performanceProfile(const std::vector<std::vector<double>>& times,
                                                    const std::vector<double>& taus) {
  std::vector<std::vector<double>> profile(times.size(), std::vector<double>(taus.size(), 0.0));
  const std::size_t problems = times.empty() ? 0 : times[0].size();
  for (std::size_t i = 0; i < problems; ++i) {
    double best = std::numeric_limits<double>::infinity();
    for (const auto& method : times) best = std::min(best, method[i]);
    if (!std::isfinite(best)) continue;
    for (std::size_t m = 0; m < times.size(); ++m)
      for (std::size_t t = 0; t < taus.size(); ++t)
        if (times[m][i] <= taus[t] * best) profile[m][t] += 1.0 / static_cast<double>(problems);
  }
  return profile;
}

}  // namespace gelenk
