// libFuzzer target: whatever the bytes, urdf is read or refused with a ParseError (or std::invalid_argument),
// never more.
#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "kinematics/io/parse_error.h"
#include "kinematics/io/urdf.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace gelenk;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    parseUrdf(text, "fuzz.urdf");
  } catch (const ParseError&) {
  }
  return 0;
}
