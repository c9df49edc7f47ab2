// A surface without a skeleton that is dropped on the window is offered one, and the rig is mended here.
#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <future>
#include <map>
#include <mutex>
#include <numeric>

#include "apps/document/model_files.h"
#include "apps/sandbox/builtin_panels.h"
#include "apps/sandbox/sandbox_state.h"
#include "apps/sandbox/work.h"
#include "kinematics/io/pinocchio_skeleton.h"
#include "kinematics/io/text_file.h"
#include "kinematics/io/word_stream.h"
#include "kinematics/symmetry.h"
#include "skinning/io/gltf.h"
#include "skinning/io/skin_cache.h"
#include "skinning/io/stl.h"
#include "skinning/rigging/auto_rig.h"

namespace gelenk {
namespace {

namespace fs = std::filesystem;

/// What the work in the background tells the window.
struct Progress {
  std::mutex lock;
  std::string stage = "reading";
  double done = 0.0;
  std::atomic<bool> stop = false;
};

/// Which skeleton is fitted: one of the program's, or a file with one of the user's.
struct Choice {
  RigTemplate skeleton = RigTemplate::Human;
  std::string own = {};
};

/// A body that was rigged here, and where it was written.
struct Rigged {
  Mesh mesh;
  RiggedBody body;
  Choice choice;
  std::string path;  ///< of the .glb
};

Skin skinOf(const Rigged& rigged) {
  const Skeleton& skeleton = rigged.body.skeleton;
  return bindSkin(rigged.mesh, restFrames(skeleton), fourLargest(rigged.body.weights, skeleton.jointCount()));
}

/// Beside the mesh where that can be written, else in the cache.
std::string write(const std::string& meshPath, const Skeleton& skeleton, const Skin& skin) {
  const fs::path mesh(meshPath);
  const fs::path beside = mesh.parent_path() / (mesh.stem().string() + "_rigged.glb");
  try {
    writeGltf(beside.string(), skeleton, &skin, {}, GltfJoints::AsTheyMove);
    return beside.string();
  } catch (const std::exception&) {
    const fs::path folder = fs::path(cacheFolder()) / "rigged";
    fs::create_directories(folder);
    const std::string path = (folder / beside.filename()).string();
    writeGltf(path, skeleton, &skin, {}, GltfJoints::AsTheyMove);
    return path;
  }
}

Rigged rig(const std::string& path, const Choice& choice, Progress& progress) {
  Rigged rigged{.mesh = lowerCase(path).ends_with(".stl") ? readStl(path) : readMesh(path),
                .body = {},
                .choice = choice,
                .path = {}};
  RigOptions options{.skeleton = choice.skeleton, .progress = [&](const std::string& stage, double done) {
                       const std::scoped_lock hold(progress.lock);
                       progress.stage = stage;
                       progress.done = done;
                       return !progress.stop;
                     }};
  if (!choice.own.empty()) options.own = openModelFile(choice.own).skeleton;
  rigged.body = rigBody(rigged.mesh, options);
  rigged.body.skeleton = namedAsHuman(rigged.body.skeleton);
  rigged.path = write(path, rigged.body.skeleton, skinOf(rigged));
  return rigged;
}

/// Files of skeletons in the mesh's folder, those of its name first: fitted ones of Pinocchio, or skeletons
/// that can be fitted.
std::vector<std::string> skeletonsBeside(const std::string& meshPath, bool fitted) {
  std::vector<std::string> found;
  std::error_code error;
  const fs::path mesh(meshPath);
  const fs::path folder = mesh.has_parent_path() ? mesh.parent_path() : fs::path(".");
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const auto kind = fileKind(entry.path().string());
    if (fitted ? kind == FileKind::PinocchioSkeleton
               : kind == FileKind::Bvh || kind == FileKind::Asf || kind == FileKind::TutorialSkeleton)
      found.push_back(entry.path().string());
  }
  const std::string own = stem(meshPath);
  std::ranges::sort(found, [&](const std::string& a, const std::string& b) {
    const bool aOwn = stem(a) == own, bOwn = stem(b) == own;
    return aOwn != bOwn ? aOwn : a < b;
  });
  if (found.size() > 6) found.resize(6);
  return found;
}

/// Offered where a mesh without a skeleton is opened; then the room where its rig is mended: joints are moved
/// in the rest pose, weights follow, and colours say how sure the fit is.
class RigPanel final : public Panel {
 public:
  std::string name() const override { return "Rig"; }
  bool hasInspector() const override { return rigged_.has_value(); }
  ~RigPanel() override {
    if (progress_) progress_->stop = true;  // the future waits for the work to end
  }

  bool openFile(Sandbox& sandbox, const std::string& path) override {
    const std::string lower = lowerCase(path);
    std::error_code error;
    if (!fs::is_regular_file(path, error) || !(isMesh(fileKind(path)) || lower.ends_with(".stl")))
      return false;
    if (working()) throw std::runtime_error("another body is being rigged: wait, or stop that first");
    if (!lower.ends_with(".stl")) readMesh(path);  // what is no mesh is told at once
    path_ = path;
    beside_ = skeletonsBeside(path, true);
    asking_ = true;
    sandbox.select(std::nullopt);
    return true;
  }

  /// "human", "pinocchio", "quadruped", "fit FILE" rig the mesh that was dropped, or the body that stands
  /// there anew; "with FILE" takes a skeleton as it is; "stop", "cancel". "tool on|off", "mirrored on|off",
  /// "confidence on|off", "move JOINT X Y Z" (metres), "weigh", "undo", "redo" mend.
  void act(Sandbox& sandbox, const std::vector<std::string>& words) override {
    static const std::map<std::string, RigTemplate> templates{{"human", RigTemplate::Human},
                                                              {"pinocchio", RigTemplate::Pinocchio},
                                                              {"quadruped", RigTemplate::Quadruped}};
    const std::string command = words.empty() ? "" : words[0];
    const bool waits = asking_ || rigged_;
    if (command == "stop" && working()) {
      progress_->stop = true;
    } else if (command == "cancel") {
      asking_ = false;
    } else if (words.size() == 1 && templates.contains(command) && waits) {
      start({.skeleton = templates.at(command)});
    } else if (words.size() == 2 && command == "fit" && waits) {
      start({.own = words[1]});
    } else if (words.size() == 2 && command == "with" && asking_) {
      openWith(sandbox, words[1]);
    } else if (!rigged_) {
      throw std::invalid_argument("no body waits for a skeleton or has one from here: drop a mesh first");
    } else if (words.size() == 5 && command == "move") {
      moveJoint(sandbox, rigged_->body.skeleton.jointIndex(words[1]),
                {parsed(words[2]), parsed(words[3]), parsed(words[4])});
    } else if (words.size() == 2 && (words[1] == "on" || words[1] == "off") &&
               (command == "tool" || command == "mirrored" || command == "confidence")) {
      (command == "tool" ? moving_ : command == "mirrored" ? mirrored_ : coloured_) = words[1] == "on";
    } else if (command == "weigh") {
      weighAnew();
    } else if (command == "undo" || command == "redo") {
      travel(sandbox, command == "undo" ? undo_ : redo_, command == "undo" ? redo_ : undo_);
    } else {
      throw std::invalid_argument(
          "Rig takes human, pinocchio, quadruped, 'fit FILE', 'with FILE', stop, cancel; tool, mirrored and "
          "confidence on|off, 'move JOINT X Y Z', weigh, undo, redo");
    }
  }

  double rests(const Sandbox&) const override {
    return working() || weighing_.valid() ? 0.0 : std::numeric_limits<double>::infinity();
  }

  void opened(Sandbox&, bool) override {
    if (opening_) return;
    rigged_.reset();
    undo_.clear();
    redo_.clear();
    moving_ = false;
    dragged_.reset();
  }

  void step(Sandbox& sandbox, double) override {
    using namespace std::chrono_literals;
    const auto ready = [](const auto& work) {
      return work.valid() && work.wait_for(0s) == std::future_status::ready;
    };
    if (ready(work_)) {
      asking_ = false;
      try {
        Rigged rigged = work_.get();
        undo_.clear();
        redo_.clear();
        moving_ = false;
        weighSeconds_ = rigged.body.report.stages.back().seconds;
        show(sandbox, std::move(rigged), false);
        const RigReport& report = rigged_->body.report;
        std::string doubts;
        for (const std::string& doubt : report.doubts)
          doubts += (doubts.empty() ? "; doubtful: " : "; ") + doubt;
        sandbox.say(fmt::format("Rigged, confidence {:.0f} %{}: drag it, or mend it in the tab Rig",
                                100.0 * report.confidence, doubts));
      } catch (const RigStopped&) {
        sandbox.say("Rigging was stopped");
      } catch (const std::exception& error) {
        sandbox.say(error.what(), true);
      }
    }
    if (ready(weighing_)) {
      try {
        Rigged weighed = weighing_.get();
        if (rigged_) show(sandbox, std::move(weighed), true);
      } catch (const std::exception& error) {
        sandbox.say(error.what(), true);
      }
    }
    if (takesMouse(sandbox)) sandbox.showFrames(bindFrames(sandbox.session().model()));
  }

  bool takesMouse(const Sandbox& sandbox) const override {
    return rigged_ && moving_ && sandbox.frameNumber() - shownAt_ <= 1;
  }

  bool pressed(Sandbox& sandbox, const Eigen::Vector2d& pixel) override {
    if (weighing_.valid()) return false;
    dragged_ = jointAt(sandbox, pixel);
    if (!dragged_) return false;
    sandbox.select(*dragged_);
    grip_ = restFrames(rigged_->body.skeleton)[*dragged_].translation();
    offset_ = sandbox.state().toWindow(grip_).pixel - pixel;
    edited_.reset();
    return true;
  }

  void moved(Sandbox& sandbox, const Eigen::Vector2d& pixel) override {
    const Sandbox::State& s = sandbox.state();
    if (!dragged_) return;
    if (const auto place =
            dragTarget(s.camera(), s.viewport(), s.toView(pixel + offset_), grip_, DragConstraint::ViewPlane))
      edited_ = withJoint(*dragged_, *place);
  }

  void released(Sandbox& sandbox) override {
    dragged_.reset();
    if (edited_) mend(sandbox, *std::exchange(edited_, {}));
  }

  bool keyPressed(Sandbox& sandbox, int key, int modifiers) override {
    if (!takesMouse(sandbox)) return false;
    if (key == GLFW_KEY_ESCAPE) {
      moving_ = false;
      return true;
    }
    if (!(modifiers & GLFW_MOD_CONTROL) || (key != GLFW_KEY_Z && key != GLFW_KEY_Y)) return false;
    const bool redo = key == GLFW_KEY_Y || (modifiers & GLFW_MOD_SHIFT);
    travel(sandbox, redo ? redo_ : undo_, redo ? undo_ : redo_);
    return true;
  }

  void drawInspector(Sandbox& sandbox) override {
    Sandbox::State& s = sandbox.state();
    shownAt_ = sandbox.frameNumber();
    const RigReport& report = rigged_->body.report;
    heading(s, "BODY");
    ImGui::Text("%s", fs::path(path_).filename().string().c_str());
    ImGui::TextColored(s.colours().textDim, "%s",
                       fmt::format("{} joints · {} vertices · pose {}", rigged_->body.skeleton.jointCount(),
                                   rigged_->mesh.positions.size(), report.pose)
                           .c_str());
    for (const std::string& repair : report.repairs)
      ImGui::TextWrapped("Mended for the fit: %s", repair.c_str());
    heading(s, "SKELETON");
    skeletonChoice(s);
    heading(s, "MEND");
    ImGui::Checkbox("Move joints", &moving_);
    tooltip(
        "The body stands as it was bound. Drag a joint in the plane of the view; when it is let go the skin "
        "is "
        "weighed anew. Escape ends it.");
    ImGui::BeginDisabled(!symmetricNames());
    ImGui::Checkbox("The other side as well", &mirrored_);
    ImGui::EndDisabled();
    tooltip("The partner moves to the mirrored place; joints of the middle stay in the middle.");
    if (ImGui::Button("Weigh anew")) weighAnew();
    tooltip("Heat weights for the skeleton as it stands; what was painted in Binding is given up.");
    const auto travelButton = [&](const char* label, std::vector<RiggedBody>& from,
                                  std::vector<RiggedBody>& to, const char* explanation) {
      ImGui::SameLine();
      ImGui::BeginDisabled(from.empty() || weighing_.valid());
      if (ImGui::Button(label)) travel(sandbox, from, to);
      ImGui::EndDisabled();
      tooltip(explanation);
    };
    travelButton("Undo", undo_, redo_,
                 "Takes the last moved joint back, weights included. Ctrl+Z while joints move.");
    travelButton("Redo", redo_, undo_, "Ctrl+Y while joints move.");
    ImGui::TextColored(
        s.colours().textDim, "%s",
        weighing_.valid() ? "Weighing ..." : fmt::format("Weights took {:.2f} s", weighSeconds_).c_str());
    heading(s, "CONFIDENCE");
    ImGui::Text("%.0f %%", 100.0 * report.confidence);
    for (const std::string& doubt : report.doubts) ImGui::TextWrapped("Doubtful: %s", doubt.c_str());
    ImGui::Checkbox("Colour the body by it", &coloured_);
    tooltip(
        "How near the fitted surface lies to the body around each joint: 0 (violet), look here, to 1 "
        "(yellow).");
    colourBar(s);
    leastSure(sandbox);
    ImGui::TextColored(s.colours().textDim, "%s",
                       brokenAtBlanks("Written to " + fs::path(rigged_->path).filename().string() +
                                          ", with axes and limits.",
                                      ImGui::GetContentRegionAvail().x)
                           .c_str());
  }

  void overlay(Sandbox& sandbox) override {
    if (rigged_ && sandbox.frameNumber() == shownAt_) {
      if (coloured_) sandbox.showVertexScalars(vertexConfidence());
      if (moving_) drawJoints(sandbox);
    }
    if (!asking_ && !working()) return;
    Sandbox::State& s = sandbox.state();
    const Layout::Rect& view = s.layout.view;
    ImGui::SetNextWindowPos({view.x + 0.5f * view.width, view.y + 0.4f * view.height}, ImGuiCond_Always,
                            {0.5f, 0.5f});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 9 * s.scale);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {20 * s.scale, 16 * s.scale});
    ImGui::PushStyleColor(ImGuiCol_WindowBg, s.colours().panelRaised);
    ImGui::Begin("##rig", nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoSavedSettings);
    const std::string file = fs::path(path_).filename().string();
    if (working())
      drawProgress(s, file);
    else
      drawQuestion(sandbox, file);
    ImGui::End();
    ImGui::PopStyleColor();
    ImGui::PopStyleVar(2);
  }

  std::string status() const override {
    if (!asking_ && !working() && !rigged_) return "";
    return fmt::format(
        "{{\"asking\": {}, \"working\": {}, \"weighing\": {}, \"moved\": {}, \"confidence\": {:.4f}}}",
        asking_, working(), weighing_.valid(), undo_.size(), rigged_ ? rigged_->body.report.confidence : 0.0);
  }

 private:
  bool working() const { return work_.valid(); }

  static double parsed(const std::string& word) {
    const auto value = parseNumber(word);
    if (!value) throw std::invalid_argument("a number was expected, not '" + word + "'");
    return *value;
  }

  void start(const Choice& choice) {
    if (working()) return;
    progress_ = std::make_shared<Progress>();
    asking_ = false;
    work_ = startWork([path = path_, choice, progress = progress_] { return rig(path, choice, *progress); });
  }

  /// Opens the body as it is now; the view stays where it was one before.
  void show(Sandbox& sandbox, Rigged rigged, bool again) {
    rigged_ = std::move(rigged);
    const RigGrips grips = rigGrips(rigged_->body.skeleton);
    Model model{.name = stem(path_),
                .skeleton = rigged_->body.skeleton,
                .skin = skinOf(*rigged_),
                .handles = grips.handles,
                .pins = grips.pins};
    const View view = sandbox.session().view();
    opening_ = true;
    sandbox.openModel(std::move(model), {.nameOrFile = rigged_->path});
    opening_ = false;
    if (again)
      sandbox.session().view() = view;
    else
      sandbox.state().preferences.opened(rigged_->path);
  }

  bool symmetricNames() const {
    try {
      mirrorPartners(rigged_->body.skeleton);
      return true;
    } catch (const std::invalid_argument&) {
      return false;
    }
  }

  Skeleton withJoint(int joint, const Eigen::Vector3d& place) const {
    const Skeleton& now = rigged_->body.skeleton;
    return mirrored_ && symmetricNames() ? withJointAt(now, joint, place, rigged_->body.report.middle)
                                         : withJointAt(now, joint, place);
  }

  void moveJoint(Sandbox& sandbox, int joint, const Eigen::Vector3d& place) {
    mend(sandbox, withJoint(joint, place));
  }

  void mend(Sandbox& sandbox, Skeleton skeleton) {
    if (weighing_.valid()) return;
    undo_.push_back(rigged_->body);
    if (undo_.size() > 50) undo_.erase(undo_.begin());
    redo_.clear();
    rigged_->body.skeleton = std::move(skeleton);
    show(sandbox, *rigged_, true);
    weighAnew();
  }

  void weighAnew() {
    if (weighing_.valid()) return;
    const auto begin = std::chrono::steady_clock::now();
    weighing_ = startWork([path = path_, rigged = *rigged_, begin, seconds = &weighSeconds_]() mutable {
      weigh(rigged.mesh, rigged.body);
      *seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      rigged.path = write(path, rigged.body.skeleton, skinOf(rigged));
      return rigged;
    });
  }

  void travel(Sandbox& sandbox, std::vector<RiggedBody>& from, std::vector<RiggedBody>& to) {
    if (from.empty() || weighing_.valid()) return sandbox.say("Nothing to undo or redo here");
    to.push_back(std::move(rigged_->body));
    rigged_->body = std::move(from.back());
    from.pop_back();
    write(path_, rigged_->body.skeleton, skinOf(*rigged_));
    show(sandbox, *rigged_, true);
  }

  std::optional<int> jointAt(Sandbox& sandbox, const Eigen::Vector2d& pixel) const {
    const Sandbox::State& s = sandbox.state();
    std::optional<int> best;
    double nearest = 14.0 * s.scale;
    const Frames rest = restFrames(rigged_->body.skeleton);
    for (int j = 0; j < static_cast<int>(rest.size()); ++j)
      if (const double d = (s.toWindow(rest[j].translation()).pixel - pixel).norm(); d < nearest)
        nearest = d, best = j;
    return best;
  }

  void drawJoints(Sandbox& sandbox) const {
    const Sandbox::State& s = sandbox.state();
    const Skeleton& skeleton = edited_ ? *edited_ : rigged_->body.skeleton;
    const Frames rest = restFrames(skeleton);
    const auto colour = [](const ImVec4& c, float alpha = 1.0f) { return Colour{c.x, c.y, c.z, alpha}; };
    const std::optional<int> hovered = dragged_ ? dragged_ : jointAt(sandbox, s.mouse);
    for (int j = 0; j < skeleton.jointCount(); ++j) {
      const Eigen::Vector3d at = rest[j].translation();
      if (const int parent = skeleton.parent(j); parent >= 0)
        sandbox.overlay().line(rest[parent].translation(), at, colour(s.colours().accent, 0.7f),
                               2.0f * s.scale);
      const bool unsure = rigged_->body.report.jointConfidence[j] < 0.5;
      sandbox.overlay().point(at, colour(unsure ? s.colours().warning : s.colours().accent),
                              (hovered == j ? 15.0f : 10.0f) * s.scale);
    }
    if (hovered)
      sandbox.label(rest[*hovered].translation(), skeleton.joint(*hovered).name,
                    {s.colours().text.x, s.colours().text.y, s.colours().text.z, 1.0f});
  }

  std::vector<float> vertexConfidence() const {
    std::vector<float> out;
    for (const auto& row : rigged_->body.weights) {
      double sum = 0.0;
      for (const auto& [joint, w] : row) sum += w * rigged_->body.report.jointConfidence[joint];
      out.push_back(static_cast<float>(sum));
    }
    return out;
  }

  void skeletonChoice(Sandbox::State&) {
    const Choice now = rigged_->choice;
    const char* names[] = {"Human", "18 joints of Pinocchio's human", "Four-legged"};
    const std::string shown =
        now.own.empty() ? names[static_cast<int>(now.skeleton)] : fs::path(now.own).filename().string();
    ImGui::SetNextItemWidth(-1);
    if (!ImGui::BeginCombo("##skeleton", shown.c_str())) {
      tooltip(
          "Another one is fitted to the same mesh at once. Skeletons of your own: BVH, ASF or the "
          "tutorial's, in the mesh's folder.");
      return;
    }
    for (int k = 0; k < 3; ++k)
      if (ImGui::Selectable(names[k], now.own.empty() && k == static_cast<int>(now.skeleton)))
        start({.skeleton = static_cast<RigTemplate>(k)});
    for (const std::string& file : skeletonsBeside(path_, false))
      if (ImGui::Selectable(fs::path(file).filename().string().c_str(), now.own == file))
        start({.own = file});
    ImGui::EndCombo();
  }

  /// The joints that want a look most.
  void leastSure(Sandbox& sandbox) const {
    const Skeleton& skeleton = rigged_->body.skeleton;
    const std::vector<double>& sure = rigged_->body.report.jointConfidence;
    std::vector<int> order(skeleton.jointCount());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, [&](int j) { return sure[j]; });
    for (std::size_t k = 0; k < std::min<std::size_t>(5, order.size()); ++k) {
      const std::string line =
          fmt::format("{}   {:.0f} %", skeleton.joint(order[k]).name, 100.0 * sure[order[k]]);
      if (ImGui::Selectable(line.c_str(), sandbox.selectedJoint() == order[k])) sandbox.select(order[k]);
    }
  }

  void openWith(Sandbox& sandbox, const std::string& skeleton) {
    asking_ = false;
    sandbox.open(ModelReference{.nameOrFile = path_, .files = {.skeleton = skeleton}});
  }

  void drawProgress(const Sandbox::State& s, const std::string& file) {
    std::string stage;
    double done = 0.0;
    {
      const std::scoped_lock hold(progress_->lock);
      stage = progress_->stage;
      done = progress_->done;
    }
    ImGui::Text("Rigging %s", file.c_str());
    ImGui::ProgressBar(static_cast<float>(done), {360 * s.scale, 0}, stage.c_str());
    if (ImGui::Button("Stop", {96 * s.scale, 0})) progress_->stop = true;
  }

  void drawQuestion(Sandbox& sandbox, const std::string& file) {
    Sandbox::State& s = sandbox.state();
    ImGui::PushFont(s.gui.fonts().medium);
    ImGui::Text("%s is a surface without a skeleton. Rig it?", file.c_str());
    ImGui::PopFont();
    ImGui::TextColored(
        s.colours().textDim, "%s",
        brokenAtBlanks("A template body is laid on the surface; its joints and weights are written "
                       "beside the file, as a .glb, and opened.",
                       380 * s.scale)
            .c_str());
    ImGui::Dummy({0, 2 * s.scale});
    if (ImGui::Button("Human", {120 * s.scale, 0})) start({.skeleton = RigTemplate::Human});
    ImGui::SameLine();
    if (ImGui::Button("Four-legged", {120 * s.scale, 0})) start({.skeleton = RigTemplate::Quadruped});
    ImGui::SameLine();
    if (ImGui::Button("18 joints", {120 * s.scale, 0})) start({.skeleton = RigTemplate::Pinocchio});
    tooltip("The joints of Pinocchio's human, as the exercise sheet has them.");
    if (!beside_.empty()) heading(s, "OR WITH A SKELETON THAT LIES BESIDE IT");
    const std::vector<std::string> beside = beside_;
    for (const std::string& skeleton : beside)
      if (ImGui::Selectable(fs::path(skeleton).filename().string().c_str())) openWith(sandbox, skeleton);
    ImGui::Dummy({0, 2 * s.scale});
    if (ImGui::Button("Cancel", {96 * s.scale, 0})) asking_ = false;
  }

  std::string path_;
  std::vector<std::string> beside_;
  bool asking_ = false;
  std::shared_ptr<Progress> progress_;
  std::future<Rigged> work_, weighing_;

  std::optional<Rigged> rigged_;         ///< what is open came from here
  std::vector<RiggedBody> undo_, redo_;  ///< before and after joints were moved
  bool opening_ = false, moving_ = false, mirrored_ = true, coloured_ = false;
  double weighSeconds_ = 0.0;  ///< written by the work, read when it is done
  int shownAt_ = -1000;        ///< frame in which the tab was last in front
  std::optional<int> dragged_;
  std::optional<Skeleton> edited_;  ///< while a joint is dragged
  Eigen::Vector3d grip_ = Eigen::Vector3d::Zero();
  Eigen::Vector2d offset_ = Eigen::Vector2d::Zero();  ///< from the mouse to the joint's pixel
};

}  // namespace

std::unique_ptr<Panel> makeRigPanel() { return std::make_unique<RigPanel>(); }

}  // namespace gelenk
