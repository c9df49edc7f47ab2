#pragma once

#include <memory>

#include "apps/sandbox/panel.h"

namespace gelenk {

std::unique_ptr<Panel> makeSolvePanel();    ///< solver, result of the frame, goals
std::unique_ptr<Panel> makeModelPanel();    ///< joint tree, sliders with limits
std::unique_ptr<Panel> makeSkinPanel();     ///< what is drawn, weights
std::unique_ptr<Panel> makeBindingPanel();  ///< weights by brush and lasso
std::unique_ptr<Panel> makeMusclePanel();   ///< Chadwick's layers: planes, curves, split view
std::unique_ptr<Panel> makeLabPanel();      ///< up to four solvers as ghosts on the same goals; reproductions
std::unique_ptr<Panel> makeMotionPanel();   ///< plays a clip: timeline, trails, contacts, edits
std::unique_ptr<Panel> makePlotsPanel();    ///< bottom strip: residual, error, joint angles
std::unique_ptr<Panel> makeLecturePanel();  ///< the lecture's examples as scenes

}  // namespace gelenk
