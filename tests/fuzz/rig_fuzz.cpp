// libFuzzer target: whatever the triangles, a mesh is rigged or refused with RigRefused, never more: every
// row of weights sums to 1 and every joint is finite. The bytes are 16 bit coordinates and indices, so that
// degenerate, repeated, folded and far-away triangles are common; the first byte chooses the template.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "kinematics/forward_kinematics.h"
#include "skinning/rigging/auto_rig.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace gelenk;
  if (size < 2) return 0;
  const std::uint8_t choice = data[0];
  const std::size_t vertices = 3 + data[1] % 64;
  data += 2, size -= 2;
  const auto next = [&] {
    std::int16_t value = 0;
    if (size >= 2) std::memcpy(&value, data, 2), data += 2, size -= 2;
    return value;
  };
  Mesh mesh;
  for (std::size_t v = 0; v < vertices; ++v) {
    const double x = next(), y = next(), z = next();
    mesh.positions.emplace_back(1e-3 * x, 1e-3 * y, 1e-3 * z);
  }
  const auto corner = [&] { return static_cast<int>(static_cast<std::uint16_t>(next()) % vertices); };
  while (size >= 2 && mesh.triangles.size() < 200) {
    const int a = corner(), b = corner(), c = corner();
    mesh.triangles.push_back({a, b, c});
  }
  constexpr RigTemplate templates[] = {RigTemplate::Human, RigTemplate::Pinocchio, RigTemplate::Quadruped};
  try {
    const RiggedBody body = rigBody(mesh, {.skeleton = templates[choice % 3]});
    if (body.weights.size() != vertices || body.bones.size() != vertices) __builtin_trap();
    for (const auto* rows : {&body.weights, &body.bones})
      for (const auto& row : *rows) {
        double sum = 0.0;
        for (const auto& [joint, w] : row) sum += w >= 0.0 ? w : NAN;
        if (!(std::abs(sum - 1.0) < 1e-5)) __builtin_trap();
      }
    for (const auto& frame : restFrames(body.skeleton))
      if (!frame.matrix().allFinite()) __builtin_trap();
    for (const double sure : body.report.jointConfidence)
      if (!(sure >= 0.0 && sure <= 1.0)) __builtin_trap();
  } catch (const RigRefused&) {
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
