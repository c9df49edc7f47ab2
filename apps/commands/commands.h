#pragma once

namespace CLI {
class App;
}

namespace gelenk {

// Each command lives in its own NAME_command.cpp, adds itself to the parser with a callback, and reports
// failure by an exception (exit status 1, one sentence on standard error) or by CLI::RuntimeError(status).

void addCommands(CLI::App& app);          ///< everything that needs no graphics
void addGraphicsCommands(CLI::App& app);  ///< sandbox, render

}  // namespace gelenk
