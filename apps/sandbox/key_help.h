#pragma once

#include <array>

namespace gelenk {

/// What a key or a use of the mouse does, as the help window shows it.
struct KeyHelp {
  const char *keys, *what;
};

inline constexpr std::array keyHelp{
    KeyHelp{"Drag a handle, the skin or a joint", "move it in the plane that faces you"},
    KeyHelp{"X, Y, Z while dragging", "lock to an axis, again to free it"},
    KeyHelp{"Shift while dragging", "move along the ground plane"},
    KeyHelp{"T or Alt while dragging", "turn the goal's orientation"},
    KeyHelp{"Esc", "takes a drag back; closes lists, help and presentation"},
    KeyHelp{"Drag the ground", "orbit; middle button orbits anywhere"},
    KeyHelp{"Right drag, Shift + middle", "pan"},
    KeyHelp{"Wheel", "zoom to the mouse"},
    KeyHelp{"P", "pin or free what is under the mouse"},
    KeyHelp{"Delete", "let the goal go"},
    KeyHelp{"R, M", "rest pose, mirror pose"},
    KeyHelp{"Tab, Shift + Tab", "next solver, previous solver"},
    KeyHelp{"F, Home", "frame the selection, frame everything"},
    KeyHelp{"1, 3, 7, 5", "front, side, top, orthographic"},
    KeyHelp{"N, Shift + N", "next and previous branch; a click on a ghost takes it"},
    KeyHelp{"Space", "play"},
    KeyHelp{"Left, Right, Home, End", "previous, next, first, last frame (Motion or Timeline in front)"},
    KeyHelp{"K", "key what has left the clip"},
    KeyHelp{"L", "compare the solvers, or stop (Lab)"},
    KeyHelp{"B, V, [ and ]", "brush, lasso, smaller and larger brush (Binding)"},
    KeyHelp{"Ctrl+Z, Ctrl+Shift+Z, Ctrl+Y", "undo, redo"},
    KeyHelp{"Ctrl+S, Ctrl+Shift+S, Ctrl+O", "save, save as, open; files can be dropped"},
    KeyHelp{"F5", "presentation: the derivation in large type"},
    KeyHelp{"Ctrl+K", "find any action, model, example or solver"},
    KeyHelp{"F12, Ctrl+R", "screenshot; record a film, and stop"},
    KeyHelp{"H or ?, Ctrl+Q", "this help; quit"}};

}  // namespace gelenk
