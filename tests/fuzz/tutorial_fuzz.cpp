// libFuzzer target: whatever the bytes, tutorial is read or refused with a ParseError (or
// std::invalid_argument), never more.
#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "kinematics/io/parse_error.h"
#include "kinematics/io/tutorial_skeleton.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace gelenk;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    if (text.find("JointAngles") != std::string_view::npos) {
      const TutorialPose pose = parseTutorialPose(text, "fuzz.pose");
      if (parseTutorialPose(formatTutorialPose(pose), "again.pose") != pose) __builtin_trap();
      return 0;
    }
    const TutorialSkeleton tutorial = parseTutorialSkeleton(text, "fuzz.figure");
    toSkeleton(tutorial);
    if (formatTutorialSkeleton(parseTutorialSkeleton(formatTutorialSkeleton(tutorial), "again.figure")) !=
        formatTutorialSkeleton(tutorial))
      __builtin_trap();
  } catch (const ParseError&) {
  }
  return 0;
}
