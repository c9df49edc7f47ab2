#include "apps/web/packed_body.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <numeric>
#include <stdexcept>

#include "kinematics/forward_kinematics.h"
#include "kinematics/symmetry.h"
#include "skinning/blend/surface_slopes.h"

namespace gelenk {
namespace {

constexpr int steps = (1 << 18) - 1, weightSteps = 65535;

struct Head {
  std::uint32_t half = 0, triangles = 0;  ///< of one side; vertices on the plane belong to it
  double low[3] = {0.0, 0.0, 0.0}, step = 1.0;
};

/// Numbers one after the other, their lowest bytes first, then the next ones: these repeat themselves.
void putBytes(std::string& out, const std::vector<std::uint32_t>& values, int bytes) {
  for (int k = 0; k < bytes; ++k)
    for (const std::uint32_t value : values) out.push_back(static_cast<char>((value >> (8 * k)) & 255));
}
std::vector<std::uint32_t> takeBytes(std::string_view& from, std::size_t count, int bytes) {
  if (from.size() < count * bytes) throw std::runtime_error("a packed body is cut short");
  std::vector<std::uint32_t> values(count, 0);
  for (int k = 0; k < bytes; ++k, from.remove_prefix(count))
    for (std::size_t i = 0; i < count; ++i)
      values[i] |= static_cast<std::uint32_t>(static_cast<unsigned char>(from[i])) << (8 * k);
  return values;
}

/// Differences from one to the next, the sign in the lowest bit.
std::vector<std::uint32_t> differences(std::vector<std::int32_t> values) {
  std::vector<std::uint32_t> out;
  std::int32_t before = 0;
  for (const std::int32_t value : values) {
    const std::int32_t d = value - before;
    out.push_back(d < 0 ? 2u * static_cast<std::uint32_t>(-d) - 1u : 2u * static_cast<std::uint32_t>(d));
    before = value;
  }
  return out;
}
std::vector<std::int32_t> sums(const std::vector<std::uint32_t>& values) {
  std::vector<std::int32_t> out;
  std::int32_t sum = 0;
  for (const std::uint32_t value : values) {
    sum += value % 2 ? -static_cast<std::int32_t>(value / 2) - 1 : static_cast<std::int32_t>(value / 2);
    out.push_back(sum);
  }
  return out;
}

Eigen::Vector3d mirrored(const Eigen::Vector3d& p) { return {-p.x(), p.y(), p.z()}; }

/// How many vertices come first that are not on the right.
std::size_t leftHalf(const std::vector<Eigen::Vector3d>& places) {
  std::size_t half = 0;
  while (half < places.size() && places[half].x() >= 0.0) ++half;
  return half;
}

void putInfluences(std::string& out, const std::vector<Influences>& influences, std::size_t half) {
  for (int k = 0; k < 4; ++k) {
    std::vector<std::uint32_t> joints, weights;
    for (std::size_t v = 0; v < half; ++v) {
      joints.push_back(static_cast<std::uint32_t>(influences[v].joints[k]));
      weights.push_back(static_cast<std::uint32_t>(std::lround(influences[v].weights[k] * weightSteps)));
    }
    putBytes(out, joints, 2);
    if (k > 0) putBytes(out, weights, 2);
  }
}

std::vector<Influences> takeInfluences(std::string_view& packed, std::size_t half) {
  std::vector<Influences> influences(half);
  for (int k = 0; k < 4; ++k) {
    const auto joints = takeBytes(packed, half, 2);
    for (std::size_t v = 0; v < half; ++v) influences[v].joints[k] = static_cast<int>(joints[v]);
    if (k == 0) continue;
    const auto weights = takeBytes(packed, half, 2);
    for (std::size_t v = 0; v < half; ++v) {
      influences[v].weights[k] = static_cast<double>(weights[v]) / weightSteps;
      influences[v].weights[0] -= influences[v].weights[k];
    }
  }
  return influences;
}

/// Points of the left half after a fixed place each, in steps.
void putPoints(std::string& out, const std::vector<Eigen::Vector3d>& points,
               const std::function<Eigen::Vector3d(std::size_t)>& from, std::size_t half, double step) {
  for (int c = 0; c < 3; ++c) {
    std::vector<std::int32_t> column;
    for (std::size_t v = 0; v < half; ++v)
      column.push_back(static_cast<std::int32_t>(std::lround((points[v][c] - from(v)[c]) / step)));
    putBytes(out, differences(column), 3);
  }
}

std::vector<Eigen::Vector3d> takePoints(std::string_view& packed,
                                        const std::function<Eigen::Vector3d(std::size_t)>& from,
                                        std::size_t half, double step) {
  std::vector<Eigen::Vector3d> points(half);
  for (std::size_t v = 0; v < half; ++v) points[v] = from(v);
  for (int c = 0; c < 3; ++c) {
    const auto column = sums(takeBytes(packed, half, 3));
    for (std::size_t v = 0; v < half; ++v) points[v][c] += step * column[v];
  }
  return points;
}

/// The right half after the left one: for each of its vertices the one that it is the image of.
std::vector<std::size_t> rightHalf(const std::vector<Eigen::Vector3d>& places, std::size_t half) {
  std::vector<std::size_t> of;
  for (std::size_t v = 0; v < half; ++v)
    if (places[v].x() > 0.0) of.push_back(v);
  return of;
}

void mirrorInfluences(std::vector<Influences>& influences, const std::vector<std::size_t>& of,
                      const Skeleton& skeleton) {
  const std::vector<int> partners = mirrorPartners(skeleton);
  for (const std::size_t v : of) {
    Influences in = influences[v];
    for (int& joint : in.joints) joint = partners[joint];
    influences.push_back(in);
  }
}

}  // namespace

std::string packBody(const Skin& skin) {
  const auto& places = skin.mesh.positions;
  const auto& triangles = skin.mesh.triangles;
  const std::size_t half = leftHalf(places);
  const std::vector<std::size_t> right = rightHalf(places, half);
  bool symmetric = half + right.size() == places.size() && triangles.size() % 2 == 0;
  for (std::size_t i = 0; symmetric && i < right.size(); ++i)
    symmetric = places[half + i] == mirrored(places[right[i]]);
  if (!symmetric) throw std::invalid_argument("the body is not its own mirror image");

  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : places) box.extend(p);
  // The plane x = 0 must stay one: steps are counted from it.
  const Head head{.half = static_cast<std::uint32_t>(half),
                  .triangles = static_cast<std::uint32_t>(triangles.size() / 2),
                  .low = {0.0, box.min().y(), box.min().z()},
                  .step = box.sizes().maxCoeff() / steps};
  std::string out(reinterpret_cast<const char*>(&head), sizeof head);
  const Eigen::Vector3d low(head.low);
  putPoints(
      out, places, [&](std::size_t) { return low; }, half, head.step);
  putInfluences(out, skin.influences, half);
  std::vector<std::int32_t> corners;
  for (std::size_t t = 0; t < head.triangles; ++t)
    for (const int v : triangles[t]) corners.push_back(v);
  putBytes(out, differences(corners), 3);
  return out;
}

Skin unpackBody(std::string_view& packed, const Skeleton& skeleton) {
  Head head;
  if (packed.size() < sizeof head) throw std::runtime_error("a packed body is cut short");
  std::memcpy(&head, packed.data(), sizeof head);
  packed.remove_prefix(sizeof head);
  const Eigen::Vector3d low(head.low);
  Skin skin;
  auto& places = skin.mesh.positions;
  places = takePoints(
      packed, [&](std::size_t) { return low; }, head.half, head.step);
  skin.influences = takeInfluences(packed, head.half);
  const auto corners = sums(takeBytes(packed, 3 * static_cast<std::size_t>(head.triangles), 3));
  for (std::size_t t = 0; t < head.triangles; ++t)
    skin.mesh.triangles.push_back({corners[3 * t], corners[3 * t + 1], corners[3 * t + 2]});

  const std::vector<std::size_t> right = rightHalf(places, head.half);
  mirrorInfluences(skin.influences, right, skeleton);
  std::vector<int> image(head.half);
  std::iota(image.begin(), image.end(), 0);
  for (const std::size_t v : right) {
    image[v] = static_cast<int>(places.size());
    places.push_back(mirrored(places[v]));
  }
  for (std::size_t t = 0; t < head.triangles; ++t) {
    const auto [a, b, c] = skin.mesh.triangles[t];
    skin.mesh.triangles.push_back({image[a], image[c], image[b]});
  }
  computeNormals(skin.mesh);
  for (const Eigen::Isometry3d& frame : restFrames(skeleton))
    skin.jointFromRestWorld.push_back(frame.inverse());
  return skin;
}

std::string packPrepared(const SkinChoice& choice, const PreparedSkin& prepared) {
  const auto& places = prepared.skin.mesh.positions;
  const std::size_t half = leftHalf(places);
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : places) box.extend(p);
  const double step = box.sizes().maxCoeff() / steps;
  std::string out = toString(choice) + '\n';
  out.append(reinterpret_cast<const char*>(&step), sizeof step);
  putInfluences(out, prepared.skin.influences, half);
  putPoints(
      out, prepared.centres, [&](std::size_t v) { return places[v]; }, half, step);
  return out;
}

std::pair<SkinChoice, PreparedSkin> unpackPrepared(std::string_view packed, const Skin& body,
                                                   const Skeleton& skeleton) {
  double step = 0.0;
  const std::size_t end = packed.find('\n');
  if (packed.size() < sizeof step || end > packed.size() - sizeof step - 1)
    throw std::runtime_error("what was prepared is cut short");
  const SkinChoice choice = parseSkinChoice(packed.substr(0, end));
  packed.remove_prefix(end + 1);
  std::memcpy(&step, packed.data(), sizeof step);
  packed.remove_prefix(sizeof step);
  const auto& places = body.mesh.positions;
  const std::size_t half = leftHalf(places);
  const std::vector<std::size_t> right = rightHalf(places, half);
  PreparedSkin prepared{.skin = body};
  prepared.skin.influences = takeInfluences(packed, half);
  mirrorInfluences(prepared.skin.influences, right, skeleton);
  prepared.centres = takePoints(
      packed, [&](std::size_t v) { return places[v]; }, half, step);
  for (const std::size_t v : right) prepared.centres.push_back(mirrored(prepared.centres[v]));
  std::vector<bool> blended;
  for (std::size_t v = 0; v < places.size(); ++v) blended.push_back(prepared.centres[v] != places[v]);
  prepared.centreSlopes = pointSlopes(body.mesh, prepared.centres, blended);
  return {choice, prepared};
}

}  // namespace gelenk
