#include "apps/commands/commands.h"

namespace gelenk {

void addRenderCommand(Command& app);
void addSandboxCommand(Command& app);

void addGraphicsCommands(Command& app) {
  addSandboxCommand(app);
  addRenderCommand(app);
}

}  // namespace gelenk
