// Makes the figure's body and what its skinning method prepares once, into $XDG_CACHE_HOME, for the page to
// load.
#include <cstdio>
#include <cstdlib>
#include <stdexcept>

#include "apps/document/model_files.h"
#include "skinning/io/prepared_cache.h"
#include "skinning/io/skin_cache.h"

int main(int argc, char** argv) {
  try {
    if (argc != 2) throw std::invalid_argument("usage: bodies FOLDER");
    setenv("XDG_CACHE_HOME", argv[1], 1);
    const gelenk::Model model = gelenk::readModel({.nameOrFile = "figure"});
    gelenk::cachedPreparedSkin(gelenk::cacheFolder(), model.name, *model.skin, model.skinning, model.skeleton,
                               gelenk::bindFrames(model));
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}
