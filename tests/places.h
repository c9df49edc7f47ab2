#pragma once

#include <string>

namespace gelenk::testing {

/// Folders without a slash at the end, as the build was configured: GELENK_DATA_DIR (trial data, may be
/// absent), assets/ and tests/data/, the smallest inputs of situations met in other people's files.
std::string dataFolder();
std::string assetFolder();
std::string inputFolder();

/// The program gelenk of this build.
std::string programFile();

}  // namespace gelenk::testing
