// A surface without a skeleton that is dropped on the window is offered one.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <future>
#include <mutex>

#include "apps/document/model_files.h"
#include "apps/sandbox/builtin_panels.h"
#include "apps/sandbox/sandbox_state.h"
#include "apps/sandbox/work.h"
#include "kinematics/io/pinocchio_skeleton.h"
#include "kinematics/io/word_stream.h"
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

struct Rigged {
  std::string path;  ///< of the .glb
  double confidence = 0.0;
  std::string doubts;
};

/// Beside the mesh where that can be written, else in the cache.
std::string writeRigged(const std::string& meshPath, const Skeleton& skeleton, const Skin& skin) {
  const fs::path mesh(meshPath);
  const fs::path beside = mesh.parent_path() / (mesh.stem().string() + "_rigged.glb");
  try {
    writeGltf(beside.string(), skeleton, &skin, {});
    return beside.string();
  } catch (const std::exception&) {
    const fs::path folder = fs::path(cacheFolder()) / "rigged";
    fs::create_directories(folder);
    const std::string path = (folder / beside.filename()).string();
    writeGltf(path, skeleton, &skin, {});
    return path;
  }
}

Rigged rig(const std::string& path, RigTemplate skeleton, Progress& progress) {
  const Mesh mesh = lowerCase(path).ends_with(".stl") ? readStl(path) : readMesh(path);
  const RiggedBody body =
      rigBody(mesh, {.skeleton = skeleton, .progress = [&](const std::string& stage, double done) {
                       const std::scoped_lock hold(progress.lock);
                       progress.stage = stage;
                       progress.done = done;
                       return !progress.stop;
                     }});
  const Skin skin =
      bindSkin(mesh, restFrames(body.skeleton), fourLargest(body.weights, body.skeleton.jointCount()));
  Rigged result{.path = {}, .confidence = body.report.confidence};
  for (const std::string& doubt : body.report.doubts)
    result.doubts += (result.doubts.empty() ? "" : "; ") + doubt;
  result.path = writeRigged(
      path, skeleton == RigTemplate::Pinocchio ? namedAsHuman(body.skeleton) : body.skeleton, skin);
  return result;
}

/// Files of skeletons in the mesh's folder, those of its name first.
std::vector<std::string> skeletonsBeside(const std::string& meshPath) {
  std::vector<std::string> found;
  std::error_code error;
  const fs::path mesh(meshPath);
  const fs::path folder = mesh.has_parent_path() ? mesh.parent_path() : fs::path(".");
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (fileKind(entry.path().string()) == FileKind::PinocchioSkeleton)
      found.push_back(entry.path().string());
  const std::string own = stem(meshPath);
  std::ranges::sort(found, [&](const std::string& a, const std::string& b) {
    const bool aOwn = stem(a) == own, bOwn = stem(b) == own;
    return aOwn != bOwn ? aOwn : a < b;
  });
  if (found.size() > 6) found.resize(6);
  return found;
}

class RigPanel final : public Panel {
 public:
  std::string name() const override { return "Rig"; }
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
    beside_ = skeletonsBeside(path);
    asking_ = true;
    sandbox.select(std::nullopt);
    return true;
  }

  /// "human", "pinocchio", "quadruped" rig the mesh that was dropped; "with FILE" takes a skeleton; "stop",
  /// "cancel".
  void act(Sandbox& sandbox, const std::vector<std::string>& words) override {
    if (words.size() == 1 && words[0] == "stop" && working())
      progress_->stop = true;
    else if (words.size() == 1 && words[0] == "cancel")
      asking_ = false;
    else if (!asking_)
      throw std::invalid_argument("no body waits for a skeleton: drop a mesh first");
    else if (words.size() == 2 && words[0] == "with")
      openWith(sandbox, words[1]);
    else if (words.size() == 1 && words[0] == "human")
      start(RigTemplate::Human);
    else if (words.size() == 1 && words[0] == "pinocchio")
      start(RigTemplate::Pinocchio);
    else if (words.size() == 1 && words[0] == "quadruped")
      start(RigTemplate::Quadruped);
    else
      throw std::invalid_argument("Rig takes human, pinocchio, quadruped, 'with FILE', stop and cancel");
  }

  double rests(const Sandbox&) const override {
    return working() ? 0.0 : std::numeric_limits<double>::infinity();
  }

  void step(Sandbox& sandbox, double) override {
    using namespace std::chrono_literals;
    if (!work_.valid() || work_.wait_for(0s) != std::future_status::ready) return;
    asking_ = false;
    try {
      const Rigged rigged = work_.get();
      sandbox.open(rigged.path);
      sandbox.say(fmt::format("Rigged, confidence {:.0f} %{}: drag it", 100.0 * rigged.confidence,
                              rigged.doubts.empty() ? "" : "; doubtful: " + rigged.doubts));
    } catch (const RigStopped&) {
      sandbox.say("Rigging was stopped");
    } catch (const std::exception& error) {
      sandbox.say(error.what(), true);
    }
  }

  void overlay(Sandbox& sandbox) override {
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
    return asking_ || working() ? fmt::format("{{\"asking\": {}, \"working\": {}}}", asking_, working()) : "";
  }

 private:
  bool working() const { return work_.valid(); }

  void start(RigTemplate skeleton) {
    progress_ = std::make_shared<Progress>();
    asking_ = false;
    work_ =
        startWork([path = path_, skeleton, progress = progress_] { return rig(path, skeleton, *progress); });
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
    if (ImGui::Button("Human", {120 * s.scale, 0})) start(RigTemplate::Human);
    ImGui::SameLine();
    if (ImGui::Button("Four-legged", {120 * s.scale, 0})) start(RigTemplate::Quadruped);
    ImGui::SameLine();
    if (ImGui::Button("18 joints", {120 * s.scale, 0})) start(RigTemplate::Pinocchio);
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
  std::future<Rigged> work_;
};

}  // namespace

std::unique_ptr<Panel> makeRigPanel() { return std::make_unique<RigPanel>(); }

}  // namespace gelenk
