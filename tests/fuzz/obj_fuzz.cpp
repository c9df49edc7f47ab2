// libFuzzer target: whatever the bytes, obj is read or refused with a ParseError (or std::invalid_argument),
// never more.
#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "kinematics/io/parse_error.h"
#include "skinning/io/obj.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace gelenk;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    std::vector<Note> notes;
    const Mesh mesh = parseObj(text, "fuzz.obj", &notes);
    validate(mesh);
    if (parseObj(formatObj(mesh), "again.obj").positions != mesh.positions) __builtin_trap();
  } catch (const ParseError&) {
  }
  return 0;
}
