// libFuzzer target: whatever the bytes, dh is read or refused with a ParseError (or std::invalid_argument),
// never more.
#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "kinematics/io/dh_text.h"
#include "kinematics/io/parse_error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace gelenk;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const DhTable table = parseDhTable(text, "fuzz.dh");
    toSkeleton(table);
  } catch (const ParseError&) {
  }
  return 0;
}
