#include "apps/commands.h"

namespace gelenk {

void addCommands(CLI::App&) {}

}  // namespace gelenk
