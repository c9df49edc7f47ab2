#include "apps/commands.h"
#include "apps/render/render_command.h"

namespace gelenk {

void addGraphicsCommands(CLI::App& app) { addRenderCommand(app); }

}  // namespace gelenk
