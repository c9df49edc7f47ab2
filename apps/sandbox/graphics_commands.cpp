#include "apps/commands/commands.h"

namespace gelenk {

void addRenderCommand(CLI::App& app);
void addSandboxCommand(CLI::App& app);

void addGraphicsCommands(CLI::App& app) {
  addSandboxCommand(app);
  addRenderCommand(app);
}

}  // namespace gelenk
