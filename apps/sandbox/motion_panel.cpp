#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/model_files.h"
#include "apps/sandbox/builtin_panels.h"
#include "apps/sandbox/sandbox_state.h"
#include "kinematics/configuration.h"
#include "kinematics/io/text_file.h"
#include "kinematics/motion_edit.h"
#include "kinematics/rotation.h"
#include "skinning/io/gltf.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

Colour toColour(const ImVec4& c, float alpha = 1.0f) { return {c.x, c.y, c.z, alpha}; }

/// Plays the model's clip: timeline, trails, contacts, limits that are left, smoothing, planted feet, keys, goals on top, export.
class MotionPanel final : public Panel {
 public:
  std::string name() const override { return "Motion"; }
  bool hasInspector() const override { return true; }
  bool hasBottomStrip() const override { return true; }

  void modelChanged(Sandbox& sandbox) override {
    original_ = sandbox.session().model().clip;
    solver_.reset();
    seconds_ = 0.0;
    report_.clear();
    if (original_) {
      validate(sandbox.session().skeleton(), *original_);
      setClip(sandbox, *original_);
      sandbox.showInspector(name());
      sandbox.showBottomStrip(name());
      sandbox.setPlaying(true);
      lastRoot_ = onGround(sandbox, sandbox.session().frames()[0].translation());
    } else {
      clip_.reset();
    }
  }

  bool openFile(Sandbox& sandbox, const std::string& path) override {
    if (fileKind(path) != FileKind::Amc) return false;
    const ModelReference& reference = sandbox.state().reference;
    const bool isAsf = fileKind(reference.nameOrFile) == FileKind::Asf;
    const std::string asf = isAsf ? reference.nameOrFile : reference.asfFile;
    if (asf.empty()) throw std::invalid_argument("open the ASF skeleton of this motion first");
    ModelReference next = reference;
    next.amcFile = path;
    sandbox.open(next);
    return true;
  }

  void step(Sandbox& sandbox, double dt) override {
    if (!clip_ || !showing_) return;
    const double length = loop_ ? clip_->frameCount() / clip_->framesPerSecond : clip_->duration();
    if (sandbox.playing()) {
      seconds_ += speed_ * dt;
      if (loop_)
        seconds_ -= length * std::floor(seconds_ / length);
      else if (seconds_ < 0.0 || seconds_ > length)
        seconds_ = std::clamp(seconds_, 0.0, length), sandbox.setPlaying(false);
    }
    const Skeleton& skeleton = sandbox.session().skeleton();
    sample(skeleton, *clip_, seconds_, loop_ ? BeyondEnd::Loop : BeyondEnd::Stay, q_);
    if (goalsOnTop_) solveGoals(sandbox);
    forwardKinematics(skeleton, q_, frames_);
    if (follow_) followRoot(sandbox);
    sandbox.showFrames(frames_);
  }

  void overlay(Sandbox& sandbox) override {
    if (!clip_ || !showing_) return;
    const Palette& colours = sandbox.state().colours();
    const int frame = currentFrame();
    if (trails_) drawTrails(sandbox, frame);
    if (contactMarks_)
      for (const Contact& contact : contacts_) {
        const bool now = frame >= contact.first && frame <= contact.last;
        Vector3d at = tracks_[contact.foot][std::clamp(frame, contact.first, contact.last)];
        at.y() = sandbox.state().groundHeight + 0.002;
        const double r = 0.012 * sandbox.state().size;
        sandbox.overlayInScene().annulus(at, Vector3d::UnitX(), Vector3d::UnitZ(), 0.6 * r, r, toColour(now ? colours.held : colours.textFaint, now ? 0.95f : 0.5f));
      }
    if (limitMarks_)
      for (const int joint : outside_[frame]) sandbox.overlay().point(frames_[joint].translation(), toColour(colours.bad), 9.0f, Overlay::Shape::Ring);
  }

  bool keyPressed(Sandbox& sandbox, int key, int) override {
    constexpr int right = 262, left = 263, home = 268, end = 269;
    if (!clip_) return false;
    const int frame = currentFrame();
    if (key == right) return goTo(sandbox, frame + 1);
    if (key == left) return goTo(sandbox, frame - 1);
    if (key == home) return goTo(sandbox, 0);
    if (key == end) return goTo(sandbox, clip_->frameCount() - 1);
    return false;
  }

  void drawInspector(Sandbox& sandbox) override {
    const Palette& colours = sandbox.state().colours();
    if (!clip_) {
      ImGui::PushStyleColor(ImGuiCol_Text, colours.textDim);
      ImGui::TextWrapped("This model has no motion. Open a .bvh, .glb or .gltf, or start with --asf and --amc.");
      ImGui::PopStyleColor();
      return;
    }
    heading(sandbox.state(), "PLAYBACK");
    if (ImGui::Button(sandbox.playing() ? "Pause" : "Play", {90 * sandbox.scale(), 0})) sandbox.setPlaying(!sandbox.playing());
    ImGui::SameLine();
    ImGui::Checkbox("Loop", &loop_);
    ImGui::SameLine();
    ImGui::Checkbox("Follow", &follow_);
    ImGui::SetNextItemWidth(-90 * sandbox.scale());
    ImGui::SliderFloat("Speed", &speed_, -2.0f, 4.0f, "%.2f x");
    ImGui::SetNextItemWidth(-90 * sandbox.scale());
    float rate = static_cast<float>(clip_->framesPerSecond);
    if (ImGui::InputFloat("Frames/s", &rate, 0.0f, 0.0f, "%.3f", ImGuiInputTextFlags_EnterReturnsTrue) && rate > 0.0f && std::isfinite(rate)) {
      const int frame = currentFrame();
      clip_->framesPerSecond = original_->framesPerSecond = rate;
      seconds_ = frame / clip_->framesPerSecond;
    }
    ImGui::Checkbox("Show the motion", &showing_);
    heading(sandbox.state(), "SEEING");
    ImGui::Checkbox("Trails", &trails_);
    ImGui::SameLine();
    ImGui::Checkbox("Contacts", &contactMarks_);
    ImGui::SameLine();
    ImGui::Checkbox("Limits left", &limitMarks_);
    drawLimits(sandbox);
    heading(sandbox.state(), "EDIT");
    drawEdits(sandbox);
    heading(sandbox.state(), "GOALS ON TOP");
    ImGui::Checkbox("Hold pins and goals while it plays", &goalsOnTop_);
    heading(sandbox.state(), "EXPORT");
    ImGui::SetNextItemWidth(-70 * sandbox.scale());
    ImGui::InputText("##export", exportPath_, sizeof exportPath_);
    ImGui::SameLine();
    if (ImGui::Button("Write")) write(sandbox);
  }

  void drawBottomStrip(Sandbox& sandbox) override {
    Sandbox::State& s = sandbox.state();
    const Palette& colours = s.colours();
    const ImVec2 at = ImGui::GetCursorScreenPos(), size = ImGui::GetContentRegionAvail();
    if (!clip_) {
      ImGui::TextColored(colours.textDim, "No motion");
      return;
    }
    const float margin = 12 * s.scale, left = at.x + 84 * s.scale, width = std::max(1.0f, size.x - 84 * s.scale - margin);
    const int count = clip_->frameCount(), frame = currentFrame();
    const auto x = [&](double f) { return left + static_cast<float>(f / std::max(1, count - 1)) * width; };
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    ImGui::PushFont(s.gui.fonts().small);

    // Ruler: seconds
    const float ruler = at.y + 4 * s.scale, line = ImGui::GetFontSize() + 6 * s.scale;
    const double duration = std::max(clip_->duration(), 1e-9);
    double tick = std::pow(10.0, std::floor(std::log10(duration)));
    while (duration / tick < 5.0) tick /= 2.0;
    for (double t = 0.0; t <= duration + 1e-9; t += tick) {
      const float px = x(t * clip_->framesPerSecond);
      draw.AddLine({px, ruler + line - 5 * s.scale}, {px, at.y + size.y - 4 * s.scale}, colour32(colours.plotGrid));
      draw.AddText({px + 3 * s.scale, ruler}, colour32(colours.textDim), fmt::format("{:.3g} s", t).c_str());
    }
    // Rows: feet in contact, joints beyond their limits
    float y = ruler + line;
    const float row = std::min(20 * s.scale, (at.y + size.y - y - 4 * s.scale) / static_cast<float>(feet_.size() + 1));
    const auto label = [&](const char* words) { draw.AddText({at.x + 4 * s.scale, y + 0.5f * (row - ImGui::GetFontSize())}, colour32(colours.textDim), words); };
    for (std::size_t foot = 0; foot < feet_.size(); ++foot) {
      label(feet_[foot].name.c_str());
      draw.AddRectFilled({left, y + 2 * s.scale}, {left + width, y + row - 2 * s.scale}, colour32(colours.plotBackground), 3 * s.scale);
      for (const Contact& contact : contacts_)
        if (contact.foot == static_cast<int>(foot))
          draw.AddRectFilled({x(contact.first), y + 2 * s.scale}, {std::max(x(contact.last), x(contact.first) + 1), y + row - 2 * s.scale}, colour32(colours.held, 0.85f), 3 * s.scale);
      y += row;
    }
    label("limits left");
    draw.AddRectFilled({left, y + 2 * s.scale}, {left + width, y + row - 2 * s.scale}, colour32(colours.plotBackground), 3 * s.scale);
    const std::size_t most = std::max<std::size_t>(1, mostOutside_);
    for (int f = 0; f < count; ++f)
      if (!outside_[f].empty()) {
        const float share = static_cast<float>(outside_[f].size()) / static_cast<float>(most), bottom = y + row - 2 * s.scale;
        draw.AddRectFilled({x(f - 0.5), bottom - share * (row - 4 * s.scale)}, {x(f + 0.5) + 0.5f, bottom}, colour32(colours.bad, 0.75f));
      }
    y += row;

    // Playhead and scrubbing
    const float head = x(std::min<double>(seconds_ * clip_->framesPerSecond, count - 1));
    draw.AddLine({head, ruler}, {head, at.y + size.y - 4 * s.scale}, colour32(colours.accent), 2 * s.scale);
    draw.AddTriangleFilled({head - 5 * s.scale, ruler}, {head + 5 * s.scale, ruler}, {head, ruler + 7 * s.scale}, colour32(colours.accent));
    draw.AddText({at.x + 4 * s.scale, ruler}, colour32(colours.text), fmt::format("{} / {}", frame + 1, count).c_str());
    ImGui::PopFont();
    ImGui::SetCursorScreenPos({left, at.y});
    ImGui::InvisibleButton("##timeline", {width, std::max(1.0f, size.y)});
    if (ImGui::IsItemActive()) {
      const double f = (ImGui::GetIO().MousePos.x - left) / width * std::max(1, count - 1);
      seconds_ = std::clamp(f, 0.0, count - 1.0) / clip_->framesPerSecond;
      sandbox.setPlaying(false);
    }
  }

  std::string save() const override {
    return nlohmann::json{{"seconds", seconds_}, {"loop", loop_}, {"speed", speed_}, {"trails", trails_}, {"contacts", contactMarks_}, {"limits", limitMarks_}}.dump();
  }
  void load(Sandbox&, const std::string& text) override {
    const auto saved = nlohmann::json::parse(text);
    seconds_ = saved.value("seconds", 0.0);
    loop_ = saved.value("loop", true);
    speed_ = saved.value("speed", 1.0f);
    trails_ = saved.value("trails", true);
    contactMarks_ = saved.value("contacts", true);
    limitMarks_ = saved.value("limits", true);
    if (!std::isfinite(seconds_) || !std::isfinite(speed_)) seconds_ = 0.0, speed_ = 1.0f;
  }

 private:
  int currentFrame() const { return std::clamp(static_cast<int>(std::lround(seconds_ * clip_->framesPerSecond)), 0, clip_->frameCount() - 1); }

  bool goTo(Sandbox& sandbox, int frame) {
    seconds_ = std::clamp(frame, 0, clip_->frameCount() - 1) / clip_->framesPerSecond;
    sandbox.setPlaying(false);
    return true;
  }

  /// Everything that is known about a clip before it plays: ways of the ends, contacts, limits left. Once, not every frame.
  void setClip(Sandbox& sandbox, MotionClip clip) {
    const Skeleton& skeleton = sandbox.session().skeleton();
    clip_ = std::move(clip);
    feet_ = cmuFeet(skeleton);
    contacts_ = footContacts(skeleton, *clip_, feet_);
    trailJoints_.clear();
    for (const Foot& foot : feet_) trailJoints_.push_back(foot.ball);
    for (int i = skeleton.jointCount() - 1; i >= 0 && trailJoints_.size() < 8; --i)
      if (skeleton.children(i).empty() && std::none_of(feet_.begin(), feet_.end(), [&](const Foot& foot) { return skeleton.isAncestor(foot.ball, i); }))
        trailJoints_.push_back(i);
    tracks_.assign(trailJoints_.size(), {});
    outside_.assign(clip_->frameCount(), {});
    mostOutside_ = 0;
    Frames frames;
    Eigen::VectorXd q;
    for (int f = 0; f < clip_->frameCount(); ++f) {
      q = clip_->q.col(f);
      forwardKinematics(skeleton, q, frames);
      for (std::size_t k = 0; k < trailJoints_.size(); ++k) tracks_[k].push_back(frames[trailJoints_[k]].translation());
      for (int i = 0; i < skeleton.jointCount(); ++i)
        if (limitViolation(skeleton, q, i) > 1e-9) outside_[f].push_back(i);
      mostOutside_ = std::max(mostOutside_, outside_[f].size());
    }
  }

  void drawTrails(Sandbox& sandbox, int frame) {
    const Palette& colours = sandbox.state().colours();
    const int reach = std::max(1, static_cast<int>(0.6 * clip_->framesPerSecond));
    for (const auto& track : tracks_) {
      const int from = std::max(0, frame - reach), to = std::min(clip_->frameCount() - 1, frame + reach), step = std::max(1, reach / 40);
      for (int f = from; f + step <= to; f += step) {
        const float near = 1.0f - static_cast<float>(std::abs(f - frame)) / static_cast<float>(reach + 1);
        sandbox.overlayInScene().line(track[f], track[f + step], toColour(f < frame ? colours.accent : colours.textDim, 0.15f + 0.7f * near), 1.8f);
      }
    }
  }

  void drawLimits(Sandbox& sandbox) {
    const auto& outside = outside_[currentFrame()];
    const Palette& colours = sandbox.state().colours();
    if (outside.empty()) {
      ImGui::TextColored(colours.textDim, "No limit is left in this frame.");
      return;
    }
    const Skeleton& skeleton = sandbox.session().skeleton();
    const Eigen::VectorXd q = clip_->q.col(currentFrame());
    for (std::size_t k = 0; k < outside.size() && k < 6; ++k)
      ImGui::TextColored(colours.bad, "%s", fmt::format("{}  {:.1f}° beyond", skeleton.joint(outside[k]).name, limitViolation(skeleton, q, outside[k]) * 180.0 / M_PI).c_str());
    if (outside.size() > 6) ImGui::TextColored(colours.bad, "and %d more", static_cast<int>(outside.size()) - 6);
  }

  void drawEdits(Sandbox& sandbox) {
    const Skeleton& skeleton = sandbox.session().skeleton();
    ImGui::SetNextItemWidth(-90 * sandbox.scale());
    ImGui::SliderFloat("##cutoff", &cutoff_, 0.5f, 20.0f, "cut-off %.1f Hz");
    ImGui::SameLine();
    if (ImGui::Button("Smooth")) {
      try {
        setClip(sandbox, lowPassed(skeleton, *clip_, cutoff_));
        report_ = fmt::format("zero-phase low-pass at {:.1f} Hz", cutoff_);
      } catch (const std::exception& error) {
        sandbox.say(error.what(), true);
      }
    }
    ImGui::BeginDisabled(feet_.empty());
    if (ImGui::Button("Plant feet")) {
      const double floor = sandbox.state().groundHeight;
      const FootPlantOptions options{.floor = std::min(0.0, floor)};
      const FootFacts before = footFacts(skeleton, *clip_, feet_, contacts_, options.floor);
      const auto contacts = contacts_;
      setClip(sandbox, footPlanted(skeleton, *clip_, feet_, contacts, options));
      const FootFacts after = footFacts(skeleton, *clip_, feet_, contacts, options.floor);
      report_ = fmt::format("slide {:.2f} → {:.4f} mm a frame, penetration {:.2f} → {:.2f} mm", 1e3 * before.meanSlide, 1e3 * after.meanSlide, 1e3 * before.deepestPenetration,
                            1e3 * after.deepestPenetration);
    }
    ImGui::EndDisabled();
    ImGui::SameLine();
    if (ImGui::Button("Undo edits")) setClip(sandbox, *original_), report_.clear();
    const auto joint = sandbox.selectedJoint();
    ImGui::BeginDisabled(!joint);
    ImGui::SetNextItemWidth(-60 * sandbox.scale());
    ImGui::DragFloat3("##turn", keyDegrees_, 0.5f, -180.0f, 180.0f, "%.0f°");
    ImGui::SameLine();
    if (ImGui::Button("Key") && joint) {
      const double degree = M_PI / 180.0;
      const Eigen::Quaterniond turn = expRotation(degree * Vector3d(keyDegrees_[0], keyDegrees_[1], keyDegrees_[2]));
      const JointKey key{currentFrame(), (jointRotation(skeleton, clip_->q.col(currentFrame()), *joint) * turn).normalized()};
      setClip(sandbox, keyed(skeleton, *clip_, *joint, std::array{key}, 0.25));
      report_ = "keyed " + skeleton.joint(*joint).name + fmt::format(" in frame {}", key.frame + 1);
    }
    ImGui::EndDisabled();
    if (!joint) ImGui::TextColored(sandbox.state().colours().textDim, "Select a joint to key it.");
    if (!report_.empty()) ImGui::TextWrapped("%s", report_.c_str());
  }

  /// The clip's pose is the start and the wish; pins and held goals are reached from there.
  void solveGoals(Sandbox& sandbox) {
    const Session& session = sandbox.session();
    IkProblem problem{.skeleton = &session.skeleton(), .start = q_};
    for (const SceneGoal& goal : session.goals())
      if (goal.state != GoalState::Free) problem.goals.push_back(goal.goal);
    if (problem.goals.empty()) return;
    if (!solver_) solver_ = makeFrameSolver(session.solver(), session.skeleton());
    solver_->reset();
    const IkReport report = solver_->frame(problem);
    if (report.q.size() == q_.size() && report.q.allFinite()) q_ = report.q;
  }

  static Vector3d onGround(const Sandbox& sandbox, const Vector3d& p) {
    const Vector3d up = sandbox.session().model().up;
    return p - up * up.dot(p);
  }

  void followRoot(Sandbox& sandbox) {
    const Vector3d root = onGround(sandbox, frames_[0].translation());
    if (lastRoot_) sandbox.camera().target += root - *lastRoot_;
    lastRoot_ = root;
  }

  void write(Sandbox& sandbox) {
    try {
      const std::string path = exportPath_;
      const Model& model = sandbox.session().model();
      const auto kind = fileKind(path);
      if (kind == FileKind::Bvh)
        writeFile(path, formatBvh(model.skeleton, *clip_));
      else if (kind == FileKind::Amc)
        writeFile(path, formatAmc(model.skeleton, *clip_));
      else if (kind == FileKind::Gltf)
        writeGltf(path, model.skeleton, model.skin ? &*model.skin : nullptr, {{model.name, *clip_}});
      else
        throw std::invalid_argument("a motion can be written as .bvh, .amc, .glb or .gltf");
      sandbox.say("Wrote " + path);
    } catch (const std::exception& error) {
      sandbox.say(error.what(), true);
    }
  }

  std::optional<MotionClip> original_, clip_;
  double seconds_ = 0.0;
  float speed_ = 1.0f, cutoff_ = 6.0f;
  float keyDegrees_[3] = {0, 0, 0};
  bool loop_ = true, follow_ = true, showing_ = true, trails_ = true, contactMarks_ = true, limitMarks_ = true, goalsOnTop_ = false;
  char exportPath_[512] = "motion.glb";
  std::string report_;
  Eigen::VectorXd q_;
  Frames frames_;
  std::vector<Foot> feet_;
  std::vector<Contact> contacts_;
  std::vector<int> trailJoints_;
  std::vector<std::vector<Vector3d>> tracks_;  ///< of each trail joint, every frame; feet first
  std::vector<std::vector<int>> outside_;      ///< joints beyond their limits, every frame
  std::size_t mostOutside_ = 0;
  std::optional<Vector3d> lastRoot_;
  std::unique_ptr<FrameSolver> solver_;
};

}  // namespace

std::unique_ptr<Panel> makeMotionPanel() { return std::make_unique<MotionPanel>(); }

}  // namespace gelenk
