#pragma once

#include <functional>
#include <string>

#include "apps/document/model_reference.h"
#include "apps/document/theme.h"

namespace gelenk {

class Command;

/// A replay to be filmed.
struct FilmOrder {
  std::string input = {};
  Companions files = {};
  std::string replay = {}, output = {};  ///< .mp4 or .gif
  int width = 1280, height = 800;        ///< pixels
  double scale = 1.0;
  Theme theme = Theme::Light;
  bool themeIsWanted = false;  ///< else a scene's own
};

/// `gelenk render`. film: does what --replay asks for; empty: that is refused.
void addRenderCommand(Command& app, std::function<void(const FilmOrder&)> film = {});

}  // namespace gelenk
