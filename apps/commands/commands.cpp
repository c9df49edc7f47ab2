#include "apps/commands/commands.h"

namespace gelenk {

void addCompareCommand(Command& app);
void addConvertCommand(Command& app);
void addFkCommand(Command& app);
void addInfoCommand(Command& app);
void addLectureCommand(Command& app);
void addMotionCommand(Command& app);
void addMusclesCommand(Command& app);
void addPathCommand(Command& app);
void addRigCommand(Command& app);
void addSkinsCommand(Command& app);
void addSolveCommand(Command& app);
void addSolutionsCommand(Command& app);

void addCommands(Command& app) {
  addCompareCommand(app);
  addConvertCommand(app);
  addFkCommand(app);
  addInfoCommand(app);
  addLectureCommand(app);
  addMotionCommand(app);
  addMusclesCommand(app);
  addPathCommand(app);
  addRigCommand(app);
  addSkinsCommand(app);
  addSolutionsCommand(app);
  addSolveCommand(app);
}

}  // namespace gelenk
