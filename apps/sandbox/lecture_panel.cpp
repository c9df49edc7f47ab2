#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "apps/render/mathematics.h"
#include "apps/sandbox/builtin_panels.h"
#include "apps/sandbox/derivation_text.h"
#include "apps/sandbox/lecture_scene.h"
#include "apps/sandbox/sandbox_state.h"

namespace gelenk {

void headingRow(Sandbox& sandbox, const char* words) {
  ImGui::Dummy({0, 3 * sandbox.scale()});
  ImGui::PushFont(sandbox.state().gui.fonts().small);
  ImGui::PushStyleColor(ImGuiCol_Text, sandbox.state().colours().textDim);
  mathItem(words);
  ImGui::PopStyleColor();
  ImGui::PopFont();
}

void valueRow(Sandbox& sandbox, const std::string& name, const std::string& value) {
  const auto widthOf = [](const std::string& text) {
    return mathExtent(ImGui::GetFont(), ImGui::GetFontSize(), text).width;
  };
  ImGui::PushStyleColor(ImGuiCol_Text, sandbox.state().colours().textDim);
  mathItem(name);
  ImGui::PopStyleColor();
  const float left = ImGui::GetContentRegionMax().x - widthOf(value);
  if (widthOf(name) + 10 * sandbox.scale() <= left)
    ImGui::SameLine(left);
  else  // no room beside its name: below it
    ImGui::SetCursorPosX(std::max(left, 0.0f));
  mathItem(value);
}

void matrixRows(Sandbox& sandbox, const std::string& name, const Eigen::MatrixXd& m, const char* format) {
  ImGui::PushStyleColor(ImGuiCol_Text, sandbox.state().colours().textDim);
  mathItem(name);
  ImGui::PopStyleColor();
  const ImVec2 low = ImGui::GetCursorScreenPos();
  const float left = 14 * sandbox.scale();
  const float column =
      (ImGui::GetContentRegionMax().x - left) / static_cast<float>(std::max<Eigen::Index>(3, m.cols()));
  for (Eigen::Index i = 0; i < m.rows(); ++i)
    for (Eigen::Index j = 0; j < m.cols(); ++j) {
      char text[64];
      std::snprintf(text, sizeof text, format, m(i, j));
      if (j > 0) ImGui::SameLine(0, 0);
      ImGui::SetCursorPosX(left + column * static_cast<float>(j + 1) - 8 * sandbox.scale() -
                           mathExtent(ImGui::GetFont(), ImGui::GetFontSize(), text).width);
      mathItem(text);
    }
  const float wide = left + column * static_cast<float>(m.cols());
  drawBrackets(
      *ImGui::GetWindowDrawList(), {low.x + 4 * sandbox.scale(), low.y - 1 * sandbox.scale()},
      {low.x + wide, ImGui::GetCursorScreenPos().y - ImGui::GetStyle().ItemSpacing.y + 2 * sandbox.scale()},
      colour32(sandbox.state().colours().textDim), 1.4f * sandbox.scale());
}

void LectureScene::frameView(Sandbox& sandbox, const Eigen::AlignedBox3d& box) {
  Sandbox::State& s = sandbox.state();
  s.cameraMove.reset();
  s.camera() = frameBox(s.camera(), s.viewport(), box, 0.06);
  framed_ = {box, s.camera(), s.viewport()};
}

void LectureScene::keepInView(Sandbox& sandbox) {
  if (!framed_) return;
  auto& [box, camera, viewport] = *framed_;
  Camera& now = sandbox.camera();
  if (now.distance != camera.distance || now.azimuth != camera.azimuth || now.elevation != camera.elevation ||
      now.orthographic != camera.orthographic)
    return framed_.reset();
  const Viewport view = sandbox.state().viewport();
  if (viewport.width == view.width && viewport.height == view.height) return;
  box.translate(now.target - camera.target);  // it walks along, or was panned
  now = camera = frameBox(now, view, box, 0.06);
  viewport = view;
}

std::unique_ptr<LectureScene> makeLectureScene(const std::string& topic) {
#define GELENK_MAKE(id, make) \
  if (topic == id) return make();
  GELENK_LECTURE_SCENES(GELENK_MAKE)
#undef GELENK_MAKE
  throw std::invalid_argument("the lecture has no scene called '" + topic + "'");
}

namespace {

/// The Lecture menu, the tab with the open example's values, and its derivation in the bottom strip.
class LecturePanel final : public Panel {
 public:
  std::string name() const override { return "Lecture"; }
  bool hasInspector() const override { return true; }
  bool hasBottomStrip() const override { return true; }
  std::string stripTitle() const override { return "Derivation"; }

  void drawMenu(Sandbox& sandbox) override {
    if (!ImGui::BeginMenu("Lecture")) return;
    for (const LectureTopic& topic : lectureTopics()) {
      if (ImGui::MenuItem(topic.title.c_str(), topic.section.c_str(), topic_ == &topic))
        openTopic(sandbox, topic);
    }
    ImGui::EndMenu();
  }

  void drawInspector(Sandbox& sandbox) override {
    const float width = ImGui::GetContentRegionAvail().x;
    ImGui::SetNextItemWidth(width);
    if (ImGui::BeginCombo("##topic", topic_ ? topic_->title.c_str() : "Choose an example ...",
                          ImGuiComboFlags_HeightLarge)) {
      for (const LectureTopic& topic : lectureTopics())
        if (ImGui::Selectable(fmt::format("{}   {}", topic.section, topic.title).c_str(), topic_ == &topic))
          openTopic(sandbox, topic);
      ImGui::EndCombo();
    }
    tooltip("Every example of lecture 10.1 and 10.2 as a scene; `gelenk lecture` prints the same list.");
    if (!topic_) {
      wrappedText(sandbox.state().colours().textDim,
                  "Each example opens as a scene: its values stand here, live, and the arm can be dragged.");
      return;
    }
    ImGui::BeginChild("scene", {0, 0});
    scene_->drawInspector(sandbox);
    checks(sandbox);
    ImGui::EndChild();
  }

  void drawBottomStrip(Sandbox& sandbox) override {
    if (!topic_) {
      ImGui::TextColored(sandbox.state().colours().textDim,
                         "Open an example from the Lecture menu: its derivation stands here.");
      return;
    }
    if (scene_->hasPlot()) {
      const ImVec2 available = ImGui::GetContentRegionAvail();
      ImGui::BeginChild("plot", {0.34f * available.x, 0});
      scene_->drawPlot(sandbox);
      ImGui::EndChild();
      ImGui::SameLine();
    }
    ImGui::BeginChild("derivation", {0, 0});
    ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing,
                        {ImGui::GetStyle().ItemSpacing.x, 3 * sandbox.scale()});  // more lines at a glance
    ImFont* font = sandbox.state().gui.fonts().regular;
    drawDerivation(shown_, font, font->FontSize);
    ImGui::PopStyleVar();
    ImGui::EndChild();
  }

  void drawBesideTabs(Sandbox& sandbox) override {
    if (!topic_) return;
    ImGui::SameLine(0, 16 * sandbox.scale());
    drawSwitch(sandbox);
  }

  bool drawPresentation(Sandbox& sandbox) override {
    if (!topic_) return false;
    const float size = sandbox.state().presentationType();
    ImGui::PushFont(sandbox.state().gui.fonts().title);
    ImGui::SetWindowFontScale(1.2f * size / sandbox.state().gui.fonts().title->FontSize);
    wrappedText(topic_->title);
    ImGui::PopFont();
    ImGui::SetWindowFontScale(1.0f);
    ImGui::TextColored(sandbox.state().colours().textDim, "%s", topic_->section.c_str());
    ImGui::SameLine(0, 16 * sandbox.scale());
    drawSwitch(sandbox);
    ImGui::Dummy({0, 6 * sandbox.scale()});
    ImGui::BeginChild("derivation", {0, 0});
    drawDerivation(shown_, sandbox.state().gui.fonts().title, size);
    ImGui::EndChild();
    return true;
  }

  void step(Sandbox& sandbox, double seconds) override {
    if (!scene_) return;
    scene_->keepInView(sandbox);
    scene_->step(sandbox, seconds);
  }
  double rests(const Sandbox& sandbox) const override {
    return scene_ && scene_->moves(sandbox) ? 0.0 : std::numeric_limits<double>::infinity();
  }
  void overlay(Sandbox& sandbox) override {
    if (!scene_) return;
    sandbox.showLecture(scene_->drawing());
    shown_ = live_ ? scene_->derivation(sandbox) : derivation_;
  }

  void opened(Sandbox& sandbox, bool fromFile) override {
    if (opening_ || (scene_ && scene_->changesModel())) return;
    scene_.reset();
    topic_ = nullptr;
    if (fromFile && !sandbox.session().lecture().topic.empty()) takeUp(sandbox);
  }

  /// "lecture:two-link" on the command line, in a replay or in the open dialog.
  bool openFile(Sandbox& sandbox, const std::string& path) override {
    constexpr std::string_view prefix = "lecture:";
    if (!path.starts_with(prefix)) return false;
    openTopic(sandbox, findLectureTopic(path.substr(prefix.size())));
    return true;
  }

  void store(const Sandbox&, Document& document) const override {
    document.lecture =
        topic_ ? LectureState{.topic = topic_->id, .state = scene_->drawing().save()} : LectureState{};
  }

  std::string status() const override {
    if (!topic_) return {};
    return nlohmann::json{{"topic", topic_->id}, {"values", live_ ? "live" : "slide"}, {"derivation", shown_}}
        .dump();
  }

  void act(Sandbox& sandbox, const std::vector<std::string>& words) override {
    if (words.size() == 1 && (words[0] == "slide" || words[0] == "live"))
      live_ = words[0] == "live";
    else
      Panel::act(sandbox, words);
  }

 private:
  /// The slide's numbers, or those of the arm as it stands.
  void drawSwitch(Sandbox& sandbox) {
    ImGui::PushFont(sandbox.state().gui.fonts().small);
    if (ImGui::RadioButton("slide", !live_)) live_ = false;
    tooltip("The derivation with the slide's own numbers.");
    ImGui::SameLine(0, 12 * sandbox.scale());
    if (ImGui::RadioButton("live", live_)) live_ = true;
    tooltip("Every number of the derivation follows the arm while you drag it.");
    ImGui::PopFont();
  }

  /// The example of a document that was read from a file: begun as always, then brought to where it was.
  void takeUp(Sandbox& sandbox) {
    const auto model = sandbox.session().sharedModel();
    const Document document = sandbox.session().document();
    openTopic(sandbox, findLectureTopic(document.lecture.topic));
    const Skeleton& own = sandbox.session().skeleton();
    const bool fits = scene_->takesAnyModel() ||
                      (own.jointCount() == model->skeleton.jointCount() && own.nq() == model->skeleton.nq());
    opening_ = true;
    sandbox.openDocument(model, document);
    opening_ = false;
    if (!fits) {  // the file has its example with another model
      scene_.reset();
      topic_ = nullptr;
      sandbox.session().lecture() = {};
      return sandbox.say("The scene's model is not that of its example; the example is left out", true);
    }
    scene_->drawing().load(sandbox.session(), document.lecture.state);
    scene_->taken(sandbox);
  }

  void openTopic(Sandbox& sandbox, const LectureTopic& topic) {
    opening_ = true;
    struct Reset {
      bool& flag;
      ~Reset() { flag = false; }
    } reset{opening_};
    scene_ = makeLectureScene(topic.id);
    topic_ = &topic;
    shown_ = derivation_ = topic.steps();
    verdicts_.clear();
    for (const LectureCheck& check : topic.checks) verdicts_.push_back(evaluate(check));
    scene_->open(sandbox);
    sandbox.showInspector("Lecture");
    sandbox.showBottomStrip("Lecture");
  }

  /// Printed against computed, a row a check; the note in the tooltip.
  void checks(Sandbox& sandbox) {
    const Palette& colours = sandbox.state().colours();
    headingRow(sandbox, "ON THE SLIDE AND COMPUTED");
    const auto list = [](const std::vector<double>& values, int digits) {
      std::string text;
      for (const double value : values)
        text += (text.empty() ? "" : ", ") +
                fmt::format("{:.{}g}", std::abs(value) < 1e-15 ? 0.0 : value, digits);
      return text;
    };
    for (std::size_t i = 0; i < topic_->checks.size(); ++i) {
      const LectureCheck& check = topic_->checks[i];
      ImGui::PushID(static_cast<int>(i));
      ImGui::BeginGroup();
      tickItem(verdicts_[i].ok, verdicts_[i].ok ? colours.good : colours.bad);
      ImGui::SameLine(0, 4 * sandbox.scale());
      const float width = ImGui::GetContentRegionAvail().x;
      ImGui::BeginGroup();
      std::istringstream lines(brokenAtBlanks(check.what, width));
      for (std::string line; std::getline(lines, line);) mathItem(line);
      ImGui::EndGroup();
      ImGui::PushFont(sandbox.state().gui.fonts().small);
      const char* sign = check.comparison == Comparison::Equal    ? ""
                         : check.comparison == Comparison::AtMost ? "at most "
                                                                  : "at least ";
      const std::string numbers =
          fmt::format("{}{}   computed {}", sign, list(check.printed, 6), list(verdicts_[i].computed, 7));
      ImGui::PushStyleColor(ImGuiCol_Text, colours.textDim);
      std::istringstream pieces(brokenAtBlanks(numbers, width));
      for (std::string line; std::getline(pieces, line);) mathItem(line);
      ImGui::PopStyleColor();
      ImGui::PopFont();
      ImGui::EndGroup();
      const std::string hint =
          check.id + ", " + check.section + (check.note.empty() ? "" : "\n" + check.note);
      tooltip(hint.c_str());
      ImGui::PopID();
    }
  }

  const LectureTopic* topic_ = nullptr;
  std::unique_ptr<LectureScene> scene_;
  std::string derivation_, shown_;  ///< the slide's; what stands in the window
  std::vector<LectureVerdict> verdicts_;
  bool opening_ = false, live_ = false;
};

}  // namespace

std::unique_ptr<Panel> makeLecturePanel() { return std::make_unique<LecturePanel>(); }

}  // namespace gelenk
