#pragma once

#include <string>

namespace gelenk::testing {

/// Folders without a slash at the end, as the build was configured: GELENK_DATA_DIR (trial data, may be
/// absent) and assets/.
std::string dataFolder();
std::string assetFolder();

/// The program gelenk of this build.
std::string programFile();

}  // namespace gelenk::testing
