#pragma once

#include <fmt/format.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace gelenk::text {

/// "(1.5, -2)" with up to `digits` significant digits; tiny values print as 0.
inline std::string point(const Eigen::VectorXd& v, int digits = 8) {
  std::string out = "(";
  for (Eigen::Index i = 0; i < v.size(); ++i)
    out += (i ? ", " : "") + fmt::format("{:.{}g}", std::abs(v[i]) < 1e-14 ? 0.0 : v[i], digits);
  return out + ")";
}

/// Rows on lines of their own, columns aligned, indented.
inline std::string matrix(const Eigen::MatrixXd& m, int digits = 6, int indent = 6) {
  std::string out;
  for (Eigen::Index i = 0; i < m.rows(); ++i) {
    out += std::string(static_cast<std::size_t>(indent), ' ') + "[";
    for (Eigen::Index j = 0; j < m.cols(); ++j)
      out += fmt::format("{:>{}.{}g}", std::abs(m(i, j)) < 1e-14 ? 0.0 : m(i, j), digits + 8, digits);
    out += " ]\n";
  }
  return out;
}

inline std::vector<double> list(const Eigen::MatrixXd& m) {  ///< row by row
  std::vector<double> out;
  for (Eigen::Index i = 0; i < m.rows(); ++i)
    for (Eigen::Index j = 0; j < m.cols(); ++j) out.push_back(m(i, j));
  return out;
}

}  // namespace gelenk::text
