// libFuzzer target: whatever the bytes, a scene is read or refused with a ParseError, never more.
#include <cstddef>
#include <cstdint>

#include "apps/document/scene_file.h"
#include "kinematics/io/parse_error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace gelenk;
  static const Model model = [] {
    Model made{
        .name = "fuzz",
        .skeleton = Skeleton(
            {{.name = "a", .ball = true},
             {.name = "b", .parent = 0, .axes = {{AxisDof::Kind::Rotation, Eigen::Vector3d::UnitZ()}}}})};
    made.clip = MotionClip{.framesPerSecond = 1.0, .q = made.skeleton.rest().replicate(1, 3)};
    return made;
  }();
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    parseModelReference(text, "fuzz.json");
    parseScene(text, "fuzz.json", model);
  } catch (const ParseError&) {
  }
  return 0;
}
