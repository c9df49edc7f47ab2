// libFuzzer target: whatever the bytes, a mapping of bones on joints is read or refused with a ParseError;
// what was read transfers a small skeleton or is refused with std::invalid_argument, never more.
#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "kinematics/io/parse_error.h"
#include "kinematics/io/pinocchio_skeleton.h"
#include "kinematics/motion/skeleton_transfer.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace gelenk;
  static const AsfSkeleton asf = parseAsf(
      ":root\norder TX TY TZ RX RY RZ\naxis XYZ\nposition 0 0 0\norientation 0 0 0\n:bonedata\nbegin\nname "
      "a\ndirection 0 1 0\nlength 2\naxis 0 0 20 XYZ\ndof rx\nend\nbegin\nname b\ndirection 1 0 0\nlength "
      "1\naxis 0 0 0 XYZ\nend\n"
      "begin\nname c\ndirection 0 -1 0\nlength 1\naxis 0 0 0 XYZ\nend\n:hierarchy\nbegin\nroot a c\na "
      "b\nend\n",
      "fuzz.asf");
  static const Skeleton fitted =
      parsePinocchioSkeleton("h 0 0 0 -1\ns 0 1 0 h\nt 0 2 0 s\nk 0 -1 0 h\n", "fuzz.skel");
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    transferSkeleton(asf, fitted, parseBonePaths(text, "fuzz.txt"));
  } catch (const ParseError&) {
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
