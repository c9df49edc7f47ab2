#include "apps/sandbox/replay.h"

#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <stdexcept>

#include "apps/sandbox/sandbox_state.h"
#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"

namespace gelenk {
namespace {

using Kind = InputEvent::Kind;

struct KeyName {
  std::string_view name;
  int code;
};
constexpr std::array keyNames{
    KeyName{"tab", GLFW_KEY_TAB},
    KeyName{"space", GLFW_KEY_SPACE},
    KeyName{"delete", GLFW_KEY_DELETE},
    KeyName{"home", GLFW_KEY_HOME},
    KeyName{"escape", GLFW_KEY_ESCAPE},
    KeyName{"enter", GLFW_KEY_ENTER},
    KeyName{"shift", GLFW_KEY_LEFT_SHIFT},
    KeyName{"ctrl", GLFW_KEY_LEFT_CONTROL},
    KeyName{"alt", GLFW_KEY_LEFT_ALT},
    KeyName{"f12", GLFW_KEY_F12},
    KeyName{"f5", GLFW_KEY_F5},
    KeyName{"down", GLFW_KEY_DOWN},
    KeyName{"up", GLFW_KEY_UP},
    KeyName{"left", GLFW_KEY_LEFT},
    KeyName{"right", GLFW_KEY_RIGHT},
    KeyName{"end", GLFW_KEY_END},
    KeyName{"[", GLFW_KEY_LEFT_BRACKET},
    KeyName{"]", GLFW_KEY_RIGHT_BRACKET},
    KeyName{"?", GLFW_KEY_SLASH},
    KeyName{"backspace", GLFW_KEY_BACKSPACE},
};

std::optional<int> keyCode(const std::string& word) {
  std::string lower = word;
  std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const auto& [name, code] : keyNames)
    if (lower == name) return code;
  if (lower.size() == 1 && lower[0] >= 'a' && lower[0] <= 'z') return GLFW_KEY_A + lower[0] - 'a';
  if (lower.size() == 1 && lower[0] >= '0' && lower[0] <= '9') return GLFW_KEY_0 + lower[0] - '0';
  return std::nullopt;
}

std::optional<int> buttonCode(const std::string& word) {
  if (word == "left") return GLFW_MOUSE_BUTTON_LEFT;
  if (word == "right") return GLFW_MOUSE_BUTTON_RIGHT;
  if (word == "middle") return GLFW_MOUSE_BUTTON_MIDDLE;
  return std::nullopt;
}

/// What a command's words must be: n number, i whole number, w word, k key, b button, r the rest of the line
/// as one word. In brackets: optional.
struct Form {
  std::string_view verb, words, usage;
};
constexpr std::array forms{
    Form{"move", "nn", "move X Y"},
    Form{"press", "b", "press left|right|middle"},
    Form{"release", "b", "release left|right|middle"},
    Form{"wheel", "n", "wheel STEPS"},
    Form{"key", "k", "key NAME"},
    Form{"keydown", "k", "keydown NAME"},
    Form{"keyup", "k", "keyup NAME"},
    Form{"text", "r", "text WORDS"},
    Form{"drop", "r", "drop FILE"},
    Form{"grab", "w", "grab GOAL"},
    Form{"shift-by", "nni", "shift-by DX DY FRAMES"},
    Form{"drag", "wnni", "drag GOAL DX DY FRAMES"},
    Form{"target", "wnnn", "target GOAL X Y Z"},
    Form{"pin", "w", "pin GOAL"},
    Form{"free", "w", "free GOAL"},
    Form{"solver", "w", "solver NAME"},
    Form{"open", "r", "open MODEL"},
    Form{"select", "w", "select JOINT"},
    Form{"show", "ww", "show WHAT on|off"},
    Form{"tab", "w", "tab PANEL"},
    Form{"theme", "w", "theme light|dark"},
    Form{"do", "r", "do PANEL COMMAND WORDS"},
};

void check(const std::string& file, const Replay::Command& command) {
  const auto form = std::ranges::find(forms, command.verb, &Form::verb);
  if (form == forms.end()) {
    std::string known;
    for (const Form& f : forms) known += (known.empty() ? "" : ", ") + std::string(f.verb);
    throw ParseError(file, command.line, "a command: " + known, "'" + command.verb + "'");
  }
  if (command.words.size() != form->words.size())
    throw ParseError(file, command.line, std::string(form->usage),
                     fmt::format("{} words after {}", command.words.size(), command.verb));
  for (std::size_t i = 0; i < form->words.size(); ++i) {
    const std::string& word = command.words[i];
    const char kind = form->words[i];
    if (kind == 'n' && !parseNumber(word)) throw ParseError(file, command.line, "a number", "'" + word + "'");
    if (kind == 'i' && (!parseInteger(word) || *parseInteger(word) < 1))
      throw ParseError(file, command.line, "a number of frames of at least 1", "'" + word + "'");
    if (kind == 'k' && !keyCode(word))
      throw ParseError(file, command.line,
                       "a key: a letter, a digit, tab, space, delete, home, end, escape, enter, shift, ctrl, "
                       "alt, f5, f12, up, down, left, right, backspace, [, ] or ?",
                       "'" + word + "'");
    if (kind == 'b' && !buttonCode(word))
      throw ParseError(file, command.line, "left, right or middle", "'" + word + "'");
  }
}

/// The goal of that name; of a joint that has none, a new one.
GoalId goalNamed(Sandbox& sandbox, const std::string& name) {
  if (const auto goal = sandbox.session().findGoal(name)) return *goal;
  if (const auto joint = sandbox.session().skeleton().findJoint(name))
    return sandbox.session().addJointGoal(*joint);
  std::string known;
  for (const SceneGoal& goal : sandbox.session().goals())
    known += (known.empty() ? "" : ", ") + goal.goal.name;
  throw std::invalid_argument(fmt::format("no goal or joint is called '{}'; the goals are: {}", name, known));
}

Panel& panelOf(Sandbox& sandbox, std::string_view name) {
  std::string known;
  for (const auto& panel : sandbox.state().panels) {
    if (panel->name() == name) return *panel;
    known += (known.empty() ? "" : ", ") + panel->name();
  }
  throw std::invalid_argument(fmt::format("no panel is called '{}'; there are: {}", name, known));
}

double number(const Replay::Command& command, int i) { return *parseNumber(command.words[i]); }

void run(const Replay::Command& command, Sandbox& sandbox, InputQueue& queue) {
  Sandbox::State& s = sandbox.state();
  const std::string& verb = command.verb;
  const auto key = [&](bool down) {
    queue.add({.kind = Kind::Key, .code = *keyCode(command.words[0]), .down = down});
  };
  const auto button = [&](bool down) {
    queue.add({.kind = Kind::MouseButton, .code = *buttonCode(command.words[0]), .down = down});
  };
  if (verb == "move") queue.add({.kind = Kind::MouseMove, .x = number(command, 0), .y = number(command, 1)});
  if (verb == "press") button(true);
  if (verb == "release") button(false);
  if (verb == "wheel") queue.add({.kind = Kind::Wheel, .y = number(command, 0)});
  if (verb == "key" || verb == "keydown") key(true);
  if (verb == "key" || verb == "keyup") key(false);
  if (verb == "text")
    for (const char c : command.words[0])
      queue.add({.kind = Kind::Character, .code = static_cast<unsigned char>(c)});
  if (verb == "drop") queue.add({.kind = Kind::Drop, .paths = {command.words[0]}});
  if (verb == "grab") {
    const Eigen::Vector2d pixel = s.toWindow(s.session->reached(goalNamed(sandbox, command.words[0]))).pixel;
    queue.add({.kind = Kind::MouseMove, .x = pixel.x(), .y = pixel.y()});
    queue.add({.kind = Kind::MouseButton, .code = GLFW_MOUSE_BUTTON_LEFT, .down = true});
  }
  if (verb == "target") {
    const GoalId goal = goalNamed(sandbox, command.words[0]);
    s.session->remember();
    s.session->setTarget(goal, {number(command, 1), number(command, 2), number(command, 3)});
  }
  if (verb == "pin" || verb == "free") {
    const GoalId goal = goalNamed(sandbox, command.words[0]);
    s.session->remember();
    if (verb == "pin")
      s.session->setState(goal, GoalState::Pinned);
    else
      s.session->removeGoal(goal);
  }
  if (verb == "solver") s.session->setSolver(command.words[0]);
  if (verb == "open" && !sandbox.open(command.words[0])) throw std::invalid_argument(s.notices.back().words);
  if (verb == "select") {
    const int joint = s.session->skeleton().jointIndex(command.words[0]);
    sandbox.select(joint);
    s.selectedGoal = s.session->findGoal(command.words[0]);
  }
  if (verb == "show") s.show().*viewOption(command.words[0]) = command.words[1] == "on";
  if (verb == "tab") {
    const Panel& panel = panelOf(sandbox, command.words[0]);
    panel.hasBottomStrip() && !panel.hasInspector() ? sandbox.showBottomStrip(command.words[0])
                                                    : sandbox.showInspector(command.words[0]);
  }
  if (verb == "do") {
    const auto words = splitWords(command.words[0]);
    panelOf(sandbox, words[0]).act(sandbox, {words.begin() + 1, words.end()});
  }
  if (verb == "theme") s.theme() = command.words[0] == "dark" ? Theme::Dark : Theme::Light;
}

/// drag = grab, shift-by, release; shift-by = one move a frame.
int expand(const Replay::Command& command, std::vector<Replay::Command>& out) {
  if (command.verb != "drag") {
    out.push_back(command);
    return command.frame + (command.verb == "shift-by" ? *parseInteger(command.words[2]) : 1);
  }
  const int frames = *parseInteger(command.words[3]);
  out.push_back({command.frame, command.line, "grab", {command.words[0]}});
  out.push_back(
      {command.frame + 1, command.line, "shift-by", {command.words[1], command.words[2], command.words[3]}});
  out.push_back({command.frame + frames + 1, command.line, "release", {"left"}});
  return command.frame + frames + 2;
}

}  // namespace

Replay Replay::read(const std::string& path) {
  const std::string text = readFile(path);
  return parse(path, std::string(plainText(text, path)));
}

Replay Replay::parse(const std::string& name, const std::string& text) {
  Replay replay;
  replay.name_ = name;
  std::vector<Command> commands;
  int lineNumber = 0, last = 0;
  for (const std::string_view line : splitLines(text)) {
    ++lineNumber;
    const std::string_view content = line.substr(0, line.find('#'));
    const std::vector<std::string_view> words = splitWords(content);
    if (words.empty()) continue;
    const std::optional<int> frame = parseInteger(words[0]);
    if (!frame || *frame < 0)
      throw ParseError(name, lineNumber, "a frame number", "'" + std::string(words[0]) + "'");
    if (*frame < last)
      throw ParseError(name, lineNumber, fmt::format("a frame not before {}", last), std::string(words[0]));
    if (words.size() < 2) throw ParseError(name, lineNumber, "a command after the frame number", "none");
    last = *frame;
    Command command{*frame, lineNumber, std::string(words[1]), {}};
    const auto form = std::ranges::find(forms, command.verb, &Form::verb);
    if (form != forms.end() && form->words == "r" && words.size() > 2)
      command.words.emplace_back(words[2].data(), words.back().data() + words.back().size());
    else
      command.words.assign(words.begin() + 2, words.end());
    check(name, command);
    replay.length_ = std::max(replay.length_, expand(command, commands));
  }
  std::ranges::stable_sort(commands, {}, &Command::frame);
  replay.commands_.assign(commands.begin(), commands.end());
  return replay;
}

void Replay::play(int number, Sandbox& sandbox, InputQueue& queue) {
  std::vector<Command> next;
  while (!commands_.empty() && commands_.front().frame <= number) {
    Command command = commands_.front();
    commands_.pop_front();
    try {
      if (command.verb == "shift-by") {
        const int frames = *parseInteger(command.words[2]);
        const double dx = *parseNumber(command.words[0]) / frames,
                     dy = *parseNumber(command.words[1]) / frames;
        const Eigen::Vector2d from = sandbox.state().mouse;
        for (int i = 0; i < frames; ++i)
          next.push_back({number + i,
                          command.line,
                          "move",
                          {exactNumber(from.x() + dx * (i + 1)), exactNumber(from.y() + dy * (i + 1))}});
        run(next.front(), sandbox, queue);
        next.erase(next.begin());
      } else {
        run(command, sandbox, queue);
      }
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(fmt::format("{}:{}: {}", name_, command.line, error.what()));
    }
  }
  if (next.empty()) return;
  std::vector<Command> all(commands_.begin(), commands_.end());
  all.insert(all.end(), next.begin(), next.end());
  std::ranges::stable_sort(all, {}, &Command::frame);
  commands_.assign(all.begin(), all.end());
}

}  // namespace gelenk
