#include "apps/commands/commands.h"
#include "apps/render/render_command.h"
#include "apps/sandbox/film.h"

namespace gelenk {

void addSandboxCommand(Command& app);

void addGraphicsCommands(Command& app) {
  addSandboxCommand(app);
  addRenderCommand(app, filmReplay);
}

}  // namespace gelenk
