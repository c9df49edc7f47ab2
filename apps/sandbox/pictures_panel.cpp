// Pictures that explain an arm: what is shown, and what can be taken from them.
#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include "apps/sandbox/branches.h"
#include "apps/sandbox/builtin_panels.h"
#include "apps/sandbox/sandbox_state.h"
#include "kinematics/forward_kinematics.h"
#include "kinematics/io/text_file.h"
#include "skinning/blend/skin_method.h"

namespace gelenk {
namespace {

using Pose = Eigen::VectorXd;

/// The poses may be computed anew while one is taken: by value.
void take(Sandbox& sandbox, const Pose pose) {
  sandbox.session().remember();
  sandbox.session().setPose(pose);
}

/// The next or previous branch in the order of all solutions; where only the self-motion is shown, a step
/// along it.
void stepBranch(Sandbox& sandbox, int way) {
  Sandbox::State& s = sandbox.state();
  const TeachingPictures& teaching = s.view->teaching();
  if (!s.show().solutions && !s.show().nullSpace) {
    s.show().solutions = true;
    sandbox.say("All solutions are shown: N takes the next branch, Shift + N the one before");
    return;
  }
  if (const auto& others = teaching.solutions(); !others.empty()) {
    // Round in one order, whichever of them is present: by the directions of the joints, so that whole turns
    // are the same.
    const auto key = [](const Pose& q) {
      std::vector<double> directions;
      for (const double x : q)
        directions.insert(directions.end(), {std::round(1e3 * std::cos(x)), std::round(1e3 * std::sin(x))});
      return directions;
    };
    std::map<std::vector<double>, Pose> all;
    for (const Pose& q : others) all.emplace(key(q), q);
    auto next =
        way > 0 ? all.upper_bound(key(sandbox.session().q())) : all.lower_bound(key(sandbox.session().q()));
    if (way > 0 && next == all.end()) next = all.begin();
    if (way < 0) next = std::prev(next == all.begin() ? all.end() : next);
    take(sandbox, next->second);
  } else if (const auto& along = teaching.selfMotion(); !along.empty()) {
    const int count = static_cast<int>(along.size()), step = std::max(count / 24, 1);
    take(sandbox, along[(teaching.selfMotionAt() + way * step + count) % count]);
  }
}

class PicturesPanel final : public Panel {
 public:
  std::string name() const override { return "Pictures"; }
  bool hasInspector() const override { return true; }

  void drawInspector(Sandbox& sandbox) override {
    Sandbox::State& s = sandbox.state();
    ViewOptions& show = s.show();
    const TeachingPictures& teaching = s.view->teaching();
    learnWhatCannotBeDrawn(sandbox);
    heading(s, "OF THE EFFECTOR");
    ImGui::Checkbox("Velocity ellipsoid", &show.velocityEllipsoid);
    tooltip(
        "Where the effector gets to with |dq/dt| = 1: half axes are the singular values of J (Yoshikawa "
        "1985), "
        "drawn for a fifth of a second. Flat at a singularity.");
    ImGui::Checkbox("Force ellipsoid", &show.forceEllipsoid);
    tooltip(
        "Forces that joint torques of |τ| = 1 hold: half axes are 1 over the singular values. Long where "
        "the "
        "velocity ellipsoid is short.");
    if (ImGui::Checkbox("Reachable set", &show.reachable) && show.reachable) frameReachable(sandbox);
    tooltip(
        "5,000 random poses within the joints' limits; bright where the arm moves well in all directions.");
    heading(s, "OTHER POSES OF THE SAME EFFECTOR");
    choice("All solutions", show.solutions, noSolutions_,
           "Every other solution within the limits, from the complete set (docs/solutions.md). A click on a "
           "ghost takes it, N the next, Shift + N the one before.");
    if (show.solutions) {
      ImGui::TextColored(s.colours().textDim, "%zu beside this one", teaching.solutions().size());
      for (std::size_t i = 0; i < teaching.solutions().size(); ++i) {
        if (i % 6 != 0) ImGui::SameLine();
        if (ImGui::Button(fmt::format("{}", i + 1).c_str(), {38 * s.scale, 0}))
          take(sandbox, teaching.solutions()[i]);
        tooltip("Takes this pose.");
      }
    }
    choice("Self-motion", show.nullSpace, noSelfMotion_,
           "How a seven-joint arm moves while its tool stands still; the slider goes along.");
    if (show.nullSpace && !teaching.selfMotion().empty()) {
      int at = teaching.selfMotionAt();
      const int last = static_cast<int>(teaching.selfMotion().size()) - 1;
      if (valueSlider("##along", at, 0, last, "%d")) {
        const Pose pose = teaching.selfMotion()[std::clamp(at, 0, last)];
        s.session->setPose(pose);
      }
      if (ImGui::IsItemActivated()) s.session->remember();
    }
    heading(s, "OF THE SOLVER");
    choice("Convergence map", show.convergence, noMap_,
           "The present solver from the present pose to a grid of targets, one attempt at each, without "
           "restarts. Coarse while you drag, fine at rest.");
    if (show.convergence && teaching.map().cells > 0) {
      legend(s, teaching.map(), teaching.isWorking());
      if (ImGui::Button("Write as .csv")) write(sandbox, nextFileName(".csv"));
      tooltip("A line a cell: target (metres), iterations, reached, other branch.");
    }
    for (const std::string& reason : teaching.reasons()) wrappedText(s.colours().warning, reason);
  }

  bool keyPressed(Sandbox& sandbox, int key, int modifiers) override {
    if (key != GLFW_KEY_N || modifiers & GLFW_MOD_CONTROL) return false;
    stepBranch(sandbox, modifiers & GLFW_MOD_SHIFT ? -1 : 1);
    return true;
  }

  /// "solution N" and "along N" take a pose, "write FILE" the map.
  void act(Sandbox& sandbox, const std::vector<std::string>& words) override {
    const TeachingPictures& teaching = sandbox.state().view->teaching();
    const auto nth = [&](const std::vector<Eigen::VectorXd>& poses, int first) {
      if (poses.empty()) throw std::invalid_argument("there is no other pose of this effector to take");
      const auto n = parseInteger(words[1]);
      if (!n || *n < first || *n >= first + static_cast<int>(poses.size()))
        throw std::invalid_argument(fmt::format("expected a number from {} to {}, found '{}'", first,
                                                first + static_cast<int>(poses.size()) - 1, words[1]));
      take(sandbox, poses[*n - first]);
    };
    if (words.size() == 2 && words[0] == "solution")
      nth(teaching.solutions(), 1);
    else if (words.size() == 2 && words[0] == "along")
      nth(teaching.selfMotion(), 0);
    else if (words.size() == 2 && words[0] == "write")
      write(sandbox, words[1]);
    else
      throw std::invalid_argument("Pictures takes 'solution N', 'along N' and 'write FILE'");
  }

 private:
  /// Grey where the model has none, unless it is asked for already.
  static void choice(const char* label, bool& shown, const std::string& whyNot, const char* explanation) {
    ImGui::BeginDisabled(!whyNot.empty() && !shown);
    ImGui::Checkbox(label, &shown);
    ImGui::EndDisabled();
    tooltip(whyNot.empty() ? explanation : (std::string(explanation) + "\n\nNot here: " + whyNot).c_str());
  }

  /// Once an effector.
  void learnWhatCannotBeDrawn(Sandbox& sandbox) {
    const Session& session = sandbox.session();
    const auto at = TeachingPictures::effectorOf(session, sandbox.state().selectedGoal);
    const int joint = at ? at->joint : -1;
    const std::shared_ptr<const Model> model = session.sharedModel();
    if (model == model_ && joint == joint_) return;
    model_ = model, joint_ = joint;
    noSolutions_ = noSelfMotion_ = noMap_ = at ? "" : "no goal of a point says which effector is meant";
    if (!at) return;
    noSolutions_ = TeachingPictures::whyNoSolutions(session.skeleton(), *at);
    noSelfMotion_ = TeachingPictures::whyNoSelfMotion(session.skeleton(), *at);
    noMap_ = TeachingPictures::whyNoMap(session.skeleton(), *at);
  }

  std::shared_ptr<const Model> model_;
  int joint_ = -1;
  std::string noSolutions_, noSelfMotion_, noMap_;

  /// Every colour of the map, and how much of it has that colour.
  static void legend(const Sandbox::State& s, const ConvergenceMap& map, bool isWorking) {
    const auto [same, other, missed] = map.shares();
    const auto share = [&](const char* what, double part) {
      ImGui::TextUnformatted(fmt::format("{:.1f} % {}", 100.0 * part, what).c_str());
    };
    ImGui::PushFont(s.gui.fonts().small);
    const bool any = map.fewestIterations <= map.mostIterations;
    const std::string few = any ? fmt::format("{} iterations", map.fewestIterations) : "few iterations",
                      many = any ? std::to_string(map.mostIterations) : "many";
    share("reached", same);
    colourBar(
        s, [](float t) { return ConvergenceMap::reachedColour(t, false); }, few.c_str(), many.c_str());
    if (other > 0.0) {
      share("reached, bent the other way", other);
      colourBar(s, [](float t) { return ConvergenceMap::reachedColour(t, true); });
    }
    share("not reached", missed);
    colourBar(s, [](float) { return ConvergenceMap::notReachedColour(); });
    if (isWorking) ImGui::TextColored(s.colours().textDim, "so far");
    ImGui::PopFont();
  }

  static void write(Sandbox& sandbox, const std::string& path) {
    const ConvergenceMap& map = sandbox.state().view->teaching().map();
    std::string text = "x,y,z,iterations,reached,other_branch\n";
    for (int y = 0; y < map.cells; ++y)
      for (int x = 0; x < map.cells; ++x) {
        const ConvergenceMap::Cell& cell = map.rows[static_cast<std::size_t>(y) * map.cells + x];
        if (!cell.solved) continue;
        const Eigen::Vector3d p = map.corner + (x + 0.5) / map.cells * map.u + (y + 0.5) / map.cells * map.v;
        text += fmt::format("{:.6g},{:.6g},{:.6g},{},{},{}\n", p.x(), p.y(), p.z(), cell.iterations,
                            cell.reached ? 1 : 0, cell.otherBranch ? 1 : 0);
      }
    try {
      writeFile(path, text);
      sandbox.say("Wrote " + path);
    } catch (const std::exception& error) {
      sandbox.say(error.what(), true);
    }
  }
};

}  // namespace

bool takeBranchAt(Sandbox& sandbox, const Eigen::Vector2d& pixel) {
  Sandbox::State& s = sandbox.state();
  const Session& session = sandbox.session();
  const Ray ray = rayThroughPixel(s.camera(), s.viewport(), s.toView(pixel));
  const Pose* found = nullptr;
  double nearest = std::numeric_limits<double>::infinity();
  for (const Pose& q : s.view->teaching().solutions()) {
    const Frames frames = forwardKinematics(session.skeleton(), q);
    if (session.skin() && s.view->prepared()) {
      const auto hit =
          pickSurface(s.view->triangles(session), blendSkin(*s.view->prepared(), frames).positions, ray);
      if (hit && hit->depth < nearest) nearest = hit->depth, found = &q;
      continue;
    }
    for (int i = 0; i < session.skeleton().jointCount(); ++i) {  // bare bones
      const int parent = session.skeleton().parent(i);
      if (parent < 0) continue;
      const Projected a = s.toWindow(frames[parent].translation()), b = s.toWindow(frames[i].translation());
      const Eigen::Vector2d bone = b.pixel - a.pixel;
      const double share =
          std::clamp((pixel - a.pixel).dot(bone) / std::max(bone.squaredNorm(), 1e-12), 0.0, 1.0);
      if ((a.pixel + share * bone - pixel).norm() > 8.0 * s.scale || a.depth <= 0.0 || a.depth >= nearest)
        continue;
      nearest = a.depth, found = &q;
    }
  }
  if (found) take(sandbox, *found);
  return found != nullptr;
}

std::unique_ptr<Panel> makePicturesPanel() { return std::make_unique<PicturesPanel>(); }

}  // namespace gelenk
