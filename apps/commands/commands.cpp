#include "apps/commands/commands.h"

namespace gelenk {

void addCompareCommand(CLI::App& app);
void addConvertCommand(CLI::App& app);
void addFkCommand(CLI::App& app);
void addInfoCommand(CLI::App& app);
void addLectureCommand(CLI::App& app);
void addMotionCommand(CLI::App& app);
void addMusclesCommand(CLI::App& app);
void addSolutionsCommand(CLI::App& app);
void addSolveCommand(CLI::App& app);

void addCommands(CLI::App& app) {
  addCompareCommand(app);
  addConvertCommand(app);
  addFkCommand(app);
  addInfoCommand(app);
  addLectureCommand(app);
  addMotionCommand(app);
  addMusclesCommand(app);
  addSolutionsCommand(app);
  addSolveCommand(app);
}

}  // namespace gelenk
