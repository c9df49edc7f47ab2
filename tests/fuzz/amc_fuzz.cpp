// libFuzzer target: whatever the bytes, amc is read or refused with a ParseError (or std::invalid_argument),
// never more.
#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "kinematics/io/asf_amc.h"
#include "kinematics/io/parse_error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace gelenk;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    static const AsfSkeleton asf = parseAsf(
        ":units\nlength 1\n:root\norder TX TY TZ RX RY RZ\naxis XYZ\n:bonedata\nbegin\nname a\ndirection 0 1 "
        "0\nlength 1\naxis 0 0 0 XYZ\ndof rx rz\nend\n"
        ":hierarchy\nbegin\nroot a\nend\n",
        "fuzz.asf");
    std::vector<Note> notes;
    const MotionClip clip = parseAmc(text, "fuzz.amc", asf, 120.0, &notes);
    validate(asf.skeleton, clip);
    formatAmc(asf.skeleton, clip);
  } catch (const ParseError&) {
  }
  return 0;
}
