// libFuzzer target: whatever the bytes, pinocchio_weights is read or refused with a ParseError (or
// std::invalid_argument), never more.
#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "kinematics/io/parse_error.h"
#include "skinning/io/pinocchio_weights.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace gelenk;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    for (const int rows : {1, 3}) {
      const BoneWeights weights = parsePinocchioWeights(text, "fuzz.weights", 2, rows);
      if (parsePinocchioWeights(formatPinocchioWeights(weights), "again.weights", 2, rows) != weights)
        __builtin_trap();
    }
  } catch (const ParseError&) {
  }
  return 0;
}
