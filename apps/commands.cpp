#include "apps/commands.h"

namespace gelenk {

void addFkCommand(CLI::App& app);
void addInfoCommand(CLI::App& app);
void addMusclesCommand(CLI::App& app);

void addCommands(CLI::App& app) {
  addFkCommand(app);
  addInfoCommand(app);
  addMusclesCommand(app);
}

}  // namespace gelenk
