// libFuzzer target: whatever the bytes, asf is read or refused with a ParseError (or std::invalid_argument),
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
    const AsfSkeleton asf = parseAsf(text, "fuzz.asf");
    try {
      formatAsf(asf.skeleton);
    } catch (const std::invalid_argument&) {  // bones that change their length
    }
  } catch (const ParseError&) {
  }
  return 0;
}
