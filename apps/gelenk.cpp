#include "apps/commands/command_line.h"
#include "apps/commands/commands.h"
#include "apps/document/notes.h"

int main(int argc, char** argv) {
  gelenk::CommandLine line("Gelenk: a kinematics and inverse-kinematics research sandbox",
                           "gelenk " GELENK_VERSION);
  gelenk::Command program = line.root();
  gelenk::addNoteOptions(program);
  gelenk::addCommands(program);
#ifdef GELENK_GRAPHICS
  gelenk::addGraphicsCommands(program);
#endif
  return line.run(argc, argv);
}
