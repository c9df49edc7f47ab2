#include "solvers/solutions/general_loop.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>

#include "solvers/serial/simd.h"
#include "solvers/solutions/trigonometric_roots.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// What Raghavan and Roth's equations compare: a point p, a direction l, and what can be made of them that
/// still transforms linearly under a rigid motion (with the constant 1, a representation of dimension 15).
struct Feature {
  Vector3d p, l, moment, mirror;  ///< moment p x l; mirror (p.p) l - 2 (p.l) p
  double pp, pl, one;
};

Feature featureOf(const Vector3d& p, const Vector3d& l) {
  return {p, l, p.cross(l), p.dot(p) * l - 2.0 * p.dot(l) * p, p.dot(p), p.dot(l), 1.0};
}

Feature moved(const Isometry3d& X, const Feature& f) {
  const Matrix3d R = X.linear();
  const Vector3d x = X.translation(), p = R * f.p, l = R * f.l, moment = R * f.moment;
  const double xx = x.squaredNorm(), pl = f.pl + x.dot(l);
  return {p + x * f.one,
          l,
          moment + x.cross(l),
          R * f.mirror + xx * l - 2.0 * x.cross(moment) - 2.0 * pl * x,
          f.pp + 2.0 * x.dot(p) + xx * f.one,
          pl,
          f.one};
}

/// Rz(sense * t) f = out[0] + cos t out[1] + sin t out[2].
void turned(const Feature& f, double sense, Feature out[3]) {
  const auto along = [](const Vector3d& v) { return Vector3d(0, 0, v.z()); };
  const auto across = [](const Vector3d& v) { return Vector3d(v.x(), v.y(), 0); };
  const auto ahead = [sense](const Vector3d& v) { return Vector3d(-sense * v.y(), sense * v.x(), 0); };
  out[0] = {along(f.p), along(f.l), along(f.moment), along(f.mirror), f.pp, f.pl, f.one};
  out[1] = {across(f.p), across(f.l), across(f.moment), across(f.mirror), 0, 0, 0};
  out[2] = {ahead(f.p), ahead(f.l), ahead(f.moment), ahead(f.mirror), 0, 0, 0};
}

constexpr int equations = 14, paired = 8;  ///< the first eight rows are four pairs (x, y) that u_3 turns

void fillColumn(const Feature& f, double column[equations]) {
  const Vector3d* vectors[4] = {&f.p, &f.l, &f.moment, &f.mirror};
  for (int k = 0; k < 4; ++k) {
    column[2 * k] = vectors[k]->x();
    column[2 * k + 1] = vectors[k]->y();
    column[paired + k] = vectors[k]->z();
  }
  column[12] = f.pp;
  column[13] = f.pl;
}

/// left[3 j + i] and right[3 j + i] are columns of 14: i counts 1, cos, sin of u_5 (of u_1), j of u_4 (u_2).
///     Rz(u_3) left (u_4, u_5) = right (u_1, u_2)
struct Equations {
  double left[9][equations], right[9][equations];

  explicit Equations(const Loop& loop) {
    const Feature axis = featureOf(Vector3d::Zero(), Vector3d::UnitZ());
    Feature inner[3], outer[3];
    turned(moved(loop.link[4], axis), 1.0, inner);
    for (int i = 0; i < 3; ++i) {
      turned(moved(loop.link[3], inner[i]), 1.0, outer);
      for (int j = 0; j < 3; ++j) fillColumn(moved(loop.link[2], outer[j]), left[3 * j + i]);
    }
    const Isometry3d last = loop.link[5].inverse(Eigen::Isometry),
                     first = loop.link[0].inverse(Eigen::Isometry),
                     second = loop.link[1].inverse(Eigen::Isometry);
    turned(moved(last, axis), -1.0, inner);
    for (int i = 0; i < 3; ++i) {
      turned(moved(first, inner[i]), -1.0, outer);
      for (int j = 0; j < 3; ++j) fillColumn(moved(second, outer[j]), right[3 * j + i]);
    }
  }
};

/// Householder reflections that make the eight columns in u_1, u_2 triangular; below them stand the six
/// equations without u_1 and u_2.
struct Elimination {
  double reflector[8][equations];  ///< unit vectors; entries before the diagonal are zero
  double R[8][8];                  ///< R[column][row]

  explicit Elimination(const Equations& e) {
    double column[8][equations];
    for (int k = 0; k < 8; ++k) std::copy_n(e.right[k + 1], equations, column[k]);
    for (int k = 0; k < 8; ++k) {
      double* v = reflector[k];
      double norm = 0.0;
      for (int i = 0; i < equations; ++i) v[i] = i < k ? 0.0 : column[k][i];
      for (int i = k; i < equations; ++i) norm += v[i] * v[i];
      norm = std::sqrt(norm);
      v[k] += v[k] < 0.0 ? -norm : norm;
      double length = 0.0;
      for (int i = k; i < equations; ++i) length += v[i] * v[i];
      length = length > 0.0 ? 1.0 / std::sqrt(length) : 0.0;
      for (int i = k; i < equations; ++i) v[i] *= length;
      for (int j = k; j < 8; ++j) reflect(k, column[j]);
      std::copy_n(column[k], 8, R[k]);
    }
  }

  void reflect(int k, double x[equations]) const {
    const double* v = reflector[k];
    double dot = 0.0;
    for (int i = k; i < equations; ++i) dot += v[i] * x[i];
    for (int i = k; i < equations; ++i) x[i] -= 2.0 * dot * v[i];
  }

  /// Row 8 + k of the orthogonal factor: what to sum the fourteen equations with to lose u_1 and u_2.
  void combination(int k, double x[equations]) const {
    std::fill_n(x, equations, 0.0);
    x[8 + k] = 1.0;
    for (int i = 7; i >= 0; --i) reflect(i, x);
  }
};

constexpr int size = 12;
using Square = double[size][size];

/// Six equations E_0 + cos u_3 E_c + sin u_3 E_s in the nine products of (1, cos u_4, sin u_4) and
/// (1, cos u_5, sin u_5).
struct Resultant {
  double constant[6][9], cosine[6][9], sine[6][9];

  Resultant(const Equations& e, const Elimination& elimination) {
    for (int k = 0; k < 6; ++k) {
      double w[equations];
      elimination.combination(k, w);
      for (int m = 0; m < 9; ++m) {
        const double* p = e.left[m];
        double fixed = 0.0, c = 0.0, s = 0.0;
        for (int i = paired; i < equations; ++i) fixed += w[i] * p[i];
        for (int i = 0; i < paired; i += 2) {
          c += w[i] * p[i] + w[i + 1] * p[i + 1];
          s += w[i + 1] * p[i] - w[i] * p[i + 1];
        }
        constant[k][m] = fixed, cosine[k][m] = c, sine[k][m] = s;
      }
      for (int i = 0; i < equations; ++i) constant[k][0] -= w[i] * e.right[0][i];
    }
  }

  void at(double c, double s, Square A) const { fill(1.0, c, s, A); }
  void slopeAt(double c, double s, Square A) const { fill(0.0, -s, c, A); }  ///< derivative by u_3

  void fill(double one0, double c, double s, Square A) const {
    for (int k = 0; k < 6; ++k)
      for (int i = 0; i < 3; ++i) {
        const auto entry = [&](int m) { return one0 * constant[k][m] + c * cosine[k][m] + s * sine[k][m]; };
        const double one = entry(i), halfCosine = 0.5 * entry(3 + i), halfSine = 0.5 * entry(6 + i);
        A[k][i] = one + halfCosine;
        A[k][3 + i] = A[k][9 + i] = A[6 + k][i] = halfSine;
        A[k][6 + i] = A[6 + k][9 + i] = halfCosine;
        A[6 + k][3 + i] = one - halfCosine;
        A[6 + k][6 + i] = -halfSine;
      }
  }
};

/// Determinants of four such matrices at once, but for a common sign: Householder reflections need no pivots,
/// so that the four keep step.
GELENK_INLINE void fourDeterminants(const Resultant& e, const double* c, const double* s, double* out) {
  Double4 A[size][size];  // A[column][row]
  const Double4 cosine = four(c), sine = four(s);
  for (int k = 0; k < 6; ++k)
    for (int i = 0; i < 3; ++i) {
      const Double4 one = e.constant[k][i] + cosine * e.cosine[k][i] + sine * e.sine[k][i];
      const Double4 halfCosine =
          0.5 * (e.constant[k][3 + i] + cosine * e.cosine[k][3 + i] + sine * e.sine[k][3 + i]);
      const Double4 halfSine =
          0.5 * (e.constant[k][6 + i] + cosine * e.cosine[k][6 + i] + sine * e.sine[k][6 + i]);
      A[i][k] = one + halfCosine;
      A[3 + i][k] = A[9 + i][k] = A[i][6 + k] = halfSine;
      A[6 + i][k] = A[9 + i][6 + k] = halfCosine;
      A[3 + i][6 + k] = one - halfCosine;
      A[6 + i][6 + k] = -halfSine;
    }
  Double4 product = {1.0, 1.0, 1.0, 1.0};
  for (int k = 0; k + 1 < size; ++k) {
    Double4* v = A[k];
    Double4 square = {};
    for (int i = k; i < size; ++i) square += v[i] * v[i];
    Double4 norm;
    for (int lane = 0; lane < 4; ++lane) norm[lane] = std::sqrt(square[lane]);
    const Double4 diagonal = v[k] < 0.0 ? norm : -norm;
    v[k] -= diagonal;
    product *= diagonal;
    const Double4 beta = -1.0 / (diagonal * v[k] - 1e-300);
    for (int j = k + 1; j < size; ++j) {
      Double4 dot = {};
      for (int i = k; i < size; ++i) dot += v[i] * A[j][i];
      dot *= beta;
      for (int i = k; i < size; ++i) A[j][i] -= dot * v[i];
    }
  }
  four(out) = product * A[size - 1][size - 1];
}

constexpr int samples = 24;  ///< 17 would do; the others measure the noise

struct Circle {
  double cosine[samples], sine[samples];
  Circle() {
    for (int j = 0; j < samples; ++j) {
      cosine[j] = std::cos(2.0 * M_PI * j / samples);
      sine[j] = std::sin(2.0 * M_PI * j / samples);
    }
  }
};
const Circle circle;

/// At 24 points of the circle, the first at `offset`.
GELENK_SIMD_CLONES void sampledDeterminants(const Resultant& resultant, double offset,
                                            double value[samples]) {
  const double c = std::cos(offset), s = std::sin(offset);
  double cosine[samples], sine[samples];
  for (int j = 0; j < samples; ++j) {
    cosine[j] = c * circle.cosine[j] - s * circle.sine[j];
    sine[j] = s * circle.cosine[j] + c * circle.sine[j];
  }
  for (int j = 0; j < samples; j += 4) fourDeterminants(resultant, cosine + j, sine + j, value + j);
}

/// The determinant as a polynomial of largest sampled value one, and what its harmonics 9 to 12 hold.
double interpolate(const Resultant& resultant, TrigonometricPolynomial& polynomial) {
  double value[samples], largest = 0.0;
  sampledDeterminants(resultant, 0.0, value);
  for (const double v : value) largest = std::max(largest, std::abs(v));
  if (!(largest > 1e-280)) return 1.0;
  polynomial.degree = 8;
  double noise = 0.0;
  for (int k = 0; k <= 12; ++k) {
    double a = 0.0, b = 0.0;
    for (int j = 0; j < samples; ++j) {
      a += value[j] * circle.cosine[j * k % samples];
      b += value[j] * circle.sine[j * k % samples];
    }
    const double weight = (k == 0 ? 1.0 : 2.0) / (samples * largest);
    if (k <= 8)
      polynomial.a[k] = weight * a, polynomial.b[k] = weight * b;
    else
      noise = std::max(noise, weight * std::hypot(a, b));
  }
  return noise;
}

/// Gaussian elimination with the largest entry of all as pivot: shows the rank, and solves for the kernel.
struct Kernel {
  int dimension;
  double basis[4][size];  ///< kernel vectors, not normalised
  double left[size];      ///< kernel vector of the transpose, for dimension 1
  double remainder;       ///< left A basis[0]: zero where the matrix is singular

  /// least: dimension at least, for roots so close to each other that one matrix stands for both.
  explicit Kernel(Square A, int least = 1) : dimension(least) {
    int column[size], row[size];
    double pivots[size];
    for (int j = 0; j < size; ++j) column[j] = row[j] = j;
    for (int k = 0; k < size; ++k) {
      int r = k, c = k;
      double most = -1.0;
      for (int i = k; i < size; ++i)
        for (int j = k; j < size; ++j)
          if (std::abs(A[i][j]) > most) most = std::abs(A[i][j]), r = i, c = j;
      pivots[k] = most;
      if (r != k) {
        for (int j = 0; j < size; ++j) std::swap(A[r][j], A[k][j]);
        std::swap(row[r], row[k]);
      }
      if (c != k) {
        for (int i = 0; i < size; ++i) std::swap(A[i][c], A[i][k]);
        std::swap(column[c], column[k]);
      }
      if (most == 0.0) continue;
      const double inverse = 1.0 / A[k][k];
      for (int i = k + 1; i < size; ++i) {
        const double factor = A[i][k] *= inverse;
        for (int j = k + 1; j < size; ++j) A[i][j] -= factor * A[k][j];
      }
    }
    while (dimension < 4 && pivots[size - 1 - dimension] < 1e-6 * pivots[0]) ++dimension;
    for (int b = 0; b < dimension; ++b) {
      double x[size] = {};
      const int rank = size - dimension;
      x[rank + b] = 1.0;
      for (int i = rank - 1; i >= 0; --i) {
        double sum = 0.0;
        for (int j = i + 1; j < size; ++j) sum += A[i][j] * x[j];
        x[i] = -sum / A[i][i];
      }
      for (int j = 0; j < size; ++j) basis[b][column[j]] = x[j];
    }
    double y[size];
    y[size - 1] = 1.0;
    for (int i = size - 2; i >= 0; --i) {
      y[i] = 0.0;
      for (int j = i + 1; j < size; ++j) y[i] -= A[j][i] * y[j];
    }
    for (int i = 0; i < size; ++i) left[row[i]] = y[i];
    remainder = A[size - 1][size - 1];
  }
};

/// (u_4, u_5) from a kernel vector, which is an outer product; v may be any complex multiple of it.
template <class Scalar>
void anglesOf(const Scalar v[size], double& u4, double& u5) {
  int best = 0;
  double most = -1.0;
  for (int r = 0; r < 4; ++r) {
    const double norm = std::norm(v[3 * r]) + std::norm(v[3 * r + 1]) + std::norm(v[3 * r + 2]);
    if (norm > most) most = norm, best = r;
  }
  const Scalar* w = v + 3 * best;  // a multiple of (1, cos u_5, sin u_5)
  const auto against = [](const Scalar& x, const Scalar& y) {
    return std::real(std::complex<double>(x) * std::conj(std::complex<double>(y)));
  };
  u5 = std::atan2(against(w[2], w[0]), against(w[1], w[0]));
  std::complex<double> half[2];
  for (int r = 0; r < 2; ++r) {
    half[r] = 0.0;
    for (int i = 0; i < 3; ++i)
      half[r] += std::complex<double>(v[3 * r + i]) * std::conj(std::complex<double>(w[i]));
  }
  // (cos, sin) of u_4 / 2 times a complex number: the double angle from squares.
  const double cc = std::norm(half[0]), ss = std::norm(half[1]), cs = std::real(half[0] * std::conj(half[1]));
  u4 = std::atan2(2.0 * cs, cc - ss);
}

Matrix3d aboutZ(double c, double s) {
  Matrix3d R;
  R << c, -s, 0, s, c, 0, 0, 0, 1;
  return R;
}
Matrix3d aboutZ(double t) { return aboutZ(std::cos(t), std::sin(t)); }

/// u_6, given the other five.
void closeLast(const Loop& loop, Vector6d& u) {
  Matrix3d R = Matrix3d::Identity();
  for (int i = 0; i < 5; ++i) R = R * aboutZ(u[i]) * loop.link[i].linear();
  const Matrix3d last = R.transpose() * loop.link[5].linear().transpose();
  u[5] = std::atan2(last(1, 0), last(0, 0));
}

/// The other three angles, given u_3, u_4, u_5.
Vector6d complete(const Loop& loop, const Equations& e, const Elimination& elimination, double u3, double u4,
                  double u5) {
  const double c3 = std::cos(u3), s3 = std::sin(u3);
  const double one[3] = {1.0, std::cos(u4), std::sin(u4)}, two[3] = {1.0, std::cos(u5), std::sin(u5)};
  double x[equations] = {};
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < equations; ++k) x[k] += one[j] * two[i] * e.left[3 * j + i][k];
  for (int k = 0; k < paired; k += 2) {
    const double along = c3 * x[k] - s3 * x[k + 1];
    x[k + 1] = s3 * x[k] + c3 * x[k + 1];
    x[k] = along;
  }
  for (int k = 0; k < equations; ++k) x[k] -= e.right[0][k];
  for (int k = 0; k < 8; ++k) elimination.reflect(k, x);
  for (int i = 7; i >= 0; --i) {
    for (int j = i + 1; j < 8; ++j) x[i] -= elimination.R[j][i] * x[j];
    x[i] /= elimination.R[i][i];
  }
  Vector6d u;
  u[0] = std::atan2(x[1], x[0]);
  u[1] = std::atan2(x[5], x[2]);
  u[2] = u3, u[3] = u4, u[4] = u5;
  closeLast(loop, u);
  return u;
}

/// Several solutions with the same u_3: the kernel is spanned by their vectors. Multiplying by exp(i u_4)
/// shifts the exponentials exp(i k u_4 / 2), k = -3, -1, 1, 3, so u_4 comes from the eigenvalues of that
/// shift.
void splitKernel(const Kernel& kernel, double u4[4], double u5[4]) {
  using Complex = std::complex<double>;
  using Block = Eigen::Matrix<Complex, 9, Eigen::Dynamic, 0, 9, 4>;
  using Small = Eigen::Matrix<Complex, Eigen::Dynamic, Eigen::Dynamic, 0, 4, 4>;
  const int n = kernel.dimension;
  Block low(9, n), up(9, n);
  for (int b = 0; b < n; ++b)
    for (int i = 0; i < 3; ++i) {
      const double* v = kernel.basis[b];
      const Complex one(v[i], v[3 + i]), three(v[6 + i], v[9 + i]);
      low(i, b) = std::conj(three), low(3 + i, b) = std::conj(one), low(6 + i, b) = one;
      up(i, b) = std::conj(one), up(3 + i, b) = one, up(6 + i, b) = three;
    }
  const Small normal = low.adjoint() * low, mixed = low.adjoint() * up;
  const Small shift = normal.partialPivLu().solve(mixed);
  Eigen::ComplexEigenSolver<Small> eigen(shift);
  for (int b = 0; b < n; ++b) {
    Complex v[size] = {};
    for (int k = 0; k < n; ++k)
      for (int i = 0; i < size; ++i) v[i] += kernel.basis[k][i] * eigen.eigenvectors()(k, b);
    anglesOf(v, u4[b], u5[b]);
  }
}

double wrapped(double angle) { return std::remainder(angle, 2.0 * M_PI); }

}  // namespace

namespace {

/// Walks along a loop: the frame reached, as seen from before hinge 1.
struct Walk {
  Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ(), p = Vector3d::Zero();

  void past(const Loop& loop, int i, double u) {
    const bool slides = loop.slidesAt(i);
    if (slides) p += u * z;
    const double c = slides ? 1.0 : std::cos(u), s = slides ? 0.0 : std::sin(u);
    const Vector3d ahead = c * x + s * y, side = c * y - s * x, up = z;
    const auto& M = loop.link[i].matrix();
    p += M(0, 3) * ahead + M(1, 3) * side + M(2, 3) * up;
    x = M(0, 0) * ahead + M(1, 0) * side + M(2, 0) * up;
    y = M(0, 1) * ahead + M(1, 1) * side + M(2, 1) * up;
    z = M(0, 2) * ahead + M(1, 2) * side + M(2, 2) * up;
  }

  double trace() const { return x.x() + y.y() + z.z(); }
  Vector6d error() const {
    Vector6d e;
    e << p, 0.5 * (y.z() - z.y()), 0.5 * (z.x() - x.z()), 0.5 * (x.y() - y.x());
    return e;
  }
};

/// Solves J x = e by elimination with column pivots, in e; returns the determinant.
double solve(Matrix6d& J, Vector6d& e) {
  double determinant = 1.0;
  for (int k = 0; k < 6; ++k) {
    int pivot = k;
    for (int i = k + 1; i < 6; ++i)
      if (std::abs(J(i, k)) > std::abs(J(pivot, k))) pivot = i;
    if (pivot != k) {
      for (int j = k; j < 6; ++j) std::swap(J(k, j), J(pivot, j));
      std::swap(e[k], e[pivot]);
      determinant = -determinant;
    }
    determinant *= J(k, k);
    const double inverse = 1.0 / J(k, k);
    double factor[6];
    for (int i = k + 1; i < 6; ++i) factor[i] = J(i, k) * inverse;
    for (int j = k + 1; j < 6; ++j)
      for (int i = k + 1; i < 6; ++i) J(i, j) -= factor[i] * J(k, j);
    for (int i = k + 1; i < 6; ++i) e[i] -= factor[i] * e[k];
  }
  for (int k = 5; k >= 0; --k) {
    e[k] /= J(k, k);
    for (int i = 0; i < k; ++i) e[i] -= J(i, k) * e[k];
  }
  return determinant;
}

}  // namespace

Vector6d loopError(const Loop& loop, const Vector6d& u) {
  Walk walk;
  for (int i = 0; i < 6; ++i) walk.past(loop, i, u[i]);
  Vector6d e = walk.error();
  if (walk.trace() < 1.0) {  // over a right angle: the sine alone would lie
    const double angle = std::acos(std::clamp(0.5 * (walk.trace() - 1.0), -1.0, 1.0));
    e.tail<3>() =
        e.tail<3>().norm() > 1e-9 ? Vector3d(e.tail<3>().normalized() * angle) : Vector3d(angle, 0, 0);
  }
  return e;
}

double loopDeterminant(const Loop& loop, const Vector6d& u) {
  Matrix6d J;
  Walk walk;
  for (int i = 0; i < 6; ++i) {
    J.col(i) << walk.p.cross(walk.z), walk.z;  // of the frame before hinge 1, where the loop ends
    walk.past(loop, i, u[i]);
  }
  Vector6d unused = Vector6d::Zero();
  return solve(J, unused);
}

bool polish(const Loop& loop, Vector6d& u, double accepted, double& error, double& before) {
  error = INFINITY;
  Vector6d best = u;
  for (int iteration = 0; iteration < 10; ++iteration) {
    Vector3d axis[6], origin[6];
    Walk walk;
    for (int i = 0; i < 6; ++i) {
      axis[i] = walk.z, origin[i] = walk.p;
      walk.past(loop, i, u[i]);
    }
    Vector6d e = walk.error();
    double now = e.norm();
    if (walk.trace() < 1.0) now += 2.0;
    if (iteration == 0) before = now;
    if (!(now < 0.5 * error)) {  // no longer worth a step
      if (now < error) error = now, best = u;
      break;
    }
    error = now, best = u;
    if (now < 2e-15) break;
    Matrix6d J;
    for (int i = 0; i < 6; ++i)
      if (loop.slidesAt(i))
        J.col(i) << axis[i], Vector3d::Zero();
      else
        J.col(i) << axis[i].cross(walk.p - origin[i]), axis[i];
    solve(J, e);
    if (!e.allFinite() || e.norm() > 2.0) break;
    u -= e;
  }
  u = best;
  return error < accepted;
}

bool add(LoopSolutions& solutions, const Vector6d& u, double error) {
  for (int k = 0; k < solutions.count; ++k) {
    bool same = true;
    for (int i = 0; i < 6 && same; ++i) same = std::abs(wrapped(solutions.u[k][i] - u[i])) < 1e-7;
    if (same) return false;
  }
  if (solutions.count == LoopSolutions::most) return false;
  solutions.u[solutions.count] = u;
  solutions.error[solutions.count++] = error;
  return true;
}

namespace {

/// Newton's step for det A(u_3) = 0 from the kernels of A and its transpose: accurate where the polynomial is
/// not, because it looks at the matrix itself.
double refinement(const Resultant& resultant, const Kernel& kernel, double c, double s) {
  Square D;
  resultant.slopeAt(c, s, D);
  double slope = 0.0;
  for (int i = 0; i < size; ++i) {
    double sum = 0.0;
    for (int j = 0; j < size; ++j) sum += D[i][j] * kernel.basis[0][j];
    slope += kernel.left[i] * sum;
  }
  return -kernel.remainder / slope;
}

}  // namespace

LoopSolutions solveGeneralLoop(const Loop& loop, const LoopSolutions& known) {
  constexpr double sameRoot = 1e-6;
  LoopSolutions solutions;
  bool taken[LoopSolutions::most] = {};
  const Equations e(loop);
  const Elimination elimination(e);
  const Resultant resultant(e, elimination);
  TrigonometricPolynomial polynomial;
  solutions.noise = interpolate(resultant, polynomial);
  if (solutions.noise > 1e-4) return solutions;
  const TrigonometricRoots roots = realRoots(polynomial, 100.0 * solutions.noise);
  const auto follow = [&](double root, bool proven) {
    for (int k = 0; k < known.count; ++k)
      if (!taken[k] && std::abs(wrapped(known.u[k][2] - root)) < sameRoot) {
        taken[k] = true;
        add(solutions, known.u[k], known.error[k]);
        return;
      }
    double u3 = root, u4[4], u5[4];
    int dimension = 1;
    for (int pass = 0; pass < 4; ++pass) {
      const double c = std::cos(u3), s = std::sin(u3);
      Square A;
      resultant.at(c, s, A);
      const Kernel kernel(A);
      dimension = kernel.dimension;
      if (dimension > 1) {
        ++solutions.multiple;
        splitKernel(kernel, u4, u5);
        break;
      }
      anglesOf(kernel.basis[0], u4[0], u5[0]);
      const double step = refinement(resultant, kernel, c, s);
      if (!(std::abs(step) > 1e-11 && std::abs(step) < 0.1)) break;
      u3 += step;
    }
    // Newton must not wander off to the solution of another root.
    const auto take = [&](Vector6d u) {
      double error, raw;
      if (!u.allFinite() || !polish(loop, u, 1e-10, error, raw)) return;
      for (double& angle : u) angle = wrapped(angle);
      if (std::abs(wrapped(u[2] - root)) > 0.05) return;
      if (add(solutions, u, error)) solutions.raw = std::max(solutions.raw, raw);
    };
    const auto accept = [&](int candidates) {
      const int before = solutions.count;
      for (int b = 0; b < candidates; ++b) take(complete(loop, e, elimination, u3, u4[b], u5[b]));
      return solutions.count > before;
    };
    if (accept(dimension) || dimension > 1) return;
    // Nothing new: another root lies so close that the kernel holds a mixture of both solutions.
    Square A;
    u3 = root;
    resultant.at(std::cos(u3), std::sin(u3), A);
    splitKernel(Kernel(A, 2), u4, u5);
    if (accept(2) || !proven) return;
    // The triangular system for hinges 1 and 2 is ill-conditioned: all round instead.
    const double u4Own = u4[0], u5Own = u5[0];
    const int before = solutions.count;
    constexpr int round = 6;
    for (int k = 0; k < 2 * round * round && solutions.count == before; ++k) {
      Vector6d u;
      u << 2.0 * M_PI * (k % round) / round, 2.0 * M_PI * (k / round % round) / round, root, u4Own, u5Own, 0;
      if (k >= round * round) u[3] = u4[1], u[4] = u5[1];
      closeLast(loop, u);
      take(u);
    }
  };
  for (int r = 0; r < roots.count; ++r) follow(roots.t[r], r < roots.count - roots.grazing);
  if (solutions.count < roots.count) {
    // The determinant spans more than double precision round the circle; its own samples are accurate where
    // the polynomial drowns in noise: sign changes and dips of a finer grid.
    constexpr int rounds = 8;
    double value[samples * rounds], at[samples * rounds];
    for (int k = 0; k < rounds; ++k) {
      double part[samples];
      sampledDeterminants(resultant, 2.0 * M_PI * k / (samples * rounds), part);
      for (int j = 0; j < samples; ++j) {
        value[j * rounds + k] = part[j];
        at[j * rounds + k] = 2.0 * M_PI * (j * rounds + k) / (samples * rounds);
      }
    }
    constexpr int n = samples * rounds;
    for (int j = 0; j < n && solutions.count < LoopSolutions::most; ++j) {
      const double left = value[(j + n - 1) % n], own = value[j], right = value[(j + 1) % n];
      if ((own < 0.0) != (right < 0.0))
        follow(at[j] + (2.0 * M_PI / n) * own / (own - right), false);
      else if (std::abs(own) < std::abs(left) && std::abs(own) < std::abs(right))
        follow(at[j], false);
    }
  }
  solutions.roots = roots.count - roots.grazing;
  solutions.suspects = std::max(0, roots.count - solutions.count) + roots.drowned;
  return solutions;
}

}  // namespace gelenk
