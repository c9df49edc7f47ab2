// libFuzzer target: whatever the bytes, bvh is read or refused with a ParseError (or std::invalid_argument),
// never more.
#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "kinematics/io/bvh.h"
#include "kinematics/io/parse_error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace gelenk;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const BvhMotion bvh = parseBvh(text, "fuzz.bvh");
    validate(bvh.skeleton, bvh.clip);
    formatBvh(bvh.skeleton, bvh.clip);
  } catch (const ParseError&) {
  }
  return 0;
}
