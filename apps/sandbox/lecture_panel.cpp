#include <fmt/format.h>

#include "apps/sandbox/builtin_panels.h"
#include "apps/sandbox/lecture_scene.h"
#include "apps/sandbox/sandbox_state.h"

namespace gelenk {

LectureColours lectureColours(Theme theme) {
  const bool dark = theme == Theme::Dark;
  return {.first = {0.12f, 0.47f, 0.71f, 0.95f},
          .second = {0.84f, 0.45f, 0.07f, 0.95f},
          .linear = {0.80f, 0.20f, 0.35f, 1.0f},
          .truth = {0.10f, 0.55f, 0.40f, 1.0f},
          .target = {0.80f, 0.20f, 0.35f, 1.0f},
          .faint = dark ? Colour{0.8f, 0.8f, 0.8f, 0.35f} : Colour{0.2f, 0.2f, 0.25f, 0.30f}};
}

void headingRow(Sandbox& sandbox, const char* words) {
  ImGui::Dummy({0, 3 * sandbox.scale()});
  ImGui::PushFont(sandbox.state().gui.fonts().small);
  ImGui::TextColored(sandbox.state().colours().textDim, "%s", words);
  ImGui::PopFont();
}

void valueRow(Sandbox& sandbox, const std::string& name, const std::string& value) {
  ImGui::TextColored(sandbox.state().colours().textDim, "%s", name.c_str());
  const float width = ImGui::CalcTextSize(value.c_str()).x;
  ImGui::SameLine(std::max(ImGui::CalcTextSize(name.c_str()).x + 16 * sandbox.scale(),
                           ImGui::GetContentRegionMax().x - width));
  ImGui::TextUnformatted(value.c_str());
}

void matrixRows(Sandbox& sandbox, const std::string& name, const Eigen::MatrixXd& m, const char* format) {
  ImGui::TextColored(sandbox.state().colours().textDim, "%s", name.c_str());
  const float left = 14 * sandbox.scale();
  const float column =
      (ImGui::GetContentRegionMax().x - left) / static_cast<float>(std::max<Eigen::Index>(3, m.cols()));
  for (Eigen::Index i = 0; i < m.rows(); ++i)
    for (Eigen::Index j = 0; j < m.cols(); ++j) {
      char text[64];
      std::snprintf(text, sizeof text, format, m(i, j));
      if (j > 0) ImGui::SameLine(0, 0);
      ImGui::SetCursorPosX(left + column * static_cast<float>(j + 1) - 8 * sandbox.scale() -
                           ImGui::CalcTextSize(text).x);
      ImGui::TextUnformatted(text);
    }
}

void frameView(Sandbox& sandbox, const Eigen::AlignedBox3d& box) {
  Sandbox::State& s = sandbox.state();
  s.cameraMove.reset();
  s.camera() = frameBox(s.camera(), s.viewport(), box, 0.06);
}

void columnText(Sandbox& sandbox, const std::string& text) {
  const float cell = 6.1f * sandbox.scale();  // about the mean width of a character of the small font
  ImGui::PushFont(sandbox.state().gui.fonts().small);
  std::size_t from = 0;
  while (from < text.size()) {
    const std::size_t end = std::min(text.find('\n', from), text.size());
    const std::string line = text.substr(from, end - from);
    from = end + 1;
    if (line.empty()) {
      ImGui::Dummy({0, 0.35f * ImGui::GetTextLineHeight()});
      continue;
    }
    std::size_t at = line.find_first_not_of(' ');
    bool first = true;
    while (at != std::string::npos) {
      const std::size_t gap = line.find("   ", at);
      const std::string word = line.substr(at, gap == std::string::npos ? gap : gap - at);
      if (!first) ImGui::SameLine(0, 0);
      ImGui::SetCursorPosX(
          std::max(first ? 0.0f : ImGui::GetCursorPosX() + cell, cell * static_cast<float>(at)));
      ImGui::TextUnformatted(word.c_str());
      first = false;
      at = gap == std::string::npos ? gap : line.find_first_not_of(' ', gap);
    }
  }
  ImGui::PopFont();
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
      ImGui::PushTextWrapPos();
      ImGui::TextColored(
          sandbox.state().colours().textDim,
          "Each example opens as a scene: its values stand here, live, and the arm can be dragged.");
      ImGui::PopTextWrapPos();
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
      ImGui::BeginChild("plot", {0.42f * available.x, 0});
      scene_->drawPlot(sandbox);
      ImGui::EndChild();
      ImGui::SameLine();
    }
    ImGui::BeginChild("derivation", {0, 0}, false, ImGuiWindowFlags_HorizontalScrollbar);
    columnText(sandbox, derivation_);
    ImGui::EndChild();
  }

  void step(Sandbox& sandbox, double seconds) override {
    if (scene_) scene_->step(sandbox, seconds);
  }
  double rests(const Sandbox& sandbox) const override {
    return scene_ && scene_->moves(sandbox) ? 0.0 : std::numeric_limits<double>::infinity();
  }
  void overlay(Sandbox& sandbox) override {
    if (scene_) scene_->overlay(sandbox);
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
    document.lecture = topic_ ? LectureState{.topic = topic_->id, .state = scene_->save()} : LectureState{};
  }

 private:
  /// The example of a document that was read from a file: begun as always, then brought to where it was.
  void takeUp(Sandbox& sandbox) {
    const auto model = sandbox.session().sharedModel();
    const Document document = sandbox.session().document();
    openTopic(sandbox, findLectureTopic(document.lecture.topic));
    opening_ = true;
    sandbox.openDocument(model, document);
    opening_ = false;
    scene_->load(sandbox, document.lecture.state);
  }

  void openTopic(Sandbox& sandbox, const LectureTopic& topic) {
    opening_ = true;
    struct Reset {
      bool& flag;
      ~Reset() { flag = false; }
    } reset{opening_};
    scene_ = makeLectureScene(topic.id);
    topic_ = &topic;
    derivation_ = topic.steps();
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
      ImGui::TextColored(verdicts_[i].ok ? colours.good : colours.bad, verdicts_[i].ok ? "+" : "!");
      ImGui::SameLine();
      ImGui::PushTextWrapPos();
      ImGui::TextUnformatted(check.what.c_str());
      ImGui::PushFont(sandbox.state().gui.fonts().small);
      const char* sign = check.comparison == Comparison::Equal    ? ""
                         : check.comparison == Comparison::AtMost ? "at most "
                                                                  : "at least ";
      ImGui::TextColored(colours.textDim, "%s%s   computed %s", sign, list(check.printed, 6).c_str(),
                         list(verdicts_[i].computed, 7).c_str());
      ImGui::PopFont();
      ImGui::PopTextWrapPos();
      ImGui::EndGroup();
      const std::string hint =
          check.id + ", " + check.section + (check.note.empty() ? "" : "\n" + check.note);
      tooltip(hint.c_str());
      ImGui::PopID();
    }
  }

  const LectureTopic* topic_ = nullptr;
  std::unique_ptr<LectureScene> scene_;
  std::string derivation_;
  std::vector<LectureVerdict> verdicts_;
  bool opening_ = false;
};

}  // namespace

std::unique_ptr<Panel> makeLecturePanel() { return std::make_unique<LecturePanel>(); }

}  // namespace gelenk
