#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <system_error>

#include "apps/commands/command_line.h"
#include "apps/commands/commands.h"
#include "apps/commands/image.h"
#include "apps/commands/shaded_picture.h"
#include "apps/commands/skins_report.h"
#include "apps/document/model_files.h"
#include "apps/document/muscle_settings.h"
#include "apps/document/notes.h"
#include "kinematics/io/text_file.h"

namespace gelenk {
namespace {

struct Options {
  std::string model = "figure";
  Companions files;
  std::string poses = "standard";
  std::vector<std::string> methods;
  std::string out = "skins";
  int pictureSize = 260;
  bool withoutTimes = false, withoutPictures = false, reference = false;
};

/// What stands in the table without being asked for; layers where the body has limbs for them.
std::vector<std::string> standardMethods(const Model& model) {
  std::vector<std::string> methods{
      "lbs",
      "dqs",
      "cor",
      "lbs+twist",
      "dqs+twist",
      "cor+twist",
      "lbs+smooth",
      "dqs+twist+smooth",
      "cor+twist+smooth",
  };
  if (!limbsOf(model).empty())
    methods.insert(methods.end(),
                   {"lbs+layers", "cor+twist+smooth+layers", "cor+twist+smooth+layers=muscle"});
  return methods;
}

/// All columns of a method over all poses.
struct Summary {
  int pairs = 0;
  double crease = 0.0, section = 0.0, worst = 1.0, volume = 0.0, normalMean = 0.0, normalMost = 0.0;
  double volumeOff = 0.0, distance = 0.0;  ///< means over the poses that the reference counts in
  int compared = 0;
};
Summary summarise(const std::vector<SkinCell>& cells, const std::string& method) {
  Summary sum;
  int count = 0, sections = 0;
  for (const SkinCell& c : cells) {
    if (c.method != method) continue;
    ++count;
    sum.pairs += c.pairs;
    sum.crease += c.crease;
    sum.volume += std::abs(c.volume);
    sum.normalMean += c.normalMean;
    sum.normalMost = std::max(sum.normalMost, c.normalMost);
    if (!c.pose.starts_with("neck") && !c.pose.starts_with("spine")) sum.section += c.section, ++sections;
    sum.worst = std::min(sum.worst, c.section);
    if (c.volumeOff && c.distance) ++sum.compared, sum.volumeOff += *c.volumeOff, sum.distance += *c.distance;
  }
  if (count > 0) sum.crease /= count, sum.volume /= count, sum.normalMean /= count;
  if (sum.compared > 0) sum.volumeOff /= sum.compared, sum.distance /= sum.compared;
  sum.section = sections > 0 ? sum.section / sections : 1.0;
  return sum;
}

std::string pictureName(const std::string& method) { return method + ".png"; }

std::string offText(const Summary& s) {
  return s.compared > 0 ? fmt::format("{:.1f} %", 100.0 * s.volumeOff) : "-";
}
std::string distanceText(const Summary& s) {
  return s.compared > 0 ? fmt::format("{:.2f} mm", 1e3 * s.distance) : "-";
}

std::string page(const SkinComparison& comparison, const SkinTrials& trials, const std::string& model,
                 bool pictures) {
  std::string html = fmt::format(
      "<!doctype html><meta charset=\"utf-8\"><title>Skins of {0}</title><style>body{{font:15px "
      "sans-serif;margin:2em}}"
      "table{{border-collapse:collapse}}td,th{{padding:.25em .7em;border-bottom:1px solid "
      "#ccc;text-align:right}}"
      "td:first-child,th:first-child{{text-align:left}}img{{max-width:100%}}</style><h1>Skins of {0}</h1>\n"
      "<p>Sums and means over {1} poses. Pairs: triangles that pass through each other beyond rest's, "
      "summed. Crease: "
      "mean of the 50 largest growths of an edge's angle, degrees. Section: smallest area across a limb's "
      "bones against "
      "rest, mean and worst pose. Volume: mean size of the change of the part around the joint. Normals: "
      "against the "
      "triangles', degrees, mean and the largest 95 % of a pose. Time: of the plain linear blend, with "
      "normals by the "
      "gradients of the weights and with cheap ones. |dV| and distance: from the elastic reference, means "
      "over the poses in which it does not run through itself.</p>\n<table><tr><th>method<th>pairs<th>crease"
      "<th>section<th>worst<th>volume<th>|dV|<th>distance<th>normals<th>95 "
      "%<th>time<th>cheap<th>bytes<th>prepared<th>step</tr>\n",
      model, trials.poses.size());
  for (const SkinCost& cost : comparison.costs) {
    const Summary s = summarise(comparison.cells, cost.method);
    html += fmt::format("<tr><td>{}<td>{}<td>{:.1f}<td>{:.2f}<td>{:.2f}<td>{:.1f} %", cost.method, s.pairs,
                        s.crease, s.section, s.worst, 100.0 * s.volume);
    html += fmt::format("<td>{}<td>{}<td>{:.2f}<td>{:.2f}", offText(s), distanceText(s), s.normalMean,
                        s.normalMost);
    html += cost.timesLbs > 0.0 ? fmt::format("<td>{:.2f}<td>{:.2f}", cost.timesLbs, cost.timesLbsCheap)
                                : "<td><td>";
    html += fmt::format("<td>{}<td>{:.2f} s<td>{}</tr>\n", cost.bytes, cost.prepareSeconds,
                        cost.largestStep < 0.0 ? "" : fmt::format("{:.2f} mm", cost.largestStep));
  }
  html +=
      "</table>\n<h2>Pose by "
      "pose</h2>\n<table><tr><th>pose<th>method<th>pairs<th>crease<th>section<th>volume</tr>\n";
  std::vector<SkinCell> cells = comparison.reference;
  cells.insert(cells.end(), comparison.cells.begin(), comparison.cells.end());
  for (const SkinPoseCase& pose : trials.poses)
    for (const SkinCell& c : cells)
      if (c.pose == pose.name)
        html += fmt::format("<tr><td>{}<td>{}<td>{}<td>{:.1f}<td>{:.2f}<td>{:+.1f} %</tr>\n", c.pose,
                            c.method, c.pairs, c.crease, c.section, 100.0 * c.volume);
  html += "</table>\n";
  if (pictures)
    for (const SkinCost& cost : comparison.costs)
      html += fmt::format("<h2>{0}</h2><img src=\"{1}\" alt=\"every pose by {0}\">\n", cost.method,
                          pictureName(cost.method));
  return html;
}

/// One sheet of pictures a method, the poses in rows of six.
class Sheets {
 public:
  Sheets(const SkinTrials& trials, int size) : trials_(trials), size_(size) {}
  void add(const std::string& method, const SkinPoseCase& pose, const Mesh& mesh, const SkinnedVertices& at) {
    constexpr int columns = 6;
    const int size = size_;
    const int rows = (static_cast<int>(trials_.poses.size()) + columns - 1) / columns;
    auto& sheet =
        sheets_.try_emplace(method, columns * size, rows * size, std::array<std::uint8_t, 3>{250, 249, 246})
            .first->second;
    const int index = static_cast<int>(&pose - trials_.poses.data());
    Eigen::AlignedBox3d body;
    for (const Eigen::Vector3d& p : at.positions) body.extend(p);
    const bool whole = pose.radius > body.diagonal().norm();
    sheet.draw({index % columns * size, index / columns * size, size, size},
               {.direction = {-0.55, -0.25, -0.8},
                .up = Eigen::Vector3d::UnitY(),
                .centre = whole ? Eigen::Vector3d(body.center()) : pose.centre,
                .height = whole ? 1.1 * body.sizes().maxCoeff() : 4.0 * pose.radius},
               at.positions, at.normals, mesh.triangles, {{0.86f, 0.80f, 0.74f}});
  }
  void write(const std::string& folder) const {
#ifdef GELENK_GRAPHICS
    for (const auto& [method, sheet] : sheets_) writePng(folder + "/" + pictureName(method), sheet.image());
#else
    (void)folder;
#endif
  }

 private:
  const SkinTrials& trials_;
  int size_;  ///< pixels a pose
  std::map<std::string, ShadedPicture> sheets_;
};

void print(const SkinComparison& comparison) {
  fmt::print("{:<31} {:>6} {:>7} {:>8} {:>6} {:>8} {:>6} {:>8} {:>8} {:>6} {:>6} {:>6} {:>6} {:>9} {:>8}\n",
             "method", "pairs", "crease", "section", "worst", "|volume|", "|dV|", "distance", "normals",
             "95 %", "time", "cheap", "bytes", "prepared", "step");
  for (const SkinCost& cost : comparison.costs) {
    const Summary s = summarise(comparison.cells, cost.method);
    fmt::print(
        "{:<31} {:>6} {:>7.1f} {:>8.3f} {:>6.2f} {:>6.1f} % {:>6} {:>8} {:>8.2f} {:>6.2f} {:>6} {:>6} {:>6} "
        "{:>7.2f} s {:>8}\n",
        cost.method, s.pairs, s.crease, s.section, s.worst, 100.0 * s.volume, offText(s), distanceText(s),
        s.normalMean, s.normalMost, cost.timesLbs > 0.0 ? fmt::format("{:.2f}", cost.timesLbs) : "-",
        cost.timesLbs > 0.0 ? fmt::format("{:.2f}", cost.timesLbsCheap) : "-", cost.bytes,
        cost.prepareSeconds, cost.largestStep < 0.0 ? "-" : fmt::format("{:.2f} mm", cost.largestStep));
  }
}

/// Throws std::invalid_argument where two are the same: tables and pictures are named after them.
std::vector<SkinChoice> chosenMethods(const std::vector<std::string>& texts) {
  std::vector<SkinChoice> methods;
  std::map<std::string, std::string> textOf;
  for (const std::string& text : texts) {
    methods.push_back(parseSkinChoice(text));
    const auto [before, isNew] = textOf.try_emplace(toString(methods.back()), text);
    if (!isNew)
      throw std::invalid_argument(fmt::format("--method: '{}' and '{}' are both {}; name each method once",
                                              before->second, text, before->first));
  }
  return methods;
}

void run(const Options& options) {
  std::vector<SkinChoice> methods = chosenMethods(options.methods);
  const Model model = importFiles(options.model, options.files).model;
  sayNotes(options.model, model.notes);
  if (!model.skin) throw std::runtime_error("model '" + model.name + "' has no skin to deform");
  if (methods.empty())
    for (const std::string& text : standardMethods(model)) methods.push_back(parseSkinChoice(text));
  SkinTrials trials;
  if (options.poses == "standard") {
    trials = standardTrials(model);
    if (trials.poses.empty())
      throw std::runtime_error(
          "model '" + model.name +
          "' has no arm, leg, neck or spine of a known name; give a motion with --poses");
  } else {
    const Model motion = importFiles(options.poses).model;
    sayNotes(options.poses, motion.notes);
    if (!motion.clip || motion.skeleton.nq() != model.skeleton.nq())
      throw std::runtime_error("'" + options.poses + "' is no motion of the skeleton of '" + model.name +
                               "'; `gelenk motion --onto` makes one");
    trials = motionTrials(model, *motion.clip, 18);
  }
  std::error_code error;
  std::filesystem::create_directories(options.out, error);
  if (error) throw std::system_error(error, "cannot make the folder " + options.out);

  Sheets sheets(trials, options.pictureSize);
  const bool terminal = isatty(STDERR_FILENO);
  const SkinComparison comparison = compareSkins(
      model, methods, trials, !options.withoutTimes, options.reference,
      [&](double share, const std::string& what) {
        if (terminal) fmt::print(stderr, "\r{:3.0f} % {:<60}", 100.0 * share, what);
      },
      [&](const SkinChoice& choice, const SkinPoseCase& pose, const Mesh& mesh, const SkinnedVertices& at) {
        if (!options.withoutPictures) sheets.add(toString(choice), pose, mesh, at);
      });
  if (terminal) fmt::print(stderr, "\r{:<70}\r", "");
  std::vector<SkinCell> cells = comparison.reference;
  cells.insert(cells.end(), comparison.cells.begin(), comparison.cells.end());
  writeFile(options.out + "/poses.csv", toCsv(cells));
  writeFile(options.out + "/methods.csv", toCsv(comparison.costs));
  writeFile(options.out + "/index.html", page(comparison, trials, model.name, !options.withoutPictures));
  sheets.write(options.out);
  print(comparison);
  fmt::print("written to {}\n", options.out);
}

}  // namespace

void addSkinsCommand(Command& app) {
  auto options = std::make_shared<Options>();
  Command command =
      app.command("skins",
                  "Compare skinning methods on a body: self-intersection, creases, sections, volume, "
                  "normals, time (CSV, HTML, pictures)");
  command.option("model", options->model, "Built-in model or body file").showDefault();
  command.option("--skeleton", options->files.skeleton, "Skeleton of an OBJ body");
  command.option("--weights", options->files.weights, "Weights of an OBJ body; heat weights where not given");
  command.option("--poses", options->poses, "standard, or a motion of the same skeleton").showDefault();
  command
      .option("--method", options->methods,
              "What is compared, e.g. lbs,cor+twist+smooth+layers,ddm-v2; default: lbs, dqs and cor in their "
              "combinations")
      .commas();
  command.option("-o,--out", options->out, "Folder for table, page and pictures").showDefault();
  command.option("--picture-size", options->pictureSize, "Pixels of a pose in the sheets")
      .range(32, 2000)
      .showDefault();
  command.flag("--reference", options->reference,
               "Compute the flesh as an elastic continuum too, and how far volumes and surfaces are from it; "
               "takes minutes");
  command.flag("--no-times", options->withoutTimes, "Leave out times and largest steps");
  command.flag("--no-pictures", options->withoutPictures, "Leave out the sheets of pictures");
  command.run([options] { run(*options); });
}

}  // namespace gelenk
