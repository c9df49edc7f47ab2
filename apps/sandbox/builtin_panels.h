#pragma once

#include <memory>

#include "apps/sandbox/panel.h"

/// Every panel there is, in the order of the tabs. A new one is a line here and a file NAME_panel.cpp, which
/// defines make##NAME##Panel; declarations and table (panels.cpp) are made from this list.
#define GELENK_PANELS(ROW)                                            \
  ROW(Solve)    /* solver, result of the frame, goals */              \
  ROW(Model)    /* joint tree, sliders with limits */                 \
  ROW(Skin)     /* what is drawn, weights */                          \
  ROW(Rig)      /* a surface that is dropped is offered a skeleton */ \
  ROW(Binding)  /* weights by brush and lasso */                      \
  ROW(Muscle)   /* Chadwick's layers: planes, curves, split view */   \
  ROW(Plots)    /* bottom strip: residual, error, joint angles */     \
  ROW(Motion)   /* plays a clip: timeline, trails, contacts, keys */  \
  ROW(Pictures) /* ellipsoids, reach, other solutions, convergence */ \
  ROW(Path)     /* a path drawn by mouse, followed without jumps */   \
  ROW(Lab)      /* up to four solvers as ghosts; reproductions */     \
  ROW(Lecture)  /* the lecture's examples as scenes */

namespace gelenk {

#define GELENK_DECLARE(Name) std::unique_ptr<Panel> make##Name##Panel();
GELENK_PANELS(GELENK_DECLARE)
#undef GELENK_DECLARE

}  // namespace gelenk
