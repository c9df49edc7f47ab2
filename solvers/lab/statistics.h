#pragma once

#include <cstdint>
#include <vector>

namespace gelenk {

struct Interval {
  double lower = 0.0, upper = 0.0;
};

/// Wilson's score interval of a proportion at 95 %. Wilson 1927. trials 0: [0, 1].
Interval wilsonInterval(int successes, int trials);

/// Exact McNemar test (binomial, two-sided) of the pairs in which exactly one of two methods succeeded; 1
/// without such pairs. McNemar 1947.
double mcNemar(int onlyFirst, int onlySecond);

/// Value below which the share p of the data lies, linear between neighbours (Hyndman, Fan 1996, type 7).
/// NaNs are left out; NaN for no data.
double quantile(std::vector<double> values, double p);

/// Mean of the values that are not NaN; NaN for none.
double mean(const std::vector<double>& values);

/// Of a sample, with n - 1 below the root, NaNs left out; NaN for less than two values.
double standardDeviation(const std::vector<double>& values);

/// Ratio of the sums of two paired samples with its 95 % percentile bootstrap interval from 1000 resamples of
/// the pairs. Efron, Tibshirani 1993.
struct RatioEstimate {
  double ratio = 0.0;
  Interval interval;
};
RatioEstimate pairedRatio(const std::vector<double>& first, const std::vector<double>& second,
                          std::uint64_t seed);

/// Dolan and More 2002: for each ratio tau, the share of problems that a method solves within tau times the
/// best method's time. times: [method][problem], infinity where unsolved. Problems that nobody solves count
/// for all.
std::vector<std::vector<double>> performanceProfile(const std::vector<std::vector<double>>& times,
                                                    const std::vector<double>& taus);

}  // namespace gelenk
