#include "skinning/bodies/body_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

namespace gelenk {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr int columns = 11;       // u, v, radius, then cosine and sine of n = 2..5
constexpr double widening = 1.5;  // of a blend's radius: where both agree it fills a quarter of the radius
constexpr double far = 1e9;       // value of a part that is too far away to matter
constexpr int maxParts = 2048;    // of one region, so that evaluation needs no heap

std::array<double, columns> columnsOf(const Section& s) {
  return {s.u,       s.v,         s.radius,  s.cosine[0], s.sine[0], s.cosine[1],
          s.sine[1], s.cosine[2], s.sine[2], s.cosine[3], s.sine[3]};
}

/// min(a, b) rounded over the width k where both are near.
template <bool withGradient>
FieldSample smoothMin(const FieldSample& a, const FieldSample& b, double k,
                      const Vector3d* kGradient = nullptr) {
  const bool aFirst = a.value <= b.value;
  const FieldSample &low = aFirst ? a : b, &high = aFirst ? b : a;
  const double wide = widening * k, overlap = wide - (high.value - low.value);
  if (!(overlap > 0.0)) return low;
  const double h = overlap / wide, share = 0.5 * h * h;
  FieldSample out{low.value - wide * h * h * h / 6.0, Vector3d::Zero()};
  if constexpr (withGradient) {
    out.gradient = (1.0 - share) * low.gradient + share * high.gradient;
    if (kGradient) out.gradient -= widening * (share - h * h * h / 3.0) * *kGradient;
  }
  return out;
}

/// As std::hypot but for lengths whose squares are none.
double lengthOf(double a, double b) { return std::sqrt(a * a + b * b); }

template <bool withGradient>
FieldSample opposite(FieldSample s) {
  s.value = -s.value;
  if constexpr (withGradient) s.gradient = -s.gradient;
  return s;
}

}  // namespace

struct BodyShape::Prepared {
  Matrix3d axes;  // rows u, v, axis: local = axes (p - a)
  double length = 1.0;
  double bound = 0.0;           // radius of a capsule around the axis (with caps) that holds the part
  double from = 0.0, to = 0.0;  // ends of that capsule's axis, metres from a
  std::vector<double> at;       // section positions, metres from a
  std::vector<std::array<std::array<double, 4>, columns>>
      cubic;          // one a gap between sections, in the fraction of the gap
  int harmonics = 0;  // highest n that occurs

  template <bool withGradient>
  FieldSample cylinder(const BodyPart& part, const Vector3d& p) const;
  template <bool withGradient>
  FieldSample roundCone(const BodyPart& part, const Vector3d& p) const;
  template <bool withGradient>
  FieldSample sample(const BodyPart& part, Vector3d p) const {
    if (part.mirrored) p.x() = -p.x();
    FieldSample s = part.form == BodyPart::Form::RoundCone ? roundCone<withGradient>(part, p)
                                                           : cylinder<withGradient>(part, p);
    if (withGradient && part.mirrored) s.gradient.x() = -s.gradient.x();
    return s;
  }
  /// Distance from the capsule that holds the part.
  double outside(const BodyPart& part, Vector3d p) const {
    if (part.mirrored) p.x() = -p.x();
    const Vector3d local = axes * (p - part.a);
    const double beyond = std::max({from - local.z(), local.z() - to, 0.0});
    return std::sqrt(local.x() * local.x() + local.y() * local.y() + beyond * beyond) - bound;
  }
};

/// F = (sqrt(g^2 + e^2) - 1) R with g = rho / R(theta, s) and e the distance beyond the end section over the
/// cap's length.
template <bool withGradient>
FieldSample BodyShape::Prepared::cylinder(const BodyPart& part, const Vector3d& p) const {
  const Vector3d local = axes * (p - part.a);
  const double s = std::clamp(local.z(), at.front(), at.back());
  std::size_t gap = 0;
  while (gap + 2 < at.size() && s > at[gap + 1]) ++gap;
  const double width = at[gap + 1] - at[gap], x = (s - at[gap]) / width;
  const bool onSide = local.z() == s;

  std::array<double, columns> value, slope;  // slope: per metre along the axis
  const int used = harmonics > 1 ? 2 * harmonics + 1 : 3;
  for (int c = 0; c < used; ++c) {
    const auto& k = cubic[gap][c];
    value[c] = k[0] + x * (k[1] + x * (k[2] + x * k[3]));
    slope[c] = onSide ? (k[1] + x * (2.0 * k[2] + x * 3.0 * k[3])) / width : 0.0;
  }

  const double du = local.x() - value[0], dv = local.y() - value[1];
  const double rho = std::max(lengthOf(du, dv), 1e-9 * length);
  const double cosine = dv / rho, sine = du / rho;
  double S = 0.0, S_theta = 0.0, S_s = 0.0;
  double cn = cosine, sn = sine;  // cos(n theta), sin(n theta)
  for (int n = 2; n <= harmonics; ++n) {
    const double next = cn * cosine - sn * sine;
    sn = sn * cosine + cn * sine;
    cn = next;
    const int c = 2 * n - 1;
    S += value[c] * cn + value[c + 1] * sn;
    S_theta += n * (value[c + 1] * cn - value[c] * sn);
    S_s += slope[c] * cn + slope[c + 1] * sn;
  }
  const bool polar = part.form == BodyPart::Form::Polar;
  const double least = polar ? -0.85 : -0.94;
  if (S < least) S = least, S_theta = 0.0, S_s = 0.0;
  const double w = 1.0 + S, r0 = value[2];
  const double R = polar ? r0 * w : r0 / std::sqrt(w);
  const double R_S = polar ? r0 : -0.5 * R / w;  // dR / dS
  const double R_theta = R_S * S_theta, R_s = R_S * S_s + slope[2] * R / r0;

  const double cap = local.z() < s ? part.capA : part.capB;
  const double e = onSide ? 0.0 : std::abs(local.z() - s) / cap;
  const double g = rho / R, G = std::max(std::sqrt(g * g + e * e), 1e-12);
  const double side = onSide ? 1.0 : g / G, tip = onSide ? 0.0 : e * R / (G * cap);
  const double slopeSquared = side * side * (1.0 + (R_theta * R_theta) / (R * R) + R_s * R_s) + tip * tip;
  const double N = std::max(std::sqrt(slopeSquared), 0.3);

  FieldSample out{(G - 1.0) * R / N, Vector3d::Zero()};
  if constexpr (withGradient) {
    const double F_R = e * e / G - 1.0, F_theta = F_R * R_theta;
    double F_s = onSide ? F_R * R_s : (local.z() < s ? -tip : tip);
    F_s -= side * (slope[0] * sine + slope[1] * cosine);  // the centre moves along the axis
    F_s -= F_theta * (slope[0] * cosine - slope[1] * sine) / rho;
    const Vector3d gradient(side * sine + F_theta / rho * cosine, side * cosine - F_theta / rho * sine, F_s);
    out.gradient = axes.transpose() * gradient / N;
  }
  return out;
}

template <bool withGradient>
FieldSample BodyShape::Prepared::roundCone(const BodyPart& part, const Vector3d& p) const {
  const double stretch = 1.0 / part.flatness - 1.0;
  const Vector3d fromA = p - part.a;
  const Vector3d local = axes * (fromA + stretch * part.flat.dot(fromA) * part.flat);
  const double rho = lengthOf(local.x(), local.y()), z = local.z();
  const double sine = std::clamp((part.radiusA - part.radiusB) / length, -1.0, 1.0),
               cosine = std::sqrt(1.0 - sine * sine);
  // Which of the three pieces is nearest: the two balls, or the cone that touches both.
  const double along = cosine * z - sine * rho;
  double value, radial, axial;
  if (along <= 0.0 || sine == 1.0) {
    const double d = std::max(lengthOf(rho, z), 1e-12 * length);
    value = d - part.radiusA, radial = rho / d, axial = z / d;
  } else if (along >= cosine * length || sine == -1.0) {
    const double d = std::max(lengthOf(rho, z - length), 1e-12 * length);
    value = d - part.radiusB, radial = rho / d, axial = (z - length) / d;
  } else {
    value = cosine * rho + sine * z - part.radiusA, radial = cosine, axial = sine;
  }
  const double inverse = rho > 0.0 ? radial / rho : 0.0;
  Vector3d gradient = axes.transpose() * Vector3d(inverse * local.x(), inverse * local.y(), axial);
  gradient += stretch * part.flat.dot(gradient) * part.flat;
  const double N = std::max(gradient.norm(), 1e-6);
  return {value / N, gradient / N};
}

namespace {

void check(const BodyPart& part, int index) {
  const auto reject = [&](const char* why) {
    throw std::invalid_argument("part " + std::to_string(index) + " of a body: " + why);
  };
  if (part.parent >= index || (part.parent < 0) != (index == 0)) reject("its parent does not come before it");
  if (!part.a.allFinite() || !part.b.allFinite()) reject("an end that is not finite");
  if (part.form == BodyPart::Form::RoundCone) {
    if (!(part.radiusA > 0.0 && part.radiusB > 0.0 && part.flatness > 0.0))
      reject("a radius that is not positive");
    return;
  }
  if (part.sections.size() < 2) reject("fewer than two sections");
  if (!(part.capA > 0.0 && part.capB > 0.0) || part.a == part.b) reject("a cap or an axis without length");
  for (std::size_t k = 0; k < part.sections.size(); ++k) {
    if (!(part.sections[k].radius > 0.0)) reject("a radius that is not positive");
    if (k > 0 && !(part.sections[k].at > part.sections[k - 1].at)) reject("sections that do not ascend");
  }
}

}  // namespace

BodyShape::BodyShape(std::vector<BodyPart> parts) : parts_(std::move(parts)) {
  if (parts_.empty()) throw std::invalid_argument("a body needs at least one part");
  std::vector<Prepared> allReady;
  reach_.resize(parts_.size(), 0.0);
  for (int i = 0; i < static_cast<int>(parts_.size()); ++i) {
    const BodyPart& part = parts_[i];
    check(part, i);
    Prepared ready;
    const Vector3d axis = part.b - part.a;
    ready.length = axis.norm();
    const bool cone = part.form == BodyPart::Form::RoundCone;
    Vector3d z = ready.length > 0.0 ? Vector3d(axis / ready.length) : Vector3d::UnitZ();
    if (ready.length == 0.0) ready.length = 1e-9 * part.radiusA;
    Vector3d v =
        cone ? z.unitOrthogonal() : Vector3d((part.sectionUp - part.sectionUp.dot(z) * z).normalized());
    ready.axes << z.cross(v).transpose(), v.transpose(), z.transpose();
    if (cone) {
      ready.bound = std::max(part.radiusA, part.radiusB) * std::max(1.0, part.flatness);
      ready.to = ready.length;
    } else {
      for (const Section& section : part.sections) {
        ready.at.push_back(section.at * ready.length);
        double swing = 0.0;
        for (int n = 0; n < 4; ++n) {
          swing += std::hypot(section.cosine[n], section.sine[n]);
          if (section.cosine[n] != 0.0 || section.sine[n] != 0.0)
            ready.harmonics = std::max(ready.harmonics, n + 2);
        }
        const double grow =
            part.form == BodyPart::Form::Polar ? 1.0 + swing : 1.0 / std::sqrt(std::max(1.0 - swing, 0.06));
        ready.bound = std::max(ready.bound, std::hypot(section.u, section.v) + section.radius * grow);
      }
      ready.from = ready.at.front() - part.capA;
      ready.to = ready.at.back() + part.capB;
      ready.bound *= 1.05;  // the cubics overshoot a little
      const std::size_t count = part.sections.size();
      std::vector<std::array<double, columns>> value, tangent(count, std::array<double, columns>{});
      for (const Section& section : part.sections) value.push_back(columnsOf(section));
      // The cubic spline whose ends are level: its curvature has no steps, which would show as bands of
      // light.
      std::vector<double> pivot(count, 1.0);
      for (std::size_t k = 1; k + 1 < count; ++k) {
        const double before = 1.0 / (ready.at[k] - ready.at[k - 1]),
                     after = 1.0 / (ready.at[k + 1] - ready.at[k]);
        const double factor = k > 1 ? before / pivot[k - 1] : 0.0;
        pivot[k] = 2.0 * (before + after) - factor * (k > 1 ? before : 0.0);
        for (int c = 0; c < columns; ++c)
          tangent[k][c] = 3.0 * (before * before * (value[k][c] - value[k - 1][c]) +
                                 after * after * (value[k + 1][c] - value[k][c])) -
                          factor * tangent[k - 1][c];
      }
      for (std::size_t k = count - 1; k-- > 1;)
        for (int c = 0; c < columns; ++c)
          tangent[k][c] = (tangent[k][c] - tangent[k + 1][c] / (ready.at[k + 1] - ready.at[k])) / pivot[k];
      for (std::size_t k = 0; k + 1 < count; ++k) {
        const double width = ready.at[k + 1] - ready.at[k];
        ready.cubic.emplace_back();
        for (int c = 0; c < columns; ++c) {
          const double y0 = value[k][c], y1 = value[k + 1][c], m0 = tangent[k][c] * width,
                       m1 = tangent[k + 1][c] * width;
          ready.cubic.back()[c] = {y0, m0, 3.0 * (y1 - y0) - 2.0 * m0 - m1, 2.0 * (y0 - y1) + m0 + m1};
        }
      }
    }
    for (const double along : {ready.from, ready.to}) {
      Vector3d end = part.a + along * z;
      if (part.mirrored) end.x() = -end.x();
      bounds_.extend(Vector3d(end.array() - ready.bound));
      bounds_.extend(Vector3d(end.array() + ready.bound));
    }
    allReady.push_back(std::move(ready));
    for (const int j : {i, part.parent})
      if (j >= 0) reach_[j] = std::max(reach_[j], 1.3 * widening * std::max(part.blend, part.siblingBlend));
  }
  prepared_ = std::make_shared<const std::vector<Prepared>>(std::move(allReady));
}

BodyShape::Region BodyShape::regionOf(const std::vector<char>& evaluated) const {
  std::vector<char> listed = evaluated;
  for (int i = static_cast<int>(parts_.size()) - 1; i > 0; --i)
    if (listed[i]) listed[parts_[i].parent] = true;
  listed[0] = true;

  Region region;
  std::vector<int> nodeOf(parts_.size(), -1);
  for (int i = 0; i < static_cast<int>(parts_.size()); ++i) {
    if (!listed[i]) continue;
    nodeOf[i] = static_cast<int>(region.nodes_.size());
    region.nodes_.push_back({i, evaluated[i] != 0, 0, 0});
  }
  if (region.nodes_.size() > maxParts)
    throw std::invalid_argument("a body with more than 2048 parts in one place");
  for (std::size_t n = 1; n < region.nodes_.size(); ++n)
    ++region.nodes_[nodeOf[parts_[region.nodes_[n].part].parent]].childCount;
  int next = 0;
  for (Region::Node& node : region.nodes_) {
    node.firstChild = next;
    next += node.childCount;
    node.childCount = 0;
  }
  region.children_.resize(next);
  for (int n = 1; n < static_cast<int>(region.nodes_.size()); ++n) {
    Region::Node& parent = region.nodes_[nodeOf[parts_[region.nodes_[n].part].parent]];
    region.children_[parent.firstChild + parent.childCount++] = n;
  }
  return region;
}

BodyShape::Region BodyShape::region(const Vector3d& centre, double radius) const {
  std::vector<char> evaluated(parts_.size(), false);
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const double near = reach_[i] + 1.6 * radius;  // parts' values grow by at most 1.6 a metre
    if ((*prepared_)[i].outside(parts_[i], centre) > 1.6 * near) continue;
    evaluated[i] = (*prepared_)[i].sample<false>(parts_[i], centre).value < near;
  }
  return regionOf(evaluated);
}

BodyShape::Region BodyShape::everywhere() const { return regionOf(std::vector<char>(parts_.size(), true)); }

template <bool withGradient>
FieldSample BodyShape::evaluate(const Vector3d& p, const Region& region) const {
  std::array<FieldSample, maxParts> value;
  std::array<int, maxParts> order;
  for (int n = static_cast<int>(region.nodes_.size()) - 1; n >= 0; --n) {
    const Region::Node& node = region.nodes_[n];
    FieldSample own = node.evaluated ? (*prepared_)[node.part].sample<withGradient>(parts_[node.part], p)
                                     : FieldSample{far, Vector3d::Zero()};
    for (int k = 0; k < node.childCount; ++k) {
      const int child = region.children_[node.firstChild + k];
      if (const BodyPart& part = parts_[region.nodes_[child].part]; part.carved)
        own = opposite<withGradient>(
            smoothMin<withGradient>(opposite<withGradient>(own), value[child], part.blend));
    }
    int count = 0;
    for (int k = 0; k < node.childCount; ++k) {
      const int child = region.children_[node.firstChild + k];
      if (parts_[region.nodes_[child].part].carved) continue;
      value[child] = smoothMin<withGradient>(own, value[child], parts_[region.nodes_[child].part].blend);
      if (value[child].value < own.value) order[count++] = child;
    }
    std::sort(order.begin(), order.begin() + count,
              [&](int a, int b) { return value[a].value < value[b].value; });
    if (count == 0) {
      value[n] = own;
      continue;
    }
    FieldSample total = value[order[0]];
    const double first = parts_[region.nodes_[order[0]].part].siblingBlend;
    for (int k = 1; k < count; ++k) {
      const FieldSample& next = value[order[k]];
      const double fixed = std::min(first, parts_[region.nodes_[order[k]].part].siblingBlend);
      const double fading = 1.5 * (own.value - next.value);
      Vector3d fadingGradient;
      if constexpr (withGradient) fadingGradient = 1.5 * (own.gradient - next.gradient);
      total = smoothMin<withGradient>(total, next, std::min(fixed, fading),
                                      fading < fixed ? &fadingGradient : nullptr);
    }
    value[n] = total;
  }
  return value[0];
}

double BodyShape::value(const Vector3d& p, const Region& region) const {
  return evaluate<false>(p, region).value;
}
FieldSample BodyShape::sample(const Vector3d& p, const Region& region) const {
  return evaluate<true>(p, region);
}

}  // namespace gelenk
