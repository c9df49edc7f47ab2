#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <system_error>

#include "apps/commands/command_line.h"
#include "apps/commands/commands.h"
#include "apps/commands/muscle_report.h"
#include "apps/document/model_files.h"
#include "apps/document/notes.h"
#include "kinematics/io/text_file.h"

namespace gelenk {
namespace {

struct Options {
  std::string model = "figure";
  std::string skeleton, weights, limb;
  std::string out = "muscles";
};

/// Two rows of plots a limb: volume, smallest det and intersecting pairs against the bend; smallest section
/// against the twist.
std::string gnuplotScript(const std::string& csv, const std::string& svg) {
  std::string script = fmt::format(
      "set datafile separator ','\nset terminal svg size 1100,760 dynamic font 'Roboto,13' background "
      "'#ffffff'\nset output '{}'\n"
      "set multiplot layout 2,2\nset grid lc rgb '#dddddd'\nset key top left\n"
      "array names[4] = ['lbs','ffd','ffd-volume','ffd-muscle']\n"
      "array colours[4] = ['#555555','#0072b2','#e69f00','#009e73']\n",
      svg);
  const auto plot = [&](const char* title, const char* ylabel, int column, const char* motion) {
    script += fmt::format(
        "set title '{}'\nset ylabel '{}'\nset xlabel 'degrees'\n"
        "plot for [i=1:4] '{}' using (strcol(2) eq '{}' && strcol(3) eq names[i] ? $4 : NaN):{} with "
        "linespoints pt 7 ps 0.4 lw 2 "
        "lc rgb colours[i] title names[i]\n",
        title, ylabel, csv, motion, column);
  };
  plot("Enclosed volume while bending", "relative to rest", 5, "bend");
  plot("Smallest det of the deformation while bending", "ratio to rest", 6, "bend");
  plot("Self-intersecting triangle pairs while bending", "pairs", 7, "bend");
  plot("Smallest section while the second bone twists", "area relative to rest", 8, "twist-second");
  return script + "unset multiplot\n";
}

/// Runs gnuplot on the script; false where it is not installed or fails.
bool plotWithGnuplot(const std::string& scriptPath) {
  const pid_t child = fork();
  if (child < 0) return false;
  if (child == 0) {
    execlp("gnuplot", "gnuplot", scriptPath.c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  int status = 0;
  return waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

void printTable(const std::vector<DeformationRow>& rows) {
  fmt::print("{:<12} {:<13} {:>8} {:<11} {:>9} {:>9} {:>7} {:>9}\n", "limb", "motion", "degrees", "method",
             "volume", "min det", "pairs", "section");
  for (const DeformationRow& row : rows)
    if (static_cast<int>(row.degrees) % 30 == 0 || row.degrees == 130 || row.degrees == 170)
      fmt::print("{:<12} {:<13} {:>8g} {:<11} {:>9.6f} {:>9.4f} {:>7} {:>9}\n", row.limb, row.motion,
                 row.degrees, row.method, row.volume, row.smallestDet, row.intersectingPairs,
                 row.motion == "bend" ? "-" : fmt::format("{:.4f}", row.smallestSection));
}

void run(const Options& options) {
  const Model model = options.skeleton.empty()
                          ? openModel(options.model)
                          : openBody(options.model, options.skeleton,
                                     options.weights.empty() ? std::nullopt : std::optional(options.weights));
  sayNotes(options.model, model.notes);
  if (!model.skin) throw std::runtime_error("model '" + model.name + "' has no skin to deform");
  if (!restsAsBound(model))
    throw std::runtime_error(
        "model '" + model.name +
        "' is bound in another pose than its skeleton's rest pose, from which the report bends the limbs");
  const Frames rest = restFrames(model.skeleton);
  std::vector<Limb> limbs;
  if (!options.limb.empty())
    limbs.push_back(limbByNames(model.skeleton, rest, options.limb));
  else
    limbs = standardLimbs(model.skeleton, rest);
  if (limbs.empty())
    throw std::runtime_error("model '" + model.name +
                             "' has no limb of a known name; give one with --limb SHOULDER,ELBOW,WRIST");

  std::error_code error;
  std::filesystem::create_directories(options.out, error);
  if (error) throw std::system_error(error, "cannot make the folder " + options.out);
  std::vector<DeformationRow> all;
  for (const Limb& limb : limbs) {
    if (limb.name.starts_with("right ")) continue;  // the mirror image of the left
    const bool terminal = isatty(STDERR_FILENO);
    const auto rows = measureLimb(model.skeleton, *model.skin, limb, [&](double share) {
      if (terminal)
        fmt::print(stderr, "\r{:<24} {:3.0f} %{}", limb.name, 100.0 * share, share >= 1.0 ? "\n" : "");
    });
    std::string file = limb.name;
    for (char& c : file)
      if (c == ' ' || c == ',' || c == '/') c = '_';
    const std::string csv = options.out + "/" + file + ".csv", script = options.out + "/" + file + ".gnuplot";
    writeFile(csv, toCsv(rows));
    writeFile(script, gnuplotScript(csv, options.out + "/" + file + ".svg"));
    if (!plotWithGnuplot(script))
      fmt::print(stderr,
                 "gelenk: gnuplot is not installed or failed; the table is written, {} makes the plot\n",
                 script);
    all.insert(all.end(), rows.begin(), rows.end());
  }
  printTable(all);
  fmt::print("written to {}\n", options.out);
}

}  // namespace

void addMusclesCommand(Command& app) {
  auto options = std::make_shared<Options>();
  Command command = app.command("muscles",
                                "Measure muscle layers against linear blending: volume, folding, "
                                "self-intersection, sections (CSV and SVG)");
  command.option("model", options->model, "Built-in model or body file").showDefault();
  command.option("--skeleton", options->skeleton, "Skeleton of an OBJ body");
  command.option("--weights", options->weights, "Weights of an OBJ body; heat weights where not given");
  command.option("--limb", options->limb, "Joints of the limb, e.g. upperarm_l,lowerarm_l,hand_l");
  command.option("--out", options->out, "Folder for the tables and plots").showDefault();
  command.run([options] { run(*options); });
}

}  // namespace gelenk
