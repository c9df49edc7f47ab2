#include "apps/sandbox/builtin_panels.h"

namespace gelenk {

std::vector<std::unique_ptr<Panel>> makePanels() {
  std::vector<std::unique_ptr<Panel>> panels;
#define GELENK_MAKE(Name) panels.push_back(make##Name##Panel());
  GELENK_PANELS(GELENK_MAKE)
#undef GELENK_MAKE
  return panels;
}

}  // namespace gelenk
