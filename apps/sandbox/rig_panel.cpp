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
#include "apps/document/surface.h"
#include "apps/sandbox/builtin_panels.h"
#include "apps/sandbox/sandbox_state.h"
#include "apps/sandbox/work.h"
#include "kinematics/io/pinocchio_skeleton.h"
#include "kinematics/io/text_file.h"
#include "kinematics/io/word_stream.h"
#include "kinematics/symmetry.h"
#include "skinning/io/gltf.h"
#include "skinning/io/skin_cache.h"
#include "skinning/rigging/auto_rig.h"

namespace gelenk {
namespace {

namespace fs = std::filesystem;

/// What the work in the background tells the window.
struct Progress {
  std::mutex lock;
  std::string file, stage = "reading";
  double done = 0.0;
  std::atomic<bool> stop = false;
};

/// Which skeleton is fitted: one of the program's, or a file with one of the user's.
struct Choice {
  RigTemplate skeleton = RigTemplate::Human;
  std::string own = {};
};

/// A surface that was dropped.
struct Dropped {
  std::string path;
  Surface surface;
};

/// A body that was rigged here. What undo goes through.
struct Rigged {
  std::shared_ptr<const Dropped> from;
  RiggedBody body;
  Choice choice;
};

struct Written {
  Rigged rigged;
  std::string path;  ///< of the .glb
};
struct Weighed {
  Written written;
  double seconds = 0.0;
};

Skin skinOf(const Rigged& rigged) {
  const Skeleton& skeleton = rigged.body.skeleton;
  return bindSkin(rigged.from->surface.mesh, restFrames(skeleton),
                  fourLargest(rigged.body.weights, skeleton.jointCount()));
}

/// Beside the mesh where that can be written, else in the cache. Returns where.
std::string write(const Rigged& rigged) {
  const Skin skin = skinOf(rigged);
  const auto into = [&](const fs::path& file) {
    writeGltf(file.string(), rigged.body.skeleton, &skin, {}, GltfJoints::AsTheyMove);
    return file.string();
  };
  const fs::path mesh(rigged.from->path);
  const std::string name = mesh.stem().string() + "_rigged.glb";
  try {
    return into(mesh.parent_path() / name);
  } catch (const std::exception&) {
    const fs::path folder = fs::path(cacheFolder()) / "rigged";
    fs::create_directories(folder);
    return into(folder / name);
  }
}

Rigged rig(std::shared_ptr<const Dropped> from, const Choice& choice, Progress& progress) {
  Rigged rigged{.from = std::move(from), .body = {}, .choice = choice};
  RigOptions options{.skeleton = choice.skeleton, .progress = [&](const std::string& stage, double done) {
                       const std::scoped_lock hold(progress.lock);
                       progress.stage = stage;
                       progress.done = done;
                       return !progress.stop;
                     }};
  if (!choice.own.empty()) options.own = openModelFile(choice.own).skeleton;
  rigged.body = rigBody(rigged.from->surface.mesh, options);
  rigged.body.skeleton = namedAsHuman(rigged.body.skeleton);
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
    if (!isSurfaceFile(path)) return false;
    if (working()) throw std::runtime_error("another body is being rigged: wait, or stop that first");
    asked_ = std::make_shared<const Dropped>(Dropped{path, readSurface(path)});
    fitted_ = isMesh(fileKind(path)) ? skeletonsBeside(path, true) : std::vector<std::string>();
    own_ = skeletonsBeside(path, false);
    sandbox.select(std::nullopt);
    return true;
  }

  /// "human", "pinocchio", "quadruped", "fit FILE" rig the mesh that was dropped, or the body that stands
  /// there anew; "with FILE" takes a skeleton as it is, "as-it-is" none; "stop", "cancel". "tool on|off",
  /// "mirrored on|off", "confidence on|off", "move JOINT X Y Z" (metres), "weigh", "undo", "redo" mend.
  void act(Sandbox& sandbox, const std::vector<std::string>& words) override {
    static const std::map<std::string, RigTemplate> templates{{"human", RigTemplate::Human},
                                                              {"pinocchio", RigTemplate::Pinocchio},
                                                              {"quadruped", RigTemplate::Quadruped}};
    const std::string command = words.empty() ? "" : words[0];
    const bool waits = asked_ || rigged_;
    if (command == "stop" && working()) {
      progress_->stop = true;
    } else if (command == "cancel") {
      asked_.reset();
    } else if (words.size() == 1 && templates.contains(command) && waits) {
      start({.skeleton = templates.at(command)});
    } else if (words.size() == 2 && command == "fit" && waits) {
      start({.own = words[1]});
    } else if (words.size() == 2 && command == "with" && asked_) {
      openWith(sandbox, words[1]);
    } else if (words.size() == 1 && command == "as-it-is" && asked_) {
      openAsItIs(sandbox);
    } else if (!rigged_) {
      throw std::invalid_argument("no body waits for a skeleton or has one from here: drop a mesh first");
    } else if (words.size() == 5 && command == "move") {
      moveJoint(sandbox, rigged_->body.skeleton.jointIndex(words[1]),
                {parsed(words[2]), parsed(words[3]), parsed(words[4])});
    } else if (words.size() == 2 && (words[1] == "on" || words[1] == "off") &&
               (command == "tool" || command == "mirrored" || command == "confidence")) {
      (command == "tool" ? moving_ : command == "mirrored" ? mirrored_ : coloured_) = words[1] == "on";
    } else if (command == "weigh") {
      weighByHand(sandbox);
    } else if (command == "undo" || command == "redo") {
      if (!takeBack(sandbox, command == "redo")) sandbox.say("Nothing to undo or redo here");
    } else {
      throw std::invalid_argument(
          "Rig takes human, pinocchio, quadruped, 'fit FILE', 'with FILE', as-it-is, stop, cancel; tool, "
          "mirrored and "
          "confidence on|off, 'move JOINT X Y Z', weigh, undo, redo");
    }
  }

  double rests(const Sandbox&) const override {
    constexpr double betweenLooks = 0.04;  // the work needs the processor more than its progress does
    return working() || weighing_.valid() ? betweenLooks : std::numeric_limits<double>::infinity();
  }

  void opened(Sandbox&, bool) override {
    if (opening_) return;
    rigged_.reset();
    undo_.clear();
    redo_.clear();
    moving_ = false;
    dragged_.reset();
    edited_.reset();
  }

  void step(Sandbox& sandbox, double) override {
    const bool handsOff =
        sandbox.state().gesture.kind == Gesture::Kind::None;  // nothing changes under a drag
    if (handsOff && isReady(work_)) takeRig(sandbox);
    if (handsOff && isReady(weighing_)) takeWeights(sandbox);
    if (handsOff && edited_ && !weighing_.valid()) mend(sandbox, *std::exchange(edited_, {}));
    if (takesMouse(sandbox)) sandbox.showFrames(bindFrames(sandbox.session().model()));
  }

  bool takesMouse(const Sandbox& sandbox) const override {
    return rigged_ && moving_ && sandbox.frameNumber() - shownAt_ <= 1;
  }

  std::string mouseHint() const override {
    return "Drag a joint: let go, and the skin is weighed anew · drag the ground to orbit · Esc ends it";
  }

  bool pressed(Sandbox& sandbox, const Eigen::Vector2d& pixel) override {
    if (edited_ || work_.valid()) return false;  // the last one waits for its weights
    dragged_ = jointAt(sandbox, pixel);
    if (!dragged_) return false;
    sandbox.select(*dragged_);
    grip_ = restFrames(rigged_->body.skeleton)[*dragged_].translation();
    offset_ = sandbox.state().toWindow(grip_).pixel - pixel;
    return true;
  }

  void moved(Sandbox& sandbox, const Eigen::Vector2d& pixel) override {
    const Sandbox::State& s = sandbox.state();
    if (!dragged_) return;
    if (const auto place =
            dragTarget(s.camera(), s.viewport(), s.toView(pixel + offset_), grip_, DragConstraint::ViewPlane))
      edited_ = withJoint(*dragged_, *place);
  }

  void released(Sandbox&) override { dragged_.reset(); }  // step mends

  bool keyPressed(Sandbox& sandbox, int key, int modifiers) override {
    if (!takesMouse(sandbox)) return false;
    if (key == GLFW_KEY_ESCAPE) {
      if (!dragged_) moving_ = false;
      dragged_.reset();
      edited_.reset();
      return true;
    }
    if (!(modifiers & GLFW_MOD_CONTROL) || (key != GLFW_KEY_Z && key != GLFW_KEY_Y)) return false;
    const bool redo = key == GLFW_KEY_Y || (modifiers & GLFW_MOD_SHIFT);
    if (!takeBack(sandbox, redo)) sandbox.say(redo ? "Nothing to redo" : "Nothing to undo");
    return true;
  }

  bool canTakeBack(bool redo) const override { return rigged_ && !(redo ? redo_ : undo_).empty(); }

  bool takeBack(Sandbox& sandbox, bool redo) override {
    std::vector<Rigged>&from = redo ? redo_ : undo_, &to = redo ? undo_ : redo_;
    if (weighing_.valid()) takeWeights(sandbox);  // waits for them: a quarter of a second
    if (!rigged_ || from.empty() || dragged_) return false;
    to.push_back(std::move(*rigged_));
    Rigged next = std::move(from.back());
    from.pop_back();
    writtenTo_ = write(next);
    show(sandbox, std::move(next), true);
    return true;
  }

  void drawInspector(Sandbox& sandbox) override {
    Sandbox::State& s = sandbox.state();
    shownAt_ = sandbox.frameNumber();
    const RigReport& report = rigged_->body.report;
    heading(s, "BODY");
    ImGui::Text("%s", fs::path(rigged_->from->path).filename().string().c_str());
    ImGui::TextColored(s.colours().textDim, "%s",
                       fmt::format("{} joints · {} vertices · pose {}", rigged_->body.skeleton.jointCount(),
                                   rigged_->from->surface.mesh.positions.size(), report.pose)
                           .c_str());
    for (const std::string& repair : report.repairs) wrappedText("Mended for the fit: " + repair);
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
    ImGui::BeginDisabled(weighing_.valid());
    if (ImGui::Button("Weigh anew")) weighByHand(sandbox);
    ImGui::EndDisabled();
    tooltip("Heat weights for the skeleton as it stands; what was painted in Binding is given up.");
    const auto travelButton = [&](const char* label, bool redo, const char* explanation) {
      ImGui::SameLine();
      ImGui::BeginDisabled(!canTakeBack(redo));
      if (ImGui::Button(label)) takeBack(sandbox, redo);
      ImGui::EndDisabled();
      tooltip(explanation);
    };
    travelButton("Undo", false,
                 "Takes the last moved joint, other skeleton or new weights back. Ctrl+Z, where nothing was "
                 "done to the body since.");
    travelButton("Redo", true, "Ctrl+Y.");
    ImGui::TextColored(
        s.colours().textDim, "%s",
        weighing_.valid() ? "Weighing ..." : fmt::format("Weights took {:.2f} s", weighSeconds_).c_str());
    heading(s, "CONFIDENCE");
    ImGui::Text("%.0f %%", 100.0 * report.confidence);
    for (const std::string& doubt : report.doubts) wrappedText("Doubtful: " + doubt);
    ImGui::Checkbox("Colour the body by it", &coloured_);
    tooltip(
        "How near the fitted surface lies to the body around each joint: 0 (violet), look here, to 1 "
        "(yellow).");
    colourBar(s, "0, look here", "1");
    leastSure(sandbox);
    wrappedText(s.colours().textDim,
                "Written to " + fs::path(writtenTo_).filename().string() + ", with axes and limits.");
  }

  void overlay(Sandbox& sandbox) override {
    if (rigged_ && sandbox.frameNumber() == shownAt_) {
      if (coloured_) sandbox.showVertexScalars(vertexConfidence());
      if (moving_) drawJoints(sandbox);
    }
    if (!asked_ && !working()) return;
    Sandbox::State& s = sandbox.state();
    const Layout::Rect& view = s.layout.view;
    ImGui::SetNextWindowPos({view.x + 0.5f * view.width, view.y + 0.4f * view.height}, ImGuiCond_Always,
                            {0.5f, 0.5f});
    pushFloating(s);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {20 * s.scale, 16 * s.scale});
    ImGui::Begin("##rig", nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoSavedSettings);
    dropShadow(s);
    if (working())
      drawProgress(s);
    else
      drawQuestion(sandbox);
    ImGui::End();
    ImGui::PopStyleVar();
    popFloating();
  }

  std::string status() const override {
    if (!asked_ && !working() && !rigged_) return "";
    return fmt::format(
        "{{\"asking\": {}, \"working\": {}, \"weighing\": {}, \"moved\": {}, \"confidence\": {:.4f}}}",
        asked_ != nullptr, working(), weighing_.valid(), undo_.size(),
        rigged_ ? rigged_->body.report.confidence : 0.0);
  }

 private:
  bool working() const { return work_.valid(); }

  static double parsed(const std::string& word) {
    const auto value = parseNumber(word);
    if (!value) throw std::invalid_argument("a number was expected, not '" + word + "'");
    return *value;
  }

  template <class Work>
  static bool isReady(const Work& work) {
    return work.valid() && work.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  }

  void start(const Choice& choice) {
    if (working()) return;
    const std::shared_ptr<const Dropped> from = asked_ ? std::exchange(asked_, nullptr) : rigged_->from;
    progress_ = std::make_shared<Progress>();
    progress_->file = fs::path(from->path).filename().string();
    work_ = startWork([from, choice, progress = progress_] {
      Rigged rigged = rig(from, choice, *progress);
      return Written{rigged, write(rigged)};
    });
  }

  void takeRig(Sandbox& sandbox) {
    if (weighing_.valid()) takeWeights(sandbox);  // of the skeleton before, for undo
    try {
      Written done = work_.get();
      sandbox.whenSaved([this, done = std::move(done)](Sandbox& box) {
        const bool again = rigged_ && rigged_->from == done.rigged.from;
        if (again)
          remember(box);
        else
          undo_.clear(), redo_.clear();
        moving_ = moving_ && again;
        writtenTo_ = done.path;
        const RigReport report = done.rigged.body.report;
        weighSeconds_ = report.stages.back().seconds;
        show(box, done.rigged, again);
        std::string doubts;
        for (const std::string& doubt : report.doubts)
          doubts += (doubts.empty() ? "; doubtful: " : "; ") + doubt;
        box.say(fmt::format("Rigged, confidence {:.0f} %{}: drag it, or mend it in the tab Rig",
                            100.0 * report.confidence, doubts));
      });
    } catch (const RigStopped&) {
      sandbox.say("Rigging was stopped");
    } catch (const std::exception& error) {
      sandbox.say(error.what(), true);
    }
  }

  void takeWeights(Sandbox& sandbox) {
    try {
      Weighed done = weighing_.get();
      weighSeconds_ = done.seconds;
      if (!rigged_ || rigged_->from != done.written.rigged.from) return;  // another body stands there now
      writtenTo_ = done.written.path;
      show(sandbox, std::move(done.written.rigged), true);
    } catch (const std::exception& error) {
      sandbox.say(error.what(), true);
    }
  }

  /// Opens the body as it is now. again: it stood here before; view, solver and skin stay as they were.
  void show(Sandbox& sandbox, Rigged rigged, bool again) {
    rigged_ = std::move(rigged);
    const RigGrips grips = rigGrips(rigged_->body.skeleton);
    Model model{.name = stem(rigged_->from->path),
                .skeleton = rigged_->body.skeleton,
                .skin = skinOf(*rigged_),
                .look = rigged_->from->surface.look,
                .handles = grips.handles,
                .pins = grips.pins};
    const Document before = sandbox.session().document();
    const std::optional<int> selected = sandbox.selectedJoint();
    opening_ = true;
    sandbox.openModel(std::move(model), {.nameOrFile = writtenTo_});
    opening_ = false;
    if (!again) return sandbox.state().preferences.opened(writtenTo_);
    Session& session = sandbox.session();
    session.view() = before.view;
    session.setSolver(before.solver.name);
    session.chooseSkin(before.skin);
    if (selected && *selected < session.skeleton().jointCount()) sandbox.select(selected);
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

  /// What stands here, painted weights included, goes where undo finds it.
  void remember(const Sandbox& sandbox) {
    const std::vector<Influences>& now = sandbox.session().skin()->influences;
    const std::vector<Influences> own = skinOf(*rigged_).influences;
    const auto same = [](const Influences& a, const Influences& b) {
      return a.joints == b.joints && a.weights == b.weights;
    };
    if (!std::ranges::equal(now, own, same))
      for (std::size_t v = 0; v < now.size(); ++v) {
        rigged_->body.weights[v].clear();
        for (int k = 0; k < 4; ++k)
          if (now[v].weights[k] > 0.0)
            rigged_->body.weights[v].emplace_back(now[v].joints[k], now[v].weights[k]);
      }
    undo_.push_back(*rigged_);
    if (undo_.size() > 50) undo_.erase(undo_.begin());
    redo_.clear();
  }

  void mend(Sandbox& sandbox, Skeleton skeleton) {
    if (weighing_.valid() || !rigged_) return;
    remember(sandbox);
    Rigged mended = *rigged_;
    mended.body.skeleton = std::move(skeleton);
    show(sandbox, std::move(mended), true);
    weighAnew();
  }

  void weighByHand(Sandbox& sandbox) {
    if (weighing_.valid()) return;
    remember(sandbox);
    weighAnew();
  }

  void weighAnew() {
    weighing_ = startWork([rigged = *rigged_]() mutable {
      const auto begin = std::chrono::steady_clock::now();
      weigh(rigged.from->surface.mesh, rigged.body);
      const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      std::string path = write(rigged);
      return Weighed{{std::move(rigged), std::move(path)}, seconds};
    });
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
    std::vector<Eigen::Vector2d> pixels;
    for (const Eigen::Isometry3d& frame : rest) pixels.push_back(s.toWindow(frame.translation()).pixel);
    const auto nearest = [&](int joint) {  // fingers' dots are small where they would cover each other
      double least = std::numeric_limits<double>::infinity();
      for (std::size_t k = 0; k < pixels.size(); ++k)
        if (static_cast<int>(k) != joint) least = std::min(least, (pixels[k] - pixels[joint]).norm());
      return static_cast<float>(least);
    };
    for (int j = 0; j < skeleton.jointCount(); ++j) {
      const Eigen::Vector3d at = rest[j].translation();
      if (const int parent = skeleton.parent(j); parent >= 0)
        sandbox.overlay().line(rest[parent].translation(), at, colour(s.colours().accent, 0.7f), 2.0f);
      const bool unsure = rigged_->body.report.jointConfidence[j] < 0.5;
      const float size = std::clamp(0.7f * nearest(j) / s.scale, 4.0f, 10.0f);  // at scale 1, as all widths
      sandbox.overlay().point(at, colour(unsure ? s.colours().warning : s.colours().accent),
                              hovered == j ? 1.5f * size : size);
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
    for (const std::string& file : skeletonsBeside(rigged_->from->path, false))
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
    sandbox.open(
        ModelReference{.nameOrFile = std::exchange(asked_, nullptr)->path, .files = {.skeleton = skeleton}});
  }

  void openAsItIs(Sandbox& sandbox) {
    const ModelReference reference{.nameOrFile = std::exchange(asked_, nullptr)->path};
    sandbox.openModel(readModel(reference), reference);
  }

  void drawProgress(const Sandbox::State& s) {
    std::string stage;
    double done = 0.0;
    {
      const std::scoped_lock hold(progress_->lock);
      stage = progress_->stop ? "stopping" : progress_->stage;
      done = progress_->done;
    }
    ImGui::Text("Rigging %s", progress_->file.c_str());
    ImGui::ProgressBar(static_cast<float>(done), {360 * s.scale, 0}, stage.c_str());
    if (ImGui::Button("Stop", {96 * s.scale, 0}) || ImGui::IsKeyPressed(GLFW_KEY_ESCAPE))
      progress_->stop = true;
  }

  void drawQuestion(Sandbox& sandbox) {
    Sandbox::State& s = sandbox.state();
    const bool listens = s.dialog == Sandbox::State::Dialog::None && !s.palette.isOpen();
    const auto button = [&](const char* name, const char* explanation) {
      const bool pressed = ImGui::Button(name, {120 * s.scale, 0});
      tooltip(explanation);
      return pressed;
    };
    const std::shared_ptr<const Dropped> asked = asked_;
    ImGui::PushFont(s.gui.fonts().medium);
    ImGui::Text("%s is a surface without a skeleton. Rig it?",
                fs::path(asked->path).filename().string().c_str());
    ImGui::PopFont();
    ImGui::TextColored(
        s.colours().textDim, "%s",
        brokenAtBlanks("A template body is laid on the surface; its joints and weights are written "
                       "beside the file, as a .glb, and opened.",
                       380 * s.scale)
            .c_str());
    ImGui::Dummy({0, 2 * s.scale});
    if (button("Human", "People and figures like them, fingers where they stand free. Enter.") ||
        (listens && ImGui::IsKeyPressed(GLFW_KEY_ENTER)))
      start({.skeleton = RigTemplate::Human});
    ImGui::SameLine();
    if (button("Four-legged", "Horses, cattle, dogs and the like."))
      start({.skeleton = RigTemplate::Quadruped});
    ImGui::SameLine();
    if (button("18 joints", "The joints of Pinocchio's human, as the exercise sheet has them."))
      start({.skeleton = RigTemplate::Pinocchio});
    const auto list = [&](const char* title, const std::vector<std::string>& files) {
      if (!files.empty()) heading(s, title);
      std::string chosen;
      for (const std::string& file : files)
        if (ImGui::Selectable((fs::path(file).filename().string() + "##" + title).c_str())) chosen = file;
      return chosen;
    };
    if (const std::string chosen = list("OR WITH A SKELETON THAT WAS FITTED ALREADY", fitted_);
        !chosen.empty())
      openWith(sandbox, chosen);
    if (const std::string chosen = list("OR FIT ONE OF YOUR OWN", own_); !chosen.empty())
      start({.own = chosen});
    ImGui::Dummy({0, 2 * s.scale});
    if (ImGui::Button("Cancel", {96 * s.scale, 0}) || (listens && ImGui::IsKeyPressed(GLFW_KEY_ESCAPE)))
      asked_.reset();
    if (fileKind(asked->path) != FileKind::Gltf) return;
    ImGui::SameLine();
    if (button("Open as it is", "Stiff, without a skeleton.")) openAsItIs(sandbox);
  }

  std::shared_ptr<const Dropped> asked_;   ///< waits for an answer
  std::vector<std::string> fitted_, own_;  ///< skeletons beside it
  std::shared_ptr<Progress> progress_;
  std::future<Written> work_;
  std::future<Weighed> weighing_;

  std::optional<Rigged> rigged_;  ///< what is open came from here
  std::string writtenTo_;         ///< the .glb
  std::vector<Rigged> undo_, redo_;
  bool opening_ = false, moving_ = false, mirrored_ = true, coloured_ = false;
  double weighSeconds_ = 0.0;
  int shownAt_ = -1000;  ///< frame in which the tab was last in front
  std::optional<int> dragged_;
  std::optional<Skeleton> edited_;  ///< while a joint is dragged, and until the weights before it are there
  Eigen::Vector3d grip_ = Eigen::Vector3d::Zero();
  Eigen::Vector2d offset_ = Eigen::Vector2d::Zero();  ///< from the mouse to the joint's pixel
};

}  // namespace

std::unique_ptr<Panel> makeRigPanel() { return std::make_unique<RigPanel>(); }

}  // namespace gelenk
