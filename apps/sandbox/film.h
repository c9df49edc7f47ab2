#pragma once

#include "apps/render/render_command.h"

namespace gelenk {

/// Plays a replay into the sandbox's view alone and films it, with a progress bar on a terminal. Throws what
/// the replay, the model or the film throw.
void filmReplay(const FilmOrder& order);

}  // namespace gelenk
