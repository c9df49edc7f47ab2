#include "apps/web/packed_body.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "kinematics/forward_kinematics.h"
#include "kinematics/symmetry.h"

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

}  // namespace

std::string packBody(const Skin& skin, const Skeleton&) {
  const auto& places = skin.mesh.positions;
  const auto& triangles = skin.mesh.triangles;
  std::size_t half = 0;
  while (half < places.size() && places[half].x() >= 0.0) ++half;
  std::size_t next = half;
  for (std::size_t v = 0; v < half; ++v)
    if (places[v].x() > 0.0)
      if (next == places.size() || places[next++] != mirrored(places[v]))
        throw std::invalid_argument("the body is not its own mirror image");
  if (next != places.size() || triangles.size() % 2)
    throw std::invalid_argument("the body is not its own mirror image");

  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : places) box.extend(p);
  // The plane x = 0 must stay one: steps are counted from it.
  Head head{.half = static_cast<std::uint32_t>(half),
            .triangles = static_cast<std::uint32_t>(triangles.size() / 2),
            .low = {0.0, box.min().y(), box.min().z()},
            .step = box.sizes().maxCoeff() / steps};
  std::string out(reinterpret_cast<const char*>(&head), sizeof head);
  for (int c = 0; c < 3; ++c) {
    std::vector<std::int32_t> column;
    for (std::size_t v = 0; v < half; ++v)
      column.push_back(static_cast<std::int32_t>(std::lround((places[v][c] - head.low[c]) / head.step)));
    putBytes(out, differences(column), 3);
  }
  for (int k = 0; k < 4; ++k) {
    std::vector<std::uint32_t> joints, weights;
    for (std::size_t v = 0; v < half; ++v) {
      joints.push_back(static_cast<std::uint32_t>(skin.influences[v].joints[k]));
      weights.push_back(static_cast<std::uint32_t>(std::lround(skin.influences[v].weights[k] * weightSteps)));
    }
    putBytes(out, joints, 2);
    if (k > 0) putBytes(out, weights, 2);
  }
  std::vector<std::int32_t> corners;
  for (std::size_t t = 0; t < head.triangles; ++t)
    for (const int v : triangles[t]) corners.push_back(v);
  putBytes(out, differences(corners), 3);
  return out;
}

Skin unpackBody(std::string_view packed, const Skeleton& skeleton) {
  Head head;
  if (packed.size() < sizeof head) throw std::runtime_error("a packed body is cut short");
  std::memcpy(&head, packed.data(), sizeof head);
  packed.remove_prefix(sizeof head);
  Skin skin;
  auto& places = skin.mesh.positions;
  places.resize(head.half);
  skin.influences.resize(head.half);
  for (int c = 0; c < 3; ++c) {
    const auto column = sums(takeBytes(packed, head.half, 3));
    for (std::size_t v = 0; v < head.half; ++v) places[v][c] = head.low[c] + head.step * column[v];
  }
  for (Influences& in : skin.influences) in.weights = {1.0, 0.0, 0.0, 0.0};
  for (int k = 0; k < 4; ++k) {
    const auto joints = takeBytes(packed, head.half, 2);
    for (std::size_t v = 0; v < head.half; ++v) skin.influences[v].joints[k] = static_cast<int>(joints[v]);
    if (k == 0) continue;
    const auto weights = takeBytes(packed, head.half, 2);
    for (std::size_t v = 0; v < head.half; ++v) {
      skin.influences[v].weights[k] = static_cast<double>(weights[v]) / weightSteps;
      skin.influences[v].weights[0] -= skin.influences[v].weights[k];
    }
  }
  const auto corners = sums(takeBytes(packed, 3 * static_cast<std::size_t>(head.triangles), 3));
  for (std::size_t t = 0; t < head.triangles; ++t)
    skin.mesh.triangles.push_back({corners[3 * t], corners[3 * t + 1], corners[3 * t + 2]});

  const std::vector<int> partners = mirrorPartners(skeleton);
  std::vector<int> image(head.half);
  for (std::size_t v = 0; v < head.half; ++v) {
    image[v] = static_cast<int>(v);
    if (places[v].x() <= 0.0) continue;
    image[v] = static_cast<int>(places.size());
    places.push_back(mirrored(places[v]));
    Influences in = skin.influences[v];
    for (int& joint : in.joints) joint = partners[joint];
    skin.influences.push_back(in);
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

}  // namespace gelenk
