// libFuzzer target: whatever the bytes, a scene is read or refused with a ParseError, never more.
#include <cstddef>
#include <cstdint>

#include "apps/document/scene.h"
#include "kinematics/io/parse_error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace gelenk;
  static const Skeleton skeleton(
      {{.name = "a", .ball = true},
       {.name = "b", .parent = 0, .axes = {{AxisDof::Kind::Rotation, Eigen::Vector3d::UnitZ()}}}});
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    parseModelReference(text, "fuzz.json");
    parseScene(text, "fuzz.json", skeleton);
  } catch (const ParseError&) {
  }
  return 0;
}
