#pragma once

#include <fmt/format.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace gelenk::text {

inline double clean(double value) { return std::abs(value) < 1e-14 ? 0.0 : value; }

/// With so many digits behind the point; nothing is "-0.00".
inline std::string fixed(double value, int decimals) {
  const std::string out = fmt::format("{:.{}f}", value, decimals);
  return out.find_first_of("123456789") == std::string::npos && out.starts_with('-') ? out.substr(1) : out;
}

/// "1.234e-05".
inline std::string scientific(double value, int decimals = 3) {
  return fmt::format("{:.{}e}", value, decimals);
}

/// "(1.5, -2)" with up to `digits` significant digits; tiny values print as 0.
inline std::string point(const Eigen::VectorXd& v, int digits = 8) {
  std::string out = "(";
  for (Eigen::Index i = 0; i < v.size(); ++i)
    out += (i ? ", " : "") + fmt::format("{:.{}g}", clean(v[i]), digits);
  return out + ")";
}

/// Rows on lines of their own, columns aligned, indented.
inline std::string matrix(const Eigen::MatrixXd& m, int digits = 6, int indent = 6) {
  std::string out;
  for (Eigen::Index i = 0; i < m.rows(); ++i) {
    out += std::string(static_cast<std::size_t>(indent), ' ') + "[";
    for (Eigen::Index j = 0; j < m.cols(); ++j)
      out += fmt::format("{:>{}.{}g}", clean(m(i, j)), digits + 8, digits);
    out += " ]\n";
  }
  return out;
}

/// A line of a table (text_table.h).
inline std::string row(const std::vector<std::string>& cells) {
  std::string out;
  for (const std::string& cell : cells) out += "\t" + cell;
  return out + "\n";
}
/// Its first, the heads of the columns.
inline std::string heads(const std::vector<std::string>& cells) { return row(cells) + "\t---\n"; }

/// A cell for each coordinate.
inline void append(std::vector<std::string>& cells, const Eigen::VectorXd& v, int decimals) {
  for (const double value : v) cells.push_back(fixed(value, decimals));
}
/// One head over as many columns.
inline void appendHead(std::vector<std::string>& cells, const std::string& head, Eigen::Index columns) {
  cells.push_back(head);
  cells.resize(cells.size() + static_cast<std::size_t>(columns) - 1);
}

inline std::vector<double> list(const Eigen::MatrixXd& m) {  ///< row by row
  std::vector<double> out;
  for (Eigen::Index i = 0; i < m.rows(); ++i)
    for (Eigen::Index j = 0; j < m.cols(); ++j) out.push_back(m(i, j));
  return out;
}

}  // namespace gelenk::text
