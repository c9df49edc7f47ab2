#include "apps/sandbox/builtin_panels.h"

namespace gelenk {

std::vector<std::unique_ptr<Panel>> makePanels() {
  std::vector<std::unique_ptr<Panel>> panels;
  panels.push_back(makeSolvePanel());
  panels.push_back(makeModelPanel());
  panels.push_back(makeSkinPanel());
  panels.push_back(
      makeBindingPanel());  // before the muscles, which bind to its weights when a scene is loaded
  panels.push_back(makeMusclePanel());
  panels.push_back(makePlotsPanel());  // first of the bottom strip's tabs
  panels.push_back(makeMotionPanel());
  panels.push_back(makeLabPanel());
  panels.push_back(makeLecturePanel());
  return panels;
}

}  // namespace gelenk
