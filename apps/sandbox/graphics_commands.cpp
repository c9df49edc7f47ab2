#include "apps/commands.h"

namespace gelenk {

void addGraphicsCommands(CLI::App&) {}

}  // namespace gelenk
