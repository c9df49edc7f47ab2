#include "skinning/bodies/robot_body.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "kinematics/forward_kinematics.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

enum Paint { Shell, Housing, Accent, paints };
constexpr int sides = 40;

/// What was made so far, triangles by paint.
struct Workshop {
  std::vector<Vector3d> positions, normals;
  std::vector<Influences> influences;
  std::vector<std::array<int, 3>> triangles[paints];

  /// A surface of revolution about the line from `from` along the unit vector `axis`. profile: (along,
  /// radius) from one pole to the other, radius 0 at both; edges of more than 30 degrees stay sharp.
  void revolve(int joint, Paint paint, const Vector3d& from, const Vector3d& axis,
               const std::vector<std::pair<double, double>>& profile) {
    const Vector3d u = axis.unitOrthogonal(), v = axis.cross(u);
    const auto slope = [&](std::size_t k) {  // outward normal of the profile's edge k: (along, radial)
      return Eigen::Vector2d(profile[k].second - profile[k + 1].second,
                             profile[k + 1].first - profile[k].first)
          .normalized();
    };
    const auto ring = [&](std::size_t k, const Eigen::Vector2d& normal) {  // its first vertex
      const int first = static_cast<int>(positions.size());
      for (int s = 0; s < sides; ++s) {
        const double t = 2.0 * M_PI * s / sides;
        const Vector3d out = std::cos(t) * u + std::sin(t) * v;
        positions.push_back(from + profile[k].first * axis + profile[k].second * out);
        normals.push_back((normal.x() * axis + normal.y() * out).normalized());
        influences.push_back({{joint, 0, 0, 0}, {1.0, 0.0, 0.0, 0.0}});
      }
      return first;
    };
    const std::size_t edges = profile.size() - 1;
    int lower = ring(0, slope(0));
    for (std::size_t k = 0; k < edges; ++k) {
      const bool isSmooth = k + 1 < edges && slope(k + 1).dot(slope(k)) > 0.86;
      const int upper = ring(k + 1, isSmooth ? (slope(k + 1) + slope(k)).normalized() : slope(k));
      for (int s = 0; s < sides; ++s) {
        const int next = (s + 1) % sides;
        if (profile[k].second > 0.0) triangles[paint].push_back({lower + s, lower + next, upper + s});
        if (profile[k + 1].second > 0.0) triangles[paint].push_back({lower + next, upper + next, upper + s});
      }
      lower = isSmooth || k + 1 == edges ? upper : ring(k + 1, slope(k + 1));
    }
  }

  /// A cylinder with bevelled rims.
  void drum(int joint, Paint paint, const Vector3d& centre, const Vector3d& axis, double radius,
            double half) {
    const double bevel = std::min(0.16 * radius, 0.5 * half);
    revolve(joint, paint, centre, axis,
            {{-half, 0.0},
             {-half, radius - bevel},
             {-half + 0.3 * bevel, radius - 0.3 * bevel},
             {-half + bevel, radius},
             {half - bevel, radius},
             {half - 0.3 * bevel, radius - 0.3 * bevel},
             {half, radius - bevel},
             {half, 0.0}});
  }

  /// A tapering rod with round ends.
  void rod(int joint, Paint paint, const Vector3d& from, const Vector3d& to, double r0, double r1) {
    const double length = (to - from).norm();
    if (!(length > 0.0)) return;
    std::vector<std::pair<double, double>> profile;
    constexpr int steps = 8;
    for (int k = 0; k <= steps; ++k) {
      const double t = 0.5 * M_PI * k / steps;
      profile.emplace_back(-r0 * std::cos(t), k == 0 ? 0.0 : r0 * std::sin(t));
    }
    for (int k = 0; k <= steps; ++k) {
      const double t = 0.5 * M_PI * k / steps;
      profile.emplace_back(length + r1 * std::sin(t), k == steps ? 0.0 : r1 * std::cos(t));
    }
    revolve(joint, paint, from, (to - from) / length, profile);
  }
};

/// Where consecutive joints lie.
struct Place {
  Vector3d at;
  int first, last;  ///< joints
  double along;     ///< length of the chain up to here
};

std::vector<Place> placesOf(const Skeleton& skeleton, const Frames& rest) {
  std::vector<Place> places;
  double size = 0.0;
  for (int j = 0; j < skeleton.jointCount(); ++j) {
    if (skeleton.children(j).size() > 1)
      throw std::invalid_argument("joint '" + skeleton.joint(j).name + "' has several children: no chain");
    if (j > 0) size += (rest[j].translation() - rest[j - 1].translation()).norm();
  }
  if (!(size > 0.0)) throw std::invalid_argument("all joints lie in one place: there is nothing to build on");
  double along = 0.0;
  for (int j = 0; j < skeleton.jointCount(); ++j) {
    const Vector3d at = rest[j].translation();
    const double step = places.empty() ? 1.0 : (at - places.back().at).norm();
    if (step > 1e-6 * size) {
      along += places.empty() ? 0.0 : step;
      places.push_back({at, j, j, along});
    }
    places.back().last = j;
  }
  return places;
}

}  // namespace

RobotFigures robotFigures(std::string_view name) {
  if (name == "ur5")
    return {.shoulder = 0.052,
            .wrist = 0.036,
            .shell = {0.74f, 0.76f, 0.78f},
            .housing = {0.30f, 0.32f, 0.35f},
            .accent = {0.36f, 0.62f, 0.80f}};
  if (name == "panda")
    return {.shoulder = 0.060,
            .wrist = 0.042,
            .shell = {0.93f, 0.93f, 0.92f},
            .housing = {0.28f, 0.29f, 0.31f},
            .accent = {0.24f, 0.55f, 0.50f}};
  if (name == "iiwa14")
    return {.shoulder = 0.062,
            .wrist = 0.046,
            .shell = {0.80f, 0.81f, 0.82f},
            .housing = {0.42f, 0.44f, 0.46f},
            .accent = {0.95f, 0.47f, 0.10f}};
  if (name == "puma560")
    return {.shoulder = 0.056,
            .wrist = 0.030,
            .shell = {0.88f, 0.85f, 0.76f},
            .housing = {0.33f, 0.33f, 0.34f},
            .accent = {0.66f, 0.22f, 0.18f}};
  if (name == "scara")
    return {.shoulder = 0.058,
            .wrist = 0.036,
            .shell = {0.90f, 0.90f, 0.88f},
            .housing = {0.34f, 0.36f, 0.39f},
            .accent = {0.80f, 0.62f, 0.14f}};
  return {};
}

RobotBody robotBody(const Skeleton& skeleton, const RobotFigures& figures) {
  const Frames rest = restFrames(skeleton);
  const std::vector<Place> places = placesOf(skeleton, rest);
  const double length = places.back().along;
  const auto radiusAt = [&](double along) {
    const double t = length > 0.0 ? along / length : 0.0;
    return length * (figures.shoulder + t * (figures.wrist - figures.shoulder));
  };
  const auto axisOf = [&](int joint) -> Vector3d {
    return rest[joint].linear() * skeleton.joint(joint).axes[0].axis;
  };
  const auto moves = [&](int joint, AxisDof::Kind kind) {
    return !skeleton.joint(joint).axes.empty() && skeleton.joint(joint).axes[0].kind == kind;
  };
  const auto turns = [&](int joint) { return moves(joint, AxisDof::Kind::Rotation); };
  const auto slides = [&](int joint) { return moves(joint, AxisDof::Kind::Translation); };
  constexpr double parallel = 0.99;
  Workshop shop;

  // Links: shells, parted by a ring where they turn about themselves.
  for (std::size_t k = 0; k + 1 < places.size(); ++k) {
    Place a = places[k], b = places[k + 1];
    const Vector3d way = (b.at - a.at).normalized();
    const double span = (b.at - a.at).norm(), r0 = radiusAt(a.along), r1 = radiusAt(b.along);
    const bool lastLink = k + 2 == places.size();
    const double ra = lastLink ? r1 : r0, rb = lastLink ? 0.86 * r1 : r1;
    if (slides(b.first) && std::abs(axisOf(b.first).dot(way)) > parallel) continue;  // a column, below
    int lower = a.last, upper = a.last;
    bool rolls = false;
    if (turns(b.first) && std::abs(axisOf(b.first).dot(way)) > parallel && b.last > b.first) {
      upper = b.first;
      rolls = true;
    } else if (turns(a.last) && a.last > a.first && std::abs(axisOf(a.last).dot(way)) > parallel) {
      lower = a.last - 1;
      rolls = true;
    }
    // Round ends stay above the ground and behind the flange.
    if (k == 0) a.at += std::min(ra, 0.5 * span) * way;
    if (lastLink) b.at -= std::min(rb, 0.5 * span) * way;
    const bool isShort = span < 1.2 * (ra + rb);
    if (!rolls || isShort) {
      shop.rod(rolls ? upper : lower, Shell, a.at, b.at, ra, rb);
    } else {
      const double middle = upper == b.first ? 0.56 : 0.44;
      const Vector3d at = a.at + middle * (b.at - a.at);
      const double r = ra + middle * (rb - ra), gap = 0.16 * r;
      shop.rod(lower, Shell, a.at, at - gap * way, ra, 0.98 * r);
      shop.rod(upper, Shell, at + gap * way, b.at, 0.98 * r, rb);
      shop.drum(lower, Housing, at - 0.34 * r * way, way, 1.10 * r, 0.30 * r);
      shop.drum(upper, Accent, at + 0.07 * r * way, way, 1.06 * r, 0.13 * r);
      shop.drum(upper, Housing, at + 0.44 * r * way, way, 1.10 * r, 0.26 * r);
    }
  }

  // Hinges: a drum across the links with a cap at each end.
  for (std::size_t k = 0; k < places.size(); ++k) {
    const double r = radiusAt(places[k].along);
    for (int joint = places[k].first; joint <= places[k].last; ++joint) {
      if (!turns(joint)) continue;
      const Vector3d axis = axisOf(joint);
      const auto along = [&](std::size_t from, std::size_t to) {
        return std::abs(axis.dot((places[to].at - places[from].at).normalized())) > parallel;
      };
      const bool rollsIn = k > 0 && along(k - 1, k), rollsOut = k + 1 < places.size() && along(k, k + 1);
      if (k == 0 || (k + 1 == places.size() && joint == places[k].last)) continue;
      if ((rollsIn || rollsOut) && places[k].last > places[k].first) continue;  // a ring of the link
      const double half = rollsIn || rollsOut ? 0.9 * r : 1.28 * r;
      shop.drum(joint, Housing, places[k].at, axis, 1.14 * r, half);
      for (const double side : {-1.0, 1.0}) {
        shop.drum(joint, Accent, places[k].at + side * half * axis, axis, 0.86 * r, 0.10 * r);
        shop.drum(joint, Housing, places[k].at + side * (half + 0.07 * r) * axis, axis, 0.58 * r, 0.10 * r);
      }
    }
  }

  // Slides: a column that runs through its guide.
  for (int joint = 0; joint < skeleton.jointCount(); ++joint) {
    if (!slides(joint)) continue;
    const AxisDof& dof = skeleton.joint(joint).axes[0];
    const Vector3d axis = axisOf(joint), at = rest[joint].translation();
    double along = 0.0;
    for (const Place& place : places)
      if (place.first <= joint) along = place.along;
    const double r = radiusAt(along), q = skeleton.rest()[skeleton.qIndex(joint)];
    const double stroke = std::isfinite(dof.upper - dof.lower) ? dof.upper - dof.lower : 0.3 * length;
    const double top = std::isfinite(dof.upper) ? dof.upper : 0.3 * length;
    const Vector3d zero = at - q * axis;  // where the guide lies
    shop.drum(std::max(0, skeleton.joint(joint).parent), Housing, zero, axis, 1.06 * r,
              std::max(1.5 * r, 0.22 * stroke));
    shop.drum(std::max(0, skeleton.joint(joint).parent), Accent, zero, axis, 1.10 * r, 0.16 * r);
    shop.rod(joint, Shell, at - (top + 1.2 * r) * axis, at + 1.2 * r * axis, 0.42 * r, 0.42 * r);
    shop.drum(joint, Housing, at - (top + 1.2 * r) * axis, axis, 0.60 * r, 0.20 * r);
  }

  // Plinth and flange.
  const Place &foot = places.front(), &second = places[std::min<std::size_t>(1, places.size() - 1)];
  const Vector3d up = (second.at - foot.at).normalized();
  const double r = radiusAt(0.0);
  shop.drum(0, Housing, foot.at + 0.12 * r * up, up, 1.65 * r, 0.12 * r);
  shop.drum(0, Shell, foot.at + 0.50 * r * up, up, 1.28 * r, 0.34 * r);
  shop.drum(0, Accent, foot.at + 0.86 * r * up, up, 1.22 * r, 0.07 * r);
  const Place& tool = places.back();
  const Vector3d out = (tool.at - places[places.size() - 2].at).normalized();
  const double rt = radiusAt(length);
  shop.drum(tool.last, Accent, tool.at - 0.52 * rt * out, out, 0.94 * rt, 0.12 * rt);
  shop.drum(tool.last, Housing, tool.at - 0.20 * rt * out, out, 0.98 * rt, 0.24 * rt);
  shop.drum(tool.last, Housing, tool.at + 0.10 * rt * out, out, 0.45 * rt, 0.14 * rt);

  RobotBody body;
  Mesh mesh{.positions = std::move(shop.positions), .triangles = {}, .normals = std::move(shop.normals)};
  const Eigen::Vector3f colours[paints] = {figures.shell, figures.housing, figures.accent};
  const char* names[paints] = {"shell", "housing", "accent"};
  const float gloss[paints] = {0.35f, 0.6f, 0.45f};
  for (int paint = 0; paint < paints; ++paint) {
    Material material{.name = names[paint], .doubleSided = false, .gloss = gloss[paint]};
    material.colour.head<3>() = linearFromSrgb(colours[paint]);
    body.look.materials.push_back(material);
    body.look.parts.push_back({.name = names[paint],
                               .firstTriangle = static_cast<int>(mesh.triangles.size()),
                               .triangleCount = static_cast<int>(shop.triangles[paint].size()),
                               .material = paint});
    mesh.triangles.insert(mesh.triangles.end(), shop.triangles[paint].begin(), shop.triangles[paint].end());
  }
  body.skin = bindSkin(std::move(mesh), rest, std::move(shop.influences));
  return body;
}

Material linkMaterial(const Eigen::Vector4d& rgba) {
  Material material{.name = "link", .gloss = 0.25f};
  material.colour << linearFromSrgb(Eigen::Vector3f(rgba.head<3>().cast<float>())),
      static_cast<float>(rgba.w());
  return material;
}

}  // namespace gelenk
