#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "apps/commands/commands.h"
#include "apps/document/notes.h"

int main(int argc, char** argv) {
  CLI::App app{"Gelenk: a kinematics and inverse-kinematics research sandbox"};
  app.set_version_flag("--version", "gelenk " GELENK_VERSION);
  app.require_subcommand(1);
  gelenk::addNoteOptions(app);
  gelenk::addCommands(app);
#ifdef GELENK_GRAPHICS
  gelenk::addGraphicsCommands(app);
#endif

  try {
    app.parse(argc, argv);
  } catch (const CLI::RuntimeError& answer) {
    return answer.get_exit_code();  // a command's own: 2 of a problem that was not solved
  } catch (const CLI::Error& error) {
    return app.exit(error) == 0 ? 0 : 1;  // --help and --version are no mistakes
  } catch (const std::exception& error) {
    std::fprintf(stderr, "gelenk: %s\n", error.what());
    return 1;
  }
  return 0;
}
