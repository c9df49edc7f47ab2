#include "apps/commands.h"

namespace gelenk {

void addInfoCommand(CLI::App& app);

void addCommands(CLI::App& app) {
  addInfoCommand(app);
}

}  // namespace gelenk
