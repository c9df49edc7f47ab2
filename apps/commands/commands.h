#pragma once

namespace gelenk {

class Command;

// Each command lives in its own NAME_command.cpp, adds itself to the parser with a callback, and reports
// failure by an exception (exit status 1, one sentence on standard error) or by ExitStatus.

void addCommands(Command& app);          ///< everything that needs no graphics
void addGraphicsCommands(Command& app);  ///< sandbox, render

}  // namespace gelenk
