#include "apps/commands/model_options.h"

#include "apps/commands/command_line.h"

namespace gelenk {

void addModelOptions(Command& command, Companions& files) {
  command.option("--skeleton", files.skeleton, "Skeleton of an OBJ body");
  command.option("--weights", files.weights, "Weights of an OBJ body; heat weights where not given");
  command.option("--mapping", files.mapping,
                 "Which bones lie on which joints: lines 'bone ... : joint joint ...'");
  command.option("--figure", files.figure, "Figure of a tutorial pose");
}

}  // namespace gelenk
