#include "tests/places.h"

namespace gelenk::testing {

std::string dataFolder() { return GELENK_DATA_DIR; }
std::string assetFolder() { return GELENK_ASSET_DIR; }
std::string inputFolder() { return GELENK_INPUT_DIR; }
std::string programFile() { return GELENK_PROGRAM; }

}  // namespace gelenk::testing
