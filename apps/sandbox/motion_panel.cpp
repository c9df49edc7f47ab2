#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/document/clip_editor.h"
#include "apps/document/second_clip.h"
#include "apps/sandbox/builtin_panels.h"
#include "apps/sandbox/sandbox_state.h"
#include "apps/sandbox/timeline.h"
#include "kinematics/configuration.h"
#include "kinematics/io/text_file.h"
#include "kinematics/motion/motion_edit.h"
#include "kinematics/rotation.h"
#include "skinning/io/gltf.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

/// The words of a command, read one by one; complains in words.
class CommandWords {
 public:
  explicit CommandWords(const std::vector<std::string>& words) : words_(words) {}
  bool atEnd() const { return at_ == words_.size(); }
  std::string word() {
    if (atEnd())
      throw std::invalid_argument("a word is missing after '" +
                                  (words_.empty() ? std::string("do Motion") : words_.back()) + "'");
    return words_[at_++];
  }
  bool take(const std::string& wanted) {
    const bool found = !atEnd() && words_[at_] == wanted;
    at_ += found;
    return found;
  }
  double number() { return *read(parseNumber(word()), "a number"); }
  int integer() { return *read(parseInteger(word()), "an integer"); }
  /// All that are left.
  std::vector<int> joints(const Skeleton& skeleton) {
    std::vector<int> joints;
    while (!atEnd()) joints.push_back(skeleton.jointIndex(word()));
    return joints;
  }

 private:
  template <class T>
  const std::optional<T>& read(const std::optional<T>& value, const char* what) const {
    if (!value)
      throw std::invalid_argument(std::string("expected ") + what + ", found '" + words_[at_ - 1] + "'");
    return value;
  }
  const std::vector<std::string>& words_;
  std::size_t at_ = 0;
};

/// Plays the model's clip: timeline, trails, contacts, limits that are left, edits (clip_editor.h), goals on
/// top, export.
///
/// While it plays, the clip is shown as it is. At rest the session stands in the clip's pose, and the first
/// drag, turn or undo of that pose takes over until the playhead moves: that pose can be keyed.
class MotionPanel final : public Panel {
 public:
  std::string name() const override { return "Motion"; }
  bool hasInspector() const override { return true; }
  bool hasBottomStrip() const override { return true; }
  std::string stripTitle() const override { return "Timeline"; }

  void opened(Sandbox& sandbox, bool fromFile) override {
    play_ = &sandbox.session().playback();
    head_ = &sandbox.session().playhead();
    solver_.reset();
    editor_.reset();
    leavePose();
    if (!sandbox.session().model().clip) return;
    editor_.emplace(sandbox.session().skeleton(), *sandbox.session().model().clip);
    editor_->setEdits(sandbox.session().edits().clip);
    jumps_ = sandbox.session().jumps();
    sandbox.showInspector(name());
    sandbox.showBottomStrip(name());
    sandbox.setPlaying(!fromFile);
    lastRoot_ = onGround(sandbox, sandbox.session().frames()[0].translation());
    if (sandbox.state().view->standsOnMotion())
      lastRoot_ = onGround(sandbox,
                           forwardKinematics(sandbox.session().skeleton(), clip().q.col(0))[0].translation());
    if (fromFile) takeUpPose(sandbox);
  }

  /// What is shown is what is kept: the clip's pose, where that is seen.
  void store(const Sandbox& sandbox, Document& document) const override {
    if (editor_ && play_->showing && !isPosed(sandbox) && q_.size() == document.edits.q.size())
      document.edits.q = q_;
  }

  bool openFile(Sandbox& sandbox, const std::string& path) override {
    if (fileKind(path) != FileKind::Amc) return false;
    const ModelReference& reference = sandbox.state().session->document().model;
    const bool isAsf = fileKind(reference.nameOrFile) == FileKind::Asf;
    if (!isAsf && reference.files.asf.empty()) return false;  // opened with the ASF that lies beside it
    ModelReference next = reference;
    (fileKind(reference.nameOrFile) == FileKind::Amc ? next.nameOrFile : next.files.amc) = path;
    sandbox.openModel(readModel(next), next);
    return true;
  }

  void step(Sandbox& sandbox, double dt) override {
    if (!editor_) return;
    followEdits(sandbox);
    if (!play_->showing) return sandbox.session().setPosture(sandbox.session().skeleton().rest());
    if (sandbox.playing()) advance(sandbox, play_->speed * dt);
    placeHead(sandbox);
    const bool resting = !sandbox.playing() && !play_->goalsOnTop;
    resting ? restAt(sandbox) : leavePose();
    if (isPosed(sandbox)) return;  // the session's own pose is shown
    forwardKinematics(sandbox.session().skeleton(), q_, frames_);
    if (play_->follow) followRoot(sandbox);
    sandbox.showFrames(frames_, resting);
  }

  double rests(const Sandbox& sandbox) const override {
    return editor_ && play_->showing && sandbox.playing() ? 0.0 : std::numeric_limits<double>::infinity();
  }

  bool keyPressed(Sandbox& sandbox, int key, int) override {
    if (!editor_) return false;
    const int frame = currentFrame();
    if (key == GLFW_KEY_RIGHT) return goTo(sandbox, frame + 1);
    if (key == GLFW_KEY_LEFT) return goTo(sandbox, frame - 1);
    if (key == GLFW_KEY_HOME) return goTo(sandbox, 0);
    if (key == GLFW_KEY_END) return goTo(sandbox, editor_->clip().frameCount() - 1);
    if (key == GLFW_KEY_K) return tried(sandbox, [&] { keyMoved(sandbox); });
    return false;
  }

  void act(Sandbox& sandbox, const std::vector<std::string>& words) override {
    if (!editor_) throw std::invalid_argument("the model has no motion");
    CommandWords w(words);
    const std::string command = w.word();
    const Skeleton& skeleton = sandbox.session().skeleton();
    if (command == "frame") {
      goTo(sandbox, w.integer() - 1);
    } else if (command == "key") {
      w.atEnd() ? keySelected(sandbox) : keyJoints(sandbox, w.joints(skeleton));
    } else if (command == "key-moved") {
      keyMoved(sandbox);
    } else if (command == "delete-key") {
      edit(sandbox, [&] { editor_->removeKeys(currentFrame()); });
    } else if (command == "move-key") {
      const int from = w.integer() - 1, to = w.integer() - 1;
      edit(sandbox, [&] { editor_->moveKeys(from, to); });
    } else if (command == "turn") {
      const double x = w.number(), y = w.number();
      turnSelected(sandbox, {x, y, w.number()});
    } else if (command == "smooth") {
      smooth(sandbox, w.number());
    } else if (command == "plant") {
      plantFeet(sandbox);
    } else if (command == "fade") {
      const std::string file = w.word();
      fade(sandbox, file, w.number());
    } else if (command == "layer") {
      const std::string file = w.word();
      const double weight = w.number();
      const bool additive = w.take("additive");
      lay(sandbox, file, weight, additive,
          w.atEnd() ? std::vector<int>{} : limbBelow(skeleton, w.joints(skeleton).front()));
    } else if (command == "undo") {
      undoOrRedo(sandbox, false);
    } else if (command == "redo") {
      undoOrRedo(sandbox, true);
    } else if (command == "goals") {
      play_->goalsOnTop = w.take("on");
    } else if (command == "write") {
      write(sandbox, w.word());
    } else {
      throw std::invalid_argument(
          "the panel Motion knows frame N, key [JOINT...], key-moved, delete-key, move-key FROM TO, turn X Y "
          "Z, smooth HZ, plant, fade FILE SECONDS, "
          "layer FILE WEIGHT [additive] [JOINT], undo, redo, goals on|off and write FILE, not '" +
          command + "'");
    }
  }

  /// The motions of a file that holds several.
  static void clipChoice(Sandbox& sandbox) {
    const Model& model = sandbox.session().model();
    if (model.clipNames.size() < 2) return;
    heading(sandbox.state(), fmt::format("CLIP, ONE OF {}", model.clipNames.size()).c_str());
    if (!ImGui::BeginCombo("##clip", model.clipName.c_str(), ImGuiComboFlags_HeightLarge)) return;
    for (const std::string& name : model.clipNames)
      if (ImGui::Selectable(name.c_str(), name == model.clipName)) {
        ModelReference reference = sandbox.session().document().model;
        reference.files.clip = name;
        sandbox.state().afterFrame = [reference](Sandbox& box) {
          const Camera camera = box.camera();
          if (box.open(reference)) box.camera() = camera, box.setPlaying(true);
        };
      }
    ImGui::EndCombo();
  }

  void drawInspector(Sandbox& sandbox) override {
    const Palette& colours = sandbox.state().colours();
    if (!editor_) {
      wrappedText(colours.textDim,
                  "This model has no motion. Open a .bvh, .glb, .gltf or .amc; an .asf beside it is found.");
      return;
    }
    clipChoice(sandbox);
    heading(sandbox.state(), "PLAYBACK");
    if (ImGui::Button(sandbox.playing() ? "Pause" : "Play", {90 * sandbox.scale(), 0}))
      sandbox.setPlaying(!sandbox.playing());
    ImGui::SameLine();
    ImGui::Checkbox("Loop", &play_->loop);
    ImGui::SameLine();
    ImGui::Checkbox("Follow", &play_->follow);
    ImGui::SetNextItemWidth(-90 * sandbox.scale());
    float speed = static_cast<float>(play_->speed);
    if (valueSlider("Speed", speed, -2.0f, 4.0f, "%.2f x")) play_->speed = speed;
    ImGui::SetNextItemWidth(-90 * sandbox.scale());
    float rate = static_cast<float>(editor_->clip().framesPerSecond);
    if (ImGui::InputFloat("Frames/s", &rate, 0.0f, 0.0f, "%.3f", ImGuiInputTextFlags_EnterReturnsTrue) &&
        rate > 0.0f && std::isfinite(rate)) {
      const int frame = currentFrame();
      edit(sandbox, [&] { editor_->setFrameRate(rate); });
      (*head_) = frame / editor_->clip().framesPerSecond;
    }
    ImGui::Checkbox("Show the motion", &play_->showing);
    heading(sandbox.state(), "SEEING");
    ImGui::Checkbox("Trails", &play_->trails);
    ImGui::SameLine();
    ImGui::Checkbox("Contacts", &play_->contacts);
    ImGui::SameLine();
    ImGui::Checkbox("Limits left", &play_->limits);
    drawLimits(sandbox);
    heading(sandbox.state(), "EDIT");
    drawEdits(sandbox);
    heading(sandbox.state(), "KEYS");
    drawKeys(sandbox);
    heading(sandbox.state(), "SECOND CLIP");
    drawSecondClip(sandbox);
    heading(sandbox.state(), "GOALS ON TOP");
    ImGui::Checkbox("Hold pins and goals while it plays", &play_->goalsOnTop);
    if (const std::string& chosen = sandbox.session().solver(); play_->goalsOnTop) {
      const std::string used = solverOverClip(chosen);
      const std::string_view title = solverEntry(used).title;
      wrappedText(used == chosen
                      ? fmt::format("Solved by {}.", title)
                      : fmt::format("Solved by {}, not by the {}, which would pull the body out of "
                                    "the clip towards its rest pose.",
                                    title, solverEntry(chosen).title));
    }
    heading(sandbox.state(), "EXPORT");
    ImGui::SetNextItemWidth(-70 * sandbox.scale());
    ImGui::InputText("##export", exportPath_, sizeof exportPath_);
    ImGui::SameLine();
    if (ImGui::Button("Write")) tried(sandbox, [&] { write(sandbox, exportPath_); });
  }

  void drawBottomStrip(Sandbox& sandbox) override {
    Sandbox::State& s = sandbox.state();
    if (!editor_) {
      ImGui::TextColored(s.colours().textDim, "No motion");
      return;
    }
    const TimelineAction action = timeline_.draw(s, timelineContent(sandbox));
    if (action.scrubTo) {
      (*head_) = *action.scrubTo;
      sandbox.setPlaying(false);
    }
    if (action.moveKey)
      edit(sandbox, [&] { editor_->moveKeys(action.moveKey->first, action.moveKey->second); });
  }

  std::string status() const override {
    if (!editor_) return {};
    nlohmann::json keys = nlohmann::json::array();
    const std::vector<int> frames = editor_->keyFrames();
    for (std::size_t k = 0; k < frames.size() && k < timeline_.keyPixels().size(); ++k)
      keys.push_back({{"frame", frames[k] + 1},
                      {"pixel", {timeline_.keyPixels()[k].first, timeline_.keyPixels()[k].second}}});
    return nlohmann::json{{"frame", currentFrame() + 1}, {"frames", clip().frameCount()}, {"keys", keys}}
        .dump();
  }

 private:
  const MotionClip& clip() const { return editor_->clip(); }
  int currentFrame() const { return frameAt(clip(), *head_); }
  /// Seconds after which it begins again.
  double length() const { return clip().frameCount() / clip().framesPerSecond; }

  bool goTo(Sandbox& sandbox, int frame) {
    (*head_) = std::clamp(frame, 0, clip().frameCount() - 1) / clip().framesPerSecond;
    sandbox.setPlaying(false);
    placeHead(sandbox);
    return true;
  }

  /// The pose at the playhead, which rests on whole frames only.
  void placeHead(Sandbox& sandbox) {
    if (!sandbox.playing()) (*head_) = currentFrame() / clip().framesPerSecond;
    (*head_) = std::min((*head_), play_->loop ? length() : clip().duration());
    sample(sandbox.session().skeleton(), clip(), (*head_), play_->loop ? BeyondEnd::Loop : BeyondEnd::Stay,
           q_);
    if (play_->goalsOnTop) solveGoals(sandbox);
  }

  void advance(Sandbox& sandbox, double dt) {
    (*head_) += dt;
    if (play_->loop) {
      (*head_) -= length() * std::floor((*head_) / length());
    } else if (const double end = clip().duration(); (*head_) < 0.0 || (*head_) > end) {
      (*head_) = std::clamp((*head_), 0.0, end);
      sandbox.setPlaying(false);
    }
  }

  // --- the pose at the playhead

  /// Brings the session into the clip's pose, anew where the playhead or the clip moved. The session keeps
  /// limits, the clip need not.
  void restAt(Sandbox& sandbox) {
    const bool sameClip = restedVersion_ == editor_->version() || isPosed(sandbox);
    if (restedSeconds_ == (*head_) && sameClip) return;
    sandbox.session().setPose(q_);
    restedSeconds_ = (*head_);
    restedVersion_ = editor_->version();
    restedQ_ = sandbox.session().q();
    sandbox.session().setPosture(restedQ_);  // a drag starts from the clip's pose, not from the rest pose
  }
  void leavePose() { restedSeconds_.reset(); }

  /// The session's pose as it stands, after a file or undo put it there: at rest in the clip's pose, or
  /// posed.
  void takeUpPose(Sandbox& sandbox) {
    if (sandbox.playing() || play_->goalsOnTop) return leavePose();
    placeHead(sandbox);
    Session& session = sandbox.session();
    restedSeconds_ = (*head_);
    restedVersion_ = editor_->version();
    restedQ_ = projectToLimits(session.skeleton(), q_);
    session.setPosture(restedQ_);
    if ((session.q() - q_).norm() > 1e-9 && (session.q() - restedQ_).norm() > 1e-9) return;
    session.setPose(q_);
    restedQ_ = session.q();
  }

  /// Undo and redo change the clip from outside.
  void followEdits(Sandbox& sandbox) {
    if (jumps_ == sandbox.session().jumps()) return;
    jumps_ = sandbox.session().jumps();
    if (editor_->edits() != sandbox.session().edits().clip) editor_->setEdits(sandbox.session().edits().clip);
    takeUpPose(sandbox);
  }

  /// An edit of the clip that can be undone; nothing where it throws or changes nothing.
  template <class Edit>
  void edit(Sandbox& sandbox, Edit edit) {
    edit();
    if (editor_->edits() == sandbox.session().edits().clip) return;
    sandbox.session().remember();
    sandbox.session().setClip(editor_->edits());
  }
  /// Whether something changed the session's pose since the playhead came to rest.
  bool isPosed(const Sandbox& sandbox) const {
    return restedSeconds_ && *restedSeconds_ == (*head_) &&
           (sandbox.session().dragged() || sandbox.session().q() != restedQ_);
  }
  const Eigen::VectorXd& shownPose(const Sandbox& sandbox) const {
    return isPosed(sandbox) ? sandbox.session().q() : q_;
  }

  void keyJoints(Sandbox& sandbox, const std::vector<int>& joints) {
    edit(sandbox, [&] { editor_->setKeys(joints, currentFrame(), shownPose(sandbox)); });
    sandbox.say(fmt::format("{} {} keyed in frame {}", joints.size(), joints.size() == 1 ? "joint" : "joints",
                            currentFrame() + 1));
  }
  void keySelected(Sandbox& sandbox) {
    if (!sandbox.selectedJoint()) throw std::invalid_argument("select a joint to key it");
    keyJoints(sandbox, {*sandbox.selectedJoint()});
  }
  /// Every joint that a drag, a turn or the goals on top brought out of the clip's pose.
  void keyMoved(Sandbox& sandbox) {
    const Skeleton& skeleton = sandbox.session().skeleton();
    const auto moved = isPosed(sandbox) ? movedJoints(skeleton, restedQ_, sandbox.session().q())
                                        : movedJoints(skeleton, sample(skeleton, clip(), (*head_)), q_);
    if (moved.empty())
      throw std::invalid_argument("no joint has left the clip's pose; drag or turn one first");
    keyJoints(sandbox, moved);
  }
  /// degrees: rotation vector in the joint's own frame.
  void turnSelected(Sandbox& sandbox, const Vector3d& degrees) {
    if (!sandbox.selectedJoint()) throw std::invalid_argument("select a joint to turn it");
    if (sandbox.playing() || play_->goalsOnTop)
      throw std::invalid_argument("a joint can be turned while the clip rests without goals on top");
    const Skeleton& skeleton = sandbox.session().skeleton();
    Eigen::VectorXd q = sandbox.session().q();
    const int joint = *sandbox.selectedJoint();
    setJointRotation(skeleton, q, joint,
                     (jointRotation(skeleton, q, joint) * expRotation(M_PI / 180.0 * degrees)).normalized());
    sandbox.session().remember();
    sandbox.session().setPose(q);
  }

  // --- edits of the whole clip

  void smooth(Sandbox& sandbox, double hertz) {
    edit(sandbox, [&] { editor_->replace(lowPassed(sandbox.session().skeleton(), clip(), hertz)); });
    sandbox.say(fmt::format("Smoothed by a zero-phase low-pass at {:.1f} Hz", hertz));
  }

  void plantFeet(Sandbox& sandbox) {
    const Skeleton& skeleton = sandbox.session().skeleton();
    const FootPlantOptions options{.floor = std::min(0.0, sandbox.state().view->groundHeight())};
    const std::vector<Foot> feet = facts(sandbox).feet;
    const auto contacts = footContacts(skeleton, clip(), feet, options);
    const FootFacts before = footFacts(skeleton, clip(), feet, contacts, options.floor);
    edit(sandbox, [&] { editor_->replace(footPlanted(skeleton, clip(), feet, contacts, options)); });
    const FootFacts after = footFacts(skeleton, clip(), feet, contacts, options.floor);
    sandbox.say(fmt::format("Feet slide {:.2f} mm a frame, now {:.4f}; penetrate {:.2f} mm, now {:.2f}",
                            1e3 * before.meanSlide, 1e3 * after.meanSlide, 1e3 * before.deepestPenetration,
                            1e3 * after.deepestPenetration));
  }

  static Companions withoutMotion(Companions files) {
    files.amc.clear();
    return files;
  }
  MotionClip secondClip(Sandbox& sandbox, const std::string& file) const {
    const ModelReference& reference = sandbox.state().session->document().model;
    FittedClip fitted = clipFor(sandbox.session().model(), clip().framesPerSecond, file, reference.nameOrFile,
                                withoutMotion(reference.files));
    for (const Note& note : fitted.notes) sandbox.say(note.lineWithoutRemedy());
    return std::move(fitted.clip);
  }
  void fade(Sandbox& sandbox, const std::string& file, double seconds) {
    edit(sandbox, [&] { editor_->crossFade(secondClip(sandbox, file), seconds); });
    sandbox.say(
        fmt::format("Fades into {} within {:.2f} s; {} frames", stem(file), seconds, clip().frameCount()));
  }
  void lay(Sandbox& sandbox, const std::string& file, double weight, bool additive, std::vector<int> joints) {
    const std::string part =
        joints.empty() ? "" : " from " + sandbox.session().skeleton().joint(joints.front()).name + " on";
    edit(sandbox, [&] {
      editor_->lay({.clip = secondClip(sandbox, file),
                    .kind = additive ? Layer::Kind::Additive : Layer::Kind::Override,
                    .weight = weight,
                    .joints = std::move(joints)});
    });
    sandbox.say(fmt::format("{:.0f} % of {} {}{}", 100.0 * weight, stem(file),
                            additive ? "on top" : "in place", part));
  }

  /// Everything that is known about the clip before it plays. The editor holds the same clip: an undo in the
  /// menu bar comes after `step`.
  const MotionFacts& facts(Sandbox& sandbox) {
    followEdits(sandbox);
    return sandbox.state().view->motionFacts(sandbox.session());
  }

  TimelineContent timelineContent(Sandbox& sandbox) {
    const auto& [feet, contacts, ways, outside] = facts(sandbox);
    TimelineContent content{.frameCount = clip().frameCount(),
                            .framesPerSecond = clip().framesPerSecond,
                            .seconds = (*head_),
                            .rows = {},
                            .bars = {},
                            .keys = editor_->keyFrames(),
                            .selectedKeys = {}};
    for (std::size_t foot = 0; foot < feet.size(); ++foot) {
      content.rows.push_back({feet[foot].name, {}});
      for (const Contact& contact : contacts)
        if (contact.foot == static_cast<int>(foot))
          content.rows.back().spans.emplace_back(contact.first, contact.last);
    }
    std::size_t most = 1;
    for (const auto& joints : outside) most = std::max(most, joints.size());
    for (const auto& joints : outside)
      content.bars.push_back(static_cast<float>(joints.size()) / static_cast<float>(most));
    for (const int frame : content.keys)
      if (sandbox.selectedJoint() && editor_->hasKey(*sandbox.selectedJoint(), frame))
        content.selectedKeys.push_back(frame);
    return content;
  }

  /// One line, so that nothing below it moves while the clip plays; all of them are in its tooltip.
  void drawLimits(Sandbox& sandbox) {
    std::vector<int> outside = facts(sandbox).outside[currentFrame()];
    const Palette& colours = sandbox.state().colours();
    if (outside.empty()) {
      ImGui::TextColored(colours.textDim, "No limit is left in this frame.");
      return;
    }
    const Skeleton& skeleton = sandbox.session().skeleton();
    const Eigen::VectorXd q = clip().q.col(currentFrame());
    const auto beyond = [&](int joint) { return limitViolation(skeleton, q, joint); };
    std::ranges::stable_sort(outside, std::greater<>(), beyond);
    std::string all;
    for (const int joint : outside)
      all += fmt::format("{}{}  {:.1f}° beyond", all.empty() ? "" : "\n", skeleton.joint(joint).name,
                         beyond(joint) * 180.0 / M_PI);
    const std::string more = outside.size() > 1 ? fmt::format(", and {} more", outside.size() - 1) : "";
    ImGui::TextColored(colours.bad, "%s", (all.substr(0, all.find('\n')) + more).c_str());
    tooltip(all.c_str());
  }

  template <class Edit>
  static bool tried(Sandbox& sandbox, Edit edit) {
    try {
      edit();
    } catch (const std::exception& error) {
      sandbox.say(error.what(), true);
    }
    return true;
  }

  void drawEdits(Sandbox& sandbox) {
    ImGui::SetNextItemWidth(-130 * sandbox.scale());
    valueSlider("cut-off", cutoff_, 0.5f, 20.0f, "%.1f Hz");
    tooltip("Of the low-pass: joints keep what is slower.");
    ImGui::SameLine();
    if (ImGui::Button("Smooth")) tried(sandbox, [&] { smooth(sandbox, cutoff_); });
    ImGui::BeginDisabled(facts(sandbox).feet.empty());
    if (ImGui::Button("Plant feet")) tried(sandbox, [&] { plantFeet(sandbox); });
    ImGui::EndDisabled();
    tooltip("Holds a foot where it stands, and above the floor. Needs legs whose feet touch the ground.");
    ImGui::SameLine();
    ImGui::BeginDisabled(!sandbox.session().canUndo());
    if (ImGui::Button("Undo")) undoOrRedo(sandbox, false);
    ImGui::EndDisabled();
    ImGui::SameLine();
    ImGui::BeginDisabled(!sandbox.session().canRedo());
    if (ImGui::Button("Redo")) undoOrRedo(sandbox, true);
    ImGui::EndDisabled();
    ImGui::SameLine();
    if (ImGui::Button("Original")) edit(sandbox, [&] { editor_->backToOriginal(); });
    tooltip("The clip as it was read, without edits and keys. Can be undone.");
  }

  void drawKeys(Sandbox& sandbox) {
    const Skeleton& skeleton = sandbox.session().skeleton();
    const auto joint = sandbox.selectedJoint();
    const Palette& colours = sandbox.state().colours();
    ImGui::TextColored(
        colours.textDim, "%s",
        joint ? skeleton.joint(*joint).name.c_str() : "Drag the body at rest, or select a joint.");
    ImGui::BeginDisabled(!joint || sandbox.playing() || play_->goalsOnTop);
    ImGui::SetNextItemWidth(-60 * sandbox.scale());
    ImGui::DragFloat3("##turn", turnDegrees_, 0.5f, -180.0f, 180.0f, "%.0f°");
    ImGui::SameLine();
    if (ImGui::Button("Turn"))
      tried(sandbox, [&] { turnSelected(sandbox, {turnDegrees_[0], turnDegrees_[1], turnDegrees_[2]}); });
    tooltip("Turns the joint by this rotation vector in its own frame, degrees.");
    ImGui::EndDisabled();
    ImGui::BeginDisabled(!joint);
    if (ImGui::Button("Key joint")) tried(sandbox, [&] { keySelected(sandbox); });
    tooltip("The selected joint passes through the pose shown in this frame.");
    ImGui::EndDisabled();
    ImGui::SameLine();
    if (ImGui::Button("Key moved")) tried(sandbox, [&] { keyMoved(sandbox); });
    tooltip("K. All joints that a drag, a turn or the goals on top brought out of the clip's pose.");
    ImGui::SameLine();
    ImGui::BeginDisabled(std::ranges::count(editor_->keyFrames(), currentFrame()) == 0);
    if (ImGui::Button("Delete")) edit(sandbox, [&] { editor_->removeKeys(currentFrame()); });
    tooltip("The keys of this frame. Keys can be dragged along the timeline.");
    ImGui::EndDisabled();
    float falloff = static_cast<float>(editor_->falloff());
    ImGui::SetNextItemWidth(-90 * sandbox.scale());
    if (valueSlider("Fade", falloff, 0.0f, 2.0f, "%.2f s") && falloff >= 0.0f && std::isfinite(falloff)) {
      editor_->setFalloff(falloff);
      sandbox.session().setClip(editor_->edits());
    }
    if (ImGui::IsItemActivated()) sandbox.session().remember();
    tooltip("Time in which a joint comes back to the clip before its first and after its last key.");
  }

  void drawSecondClip(Sandbox& sandbox) {
    const auto joint = sandbox.selectedJoint();
    ImGui::SetNextItemWidth(-1.0f);
    ImGui::InputTextWithHint("##second", "file with a motion", secondPath_, sizeof secondPath_);
    ImGui::BeginDisabled(secondPath_[0] == '\0');
    ImGui::SetNextItemWidth(-130 * sandbox.scale());
    valueSlider("fade", fadeSeconds_, 0.0f, 2.0f, "%.2f s");
    ImGui::SameLine();
    if (ImGui::Button("Append")) tried(sandbox, [&] { fade(sandbox, secondPath_, fadeSeconds_); });
    tooltip("The end of this clip fades into the beginning of the second one.");
    ImGui::SetNextItemWidth(-130 * sandbox.scale());
    valueSlider("weight", layerWeight_, 0.0f, 1.0f, "%.2f");
    ImGui::SameLine();
    if (ImGui::Button("Layer"))
      tried(sandbox, [&] {
        lay(sandbox, secondPath_, layerWeight_, additive_,
            onlyLimb_ && joint ? limbBelow(sandbox.session().skeleton(), *joint) : std::vector<int>{});
      });
    tooltip("Lays the second clip over this one, joint by joint on quaternions.");
    ImGui::EndDisabled();
    ImGui::Checkbox("On top", &additive_);
    tooltip("Adds the second clip's departure from the rest pose instead of blending towards its pose.");
    ImGui::SameLine();
    ImGui::BeginDisabled(!joint);
    ImGui::Checkbox("Selected limb only", &onlyLimb_);
    ImGui::EndDisabled();
  }

  /// The drag solver would pull towards the rest pose: in its place stands Levenberg and Marquardt's method,
  /// which changes no more than the goals ask for.
  static std::string solverOverClip(const std::string& chosen) {
    return chosen == "drag" ? "lm-gain-ratio" : chosen;
  }

  /// The clip's pose is the start of every frame; pins and held goals are reached from there.
  void solveGoals(Sandbox& sandbox) {
    const Session& session = sandbox.session();
    IkProblem problem = session.problem();
    if (problem.goals.empty()) return;
    problem.start = q_;
    if (!solver_ || solverName_ != session.solver()) {
      solverName_ = session.solver();
      solver_ = makeFrameSolver(solverOverClip(solverName_), session.sharedSkeleton());
    }
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

  void write(Sandbox& sandbox, const std::string& path) {
    const Model& model = sandbox.session().model();
    exportMotion(path, model.skeleton, sandbox.session().skin(), model.name, clip());
    sandbox.say("Wrote " + path);
  }

  std::optional<ClipEditor> editor_;
  Playback* play_ = nullptr;  ///< the document's
  double* head_ = nullptr;    ///< likewise, seconds
  int jumps_ = 0;             ///< the session's that the editor has followed
  float cutoff_ = 6.0f, fadeSeconds_ = 0.3f, layerWeight_ = 1.0f;
  float turnDegrees_[3] = {0, 0, 0};
  bool additive_ = false, onlyLimb_ = false;
  char exportPath_[512] = "motion.glb", secondPath_[512] = "";
  Timeline timeline_;
  Eigen::VectorXd q_;  ///< of the clip at the playhead, with the goals on top
  Frames frames_;
  std::optional<double> restedSeconds_;  ///< where the playhead came to rest, with the session in that pose
  int restedVersion_ = 0;
  Eigen::VectorXd restedQ_;
  std::optional<Vector3d> lastRoot_;
  std::string solverName_;
  std::unique_ptr<FrameSolver> solver_;
};

}  // namespace

std::unique_ptr<Panel> makeMotionPanel() { return std::make_unique<MotionPanel>(); }

}  // namespace gelenk
