// libFuzzer target: whatever the bytes, a NURBS surface is read (then writing and reading gives the same
// text, and the surface can be evaluated) or refused with a ParseError, never more.
#include <cstddef>
#include <cstdint>

#include "kinematics/io/parse_error.h"
#include "skinning/io/nurbs.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace gelenk;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const NurbsSurface surface = parseNurbs(text, "fuzz.nurbs");
    const std::string written = nurbsText(surface);
    if (nurbsText(parseNurbs(written, "again.nurbs")) != written) __builtin_trap();
    evaluate(surface, 0.5, 0.5);
  } catch (const ParseError&) {
  }
  return 0;
}
