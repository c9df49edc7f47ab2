#include "apps/sandbox/panel.h"

namespace gelenk {

std::vector<std::unique_ptr<Panel>> makePanels() {
  std::vector<std::unique_ptr<Panel>> panels;
  return panels;
}

}  // namespace gelenk
