#include "skinning/muscles/nurbs_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <unordered_map>

namespace gelenk {

using Eigen::Vector3d;
using Eigen::Vector4d;

namespace {

void validateKnots(const std::vector<double>& knots, int degree, int count, const std::string& direction) {
  if (degree < 1 || degree > 9)
    throw std::invalid_argument("degree in " + direction + " is " + std::to_string(degree) +
                                ", expected 1 to 9");
  if (count <= degree)
    throw std::invalid_argument(std::to_string(count) + " control points in " + direction +
                                ", expected at least degree + 1 = " + std::to_string(degree + 1));
  const std::size_t expected = static_cast<std::size_t>(count) + degree + 1;
  if (knots.size() != expected)
    throw std::invalid_argument(std::to_string(knots.size()) + " knots in " + direction +
                                ", expected points + degree + 1 = " + std::to_string(expected));
  for (std::size_t i = 0; i < knots.size(); ++i) {
    if (!std::isfinite(knots[i]))
      throw std::invalid_argument("knot " + std::to_string(i) + " in " + direction + " is not finite");
    if (i > 0 && knots[i] < knots[i - 1])
      throw std::invalid_argument("knot " + std::to_string(i) + " in " + direction +
                                  " is smaller than the one before it");
  }
  if (!(knots[degree] < knots[count]))
    throw std::invalid_argument("the knots in " + direction + " span an empty domain");
}

/// The degree + 1 basis functions that do not vanish on the span, and their derivatives (Piegl, Tiller, A2.2
/// and A2.3).
struct Basis {
  std::array<double, 10> value{}, slope{};
};

Basis basisFunctions(const std::vector<double>& knots, int degree, int span, double u) {
  const auto values = [&](int p) {  // all functions of degree p on the span, in value[0..p]
    std::array<double, 10> N{};
    N[0] = 1.0;
    for (int k = 1; k <= p; ++k) {
      double carried = 0.0;
      for (int r = 0; r < k; ++r) {
        const double right = knots[span + r + 1] - u, left = u - knots[span + 1 - k + r];
        const double term = N[r] / (right + left);
        N[r] = carried + right * term;
        carried = left * term;
      }
      N[k] = carried;
    }
    return N;
  };
  Basis basis{.value = values(degree)};
  const std::array<double, 10> lower = values(degree - 1);
  for (int k = 0; k <= degree;
       ++k) {  // N' = p (N_{i,p-1} / (u_{i+p} - u_i) - N_{i+1,p-1} / (u_{i+p+1} - u_{i+1}))
    const int i = span - degree + k;
    const double before = knots[i + degree] - knots[i], after = knots[i + degree + 1] - knots[i + 1];
    if (k > 0 && before > 0.0) basis.slope[k] += degree * lower[k - 1] / before;
    if (k < degree && after > 0.0) basis.slope[k] -= degree * lower[k] / after;
  }
  return basis;
}

}  // namespace

void validate(const NurbsSurface& surface) {
  validateKnots(surface.knotsU, surface.degreeU, surface.countU, "u");
  validateKnots(surface.knotsV, surface.degreeV, surface.countV, "v");
  const std::size_t expected = static_cast<std::size_t>(surface.countU) * surface.countV;
  if (surface.points.size() != expected || surface.weights.size() != expected)
    throw std::invalid_argument(std::to_string(surface.points.size()) + " control points and " +
                                std::to_string(surface.weights.size()) + " weights, expected " +
                                std::to_string(expected));
  for (std::size_t i = 0; i < expected; ++i) {
    if (!surface.points[i].allFinite())
      throw std::invalid_argument("control point " + std::to_string(i) + " is not finite");
    if (!(surface.weights[i] > 0.0) || !std::isfinite(surface.weights[i]))
      throw std::invalid_argument("weight " + std::to_string(i) + " is " +
                                  std::to_string(surface.weights[i]) + ", it must be positive");
  }
}

NurbsSurface closedTube(const std::vector<TubeRing>& rings) {
  if (rings.size() < 2) throw std::invalid_argument("a closed tube needs at least two rings");
  NurbsSurface s{.degreeU = 3,
                 .degreeV = 2,
                 .countU = static_cast<int>(rings.size()) + 2,
                 .countV = 9,
                 .knotsU = {},
                 .knotsV = {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4},
                 .points = {},
                 .weights = {}};
  const int spans = s.countU - s.degreeU;
  for (int i = 0; i < s.countU + s.degreeU + 1; ++i) s.knotsU.push_back(std::clamp(i - s.degreeU, 0, spans));
  const auto addRing = [&](const TubeRing& ring, double scale) {
    constexpr double across[] = {
        1, 1, 0, -1, -1, -1, 0, 1, 1};  // corners of the square around the circle, and its sides' middles
    for (int j = 0; j < 9; ++j) {
      // v runs clockwise seen from the far end, so that du x dv points outwards
      s.points.push_back(ring.centre +
                         scale * (across[j] * ring.halfAxisA - across[(j + 6) % 8] * ring.halfAxisB));
      s.weights.push_back(j % 2 ? std::sqrt(0.5) : 1.0);
    }
  };
  addRing(rings.front(), 0.0);
  for (const TubeRing& ring : rings) addRing(ring, 1.0);
  addRing(rings.back(), 0.0);
  return s;
}

int knotSpan(const std::vector<double>& knots, int degree, int count, double u) {
  if (u >= knots[count]) {  // the last span that is not empty
    int span = count - 1;
    while (knots[span] >= knots[count]) --span;
    return span;
  }
  return static_cast<int>(std::upper_bound(knots.begin() + degree, knots.begin() + count, u) -
                          knots.begin()) -
         1;
}

NurbsPoint evaluate(const NurbsSurface& s, double u, double v) {
  u = std::clamp(u, s.lowerU(), s.upperU());
  v = std::clamp(v, s.lowerV(), s.upperV());
  const int spanU = knotSpan(s.knotsU, s.degreeU, s.countU, u),
            spanV = knotSpan(s.knotsV, s.degreeV, s.countV, v);
  const Basis bu = basisFunctions(s.knotsU, s.degreeU, spanU, u),
              bv = basisFunctions(s.knotsV, s.degreeV, spanV, v);
  Vector4d A = Vector4d::Zero(), Au = Vector4d::Zero(), Av = Vector4d::Zero();  // homogeneous: (w P, w)
  for (int i = 0; i <= s.degreeU; ++i)
    for (int j = 0; j <= s.degreeV; ++j) {
      const std::size_t at =
          static_cast<std::size_t>(spanU - s.degreeU + i) * s.countV + (spanV - s.degreeV + j);
      Vector4d P;
      P << s.weights[at] * s.points[at], s.weights[at];
      A += bu.value[i] * bv.value[j] * P;
      Au += bu.slope[i] * bv.value[j] * P;
      Av += bu.value[i] * bv.slope[j] * P;
    }
  const Vector3d position = A.head<3>() / A.w();
  return {position, (Au.head<3>() - Au.w() * position) / A.w(), (Av.head<3>() - Av.w() * position) / A.w()};
}

Mesh tessellate(const NurbsSurface& surface, int stepsU, int stepsV) {
  if (stepsU < 1 || stepsV < 1)
    throw std::invalid_argument("a tessellation needs at least one step in each direction");
  validate(surface);
  Mesh mesh;
  std::vector<int> vertex((stepsU + 1) * (stepsV + 1));
  double size = 0.0;
  for (const Vector3d& p : surface.points) size = std::max(size, (p - surface.points[0]).norm());
  const double cell = std::max(1e-9 * size, 1e-300);  // closer than this is the same point

  std::unordered_map<std::string, int> known;
  const auto key = [&](const Vector3d& p) {
    const Eigen::Matrix<long long, 3, 1> k = (p / cell).array().round().cast<long long>();
    return std::string(reinterpret_cast<const char*>(k.data()), sizeof k);
  };
  for (int i = 0; i <= stepsU; ++i)
    for (int j = 0; j <= stepsV; ++j) {
      const double u = surface.lowerU() + (surface.upperU() - surface.lowerU()) * i / stepsU;
      const double v = surface.lowerV() + (surface.upperV() - surface.lowerV()) * j / stepsV;
      const NurbsPoint at = evaluate(surface, u, v);
      const auto [entry, isNew] =
          known.try_emplace(key(at.position), static_cast<int>(mesh.positions.size()));
      vertex[i * (stepsV + 1) + j] = entry->second;
      const Vector3d normal = at.du.cross(at.dv);
      if (isNew) {
        mesh.positions.push_back(at.position);
        mesh.normals.push_back(Vector3d::Zero());
      }
      if (normal.norm() > 0.0) mesh.normals[entry->second] += normal.normalized();
    }
  for (int i = 0; i < stepsU; ++i)
    for (int j = 0; j < stepsV; ++j) {
      const int a = vertex[i * (stepsV + 1) + j], b = vertex[(i + 1) * (stepsV + 1) + j];
      const int c = vertex[(i + 1) * (stepsV + 1) + j + 1], d = vertex[i * (stepsV + 1) + j + 1];
      if (a != b && b != c && a != c) mesh.triangles.push_back({a, b, c});
      if (a != c && c != d && a != d) mesh.triangles.push_back({a, c, d});
    }
  Mesh byFaces = mesh;
  computeNormals(byFaces);
  for (std::size_t i = 0; i < mesh.normals.size(); ++i)  // at a pole the surface has no normal of its own
    mesh.normals[i] =
        mesh.normals[i].norm() > 0.5 ? Vector3d(mesh.normals[i].normalized()) : byFaces.normals[i];
  return mesh;
}

}  // namespace gelenk
