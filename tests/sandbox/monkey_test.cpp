// A monkey at the mouse and the keys: seeded random sessions of 300 frames that must not crash, leave a pose
// that is none, or tell nonsense. It writes what it does, before it does it, as a replay into a folder beside
// the files that it opens; a session that fails leaves that folder, and there it can be played again:
//     gelenk sandbox STAGE --offscreen --size 640x420 --replay monkey.replay
// More seeds by hand: GELENK_MONKEY=FIRST:COUNT sandbox_tests --gtest_filter='*MoreByHand'
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <set>

#include "apps/lecture/example.h"
#include "apps/sandbox/replay.h"
#include "apps/sandbox/sandbox.h"
#include "apps/sandbox/view_picture.h"
#include "kinematics/configuration.h"
#include "kinematics/io/text_file.h"
#include "skinning/gpu/offscreen_context.h"
#include "skinning/gpu/render_target.h"
#include "tests/sanitized.h"

namespace gelenk {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr int width = 640, height = 420, frameCount = 300;

/// A folder with what the monkey may open and drop, good and bad; the working folder while it lives, since
/// screenshots and scenes with typed names land there. Stays after a failure.
class Playground {
 public:
  explicit Playground(int seed)
      : before_(fs::current_path()),
        folder_(fs::temp_directory_path() /
                ("gelenk_monkey_" + std::to_string(getpid()) + "_" + std::to_string(seed))) {
    fs::create_directories(folder_);
    fs::current_path(folder_);
    writeFile("wave.bvh", bvh());
    writeFile("broken.bvh", bvh().substr(0, 300));
    writeFile("box.obj",
              "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 3\nv 1 0 3\nv 0 1 3\nv 1 1 3\nf 1 3 4 2\nf 5 6 8 7\n"
              "f 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n");
    writeFile("range.obj", "v 0 0 0\nv 1 0 0\nf 1 2 9\n");
    writeFile("empty.glb", "");
    writeFile("list.json", "[]");
    writeFile("notes.txt", "nothing that is known\n");
    writeFile("two.dh", "0.4 0 0 0\n0.3 0 0 0\n");
  }
  ~Playground() {
    fs::current_path(before_);
    if (!::testing::Test::HasFailure()) fs::remove_all(folder_);
  }
  Playground(const Playground&) = delete;
  Playground& operator=(const Playground&) = delete;

 private:
  /// A body of five joints that waves for twenty frames.
  static std::string bvh() {
    std::string text =
        "HIERARCHY\nROOT hips\n{\nOFFSET 0 1 0\nCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation "
        "Yrotation\nJOINT spine\n{\nOFFSET 0 0.3 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nJOINT "
        "arm_l\n{\n"
        "OFFSET 0.2 0.2 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET 0.4 0 0\n}\n}\n"
        "JOINT arm_r\n{\nOFFSET -0.2 0.2 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET "
        "-0.4 "
        "0 0\n}\n}\n}\nJOINT leg\n{\nOFFSET 0 -0.4 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\n"
        "OFFSET 0 -0.5 0\n}\n}\n}\nMOTION\nFrames: 20\nFrame Time: 0.04\n";
    for (int frame = 0; frame < 20; ++frame) {
      const double a = 40.0 * std::sin(0.3 * frame);
      for (const double value : {0.01 * frame, 1.0, 0.0, 0.1 * a, 0.0, 0.0, 0.2 * a, 0.0, 0.0, a, 0.0,
                                 0.3 * a, -a, 0.0, 0.0, 0.0, 0.5 * a, 0.0})
        text += std::to_string(value) + " ";
      text += "\n";
    }
    return text;
  }

  fs::path before_, folder_;
};

/// What the session stands on at the beginning, and what the monkey likes to do there.
struct Stage {
  std::string model;
  bool paints = false;
};

Stage stageOf(int seed) {
  static const std::vector<Stage> fixed{
      {"figure"}, {"panda"}, {"planar"}, {.model = "figure", .paints = true}, {"wave.bvh"}};
  const std::size_t topics = lectureTopics().size(),
                    k = static_cast<std::size_t>(seed) % (fixed.size() + topics);
  return k < fixed.size() ? fixed[k] : Stage{"lecture:" + lectureTopics()[k - fixed.size()].id};
}

class Monkey {
 public:
  Monkey(int seed, const fs::path& replay)
      : random_(static_cast<std::uint64_t>(seed)),
        stage_(stageOf(seed)),
        sandbox_({.model = stage_.model, .width = width, .height = height}),
        replayPath_(replay),
        replay_(replay) {
    target_.resize(width, height);
    replay_ << "# " << stage_.model << ", seed " << seed << std::endl;
    if (stage_.paints) plan({"tab Binding", "key b"});
  }

  /// One frame; false when the sandbox was closed.
  bool frame() {
    const int commands = choose(4);
    if (planned_.empty()) think();
    for (int i = 0; i < std::max(commands, 1) && !planned_.empty(); ++i) {
      const std::string command = planned_.front();
      planned_.pop_front();
      if (command == "wait") break;
      act(command);
    }
    glBindFramebuffer(GL_FRAMEBUFFER, target_.framebuffer());
    sandbox_.frame({.width = width, .height = height, .events = queue_.take(sandbox_.keys())}, 1.0 / 60.0);
    ++frame_;
    check();
    return !sandbox_.wantsToClose();
  }

 private:
  // --- chance
  int choose(int count) { return static_cast<int>(random_() % static_cast<std::uint64_t>(count)); }
  double between(double low, double high) { return low + (high - low) * uniform01(random_); }
  template <typename Table>
  const auto& oneOf(const Table& table) {
    return table[static_cast<std::size_t>(choose(static_cast<int>(std::size(table))))];
  }
  static std::string number(double value) { return std::to_string(value); }

  // --- deeds
  void plan(const std::vector<std::string>& commands) {
    planned_.insert(planned_.end(), commands.begin(), commands.end());
  }

  /// Into the replay first, then to the sandbox. A command that is refused with a sentence leaves the replay.
  void act(const std::string& command) {
    const auto before = replay_.tellp();
    replay_ << frame_ << ' ' << command << std::endl;
    try {
      Replay::parse("monkey", std::to_string(frame_) + " " + command).play(frame_, sandbox_, queue_);
    } catch (const std::exception& refusal) {
      replay_.seekp(before);
      replay_ << "# refused: " << command << ": " << refusal.what() << std::endl;
      fs::resize_file(replayPath_, static_cast<std::uintmax_t>(replay_.tellp()));
    }
  }

  std::string somewhere() {
    double x = between(0.0, width), y = between(0.0, height);
    const json& view = status_["view"];
    const int where = choose(10);
    if (where < 3 && !status_["goals"].empty()) {  // at a handle
      const json& pixel = oneOf(status_["goals"])["pixel"];
      x = pixel[0].get<double>() + between(-4.0, 4.0);
      y = pixel[1].get<double>() + between(-4.0, 4.0);
    } else if (where < 6 && !view.is_null()) {  // about the middle of the view
      x = view["x"].get<double>() + view["width"].get<double>() * between(0.3, 0.7);
      y = view["y"].get<double>() + view["height"].get<double>() * between(0.2, 0.8);
    } else if (where == 9) {
      x = between(-50.0, 2.0 * width);
    }
    if (!(std::abs(x) < 1e6 && std::abs(y) < 1e6)) x = y = 0.0;  // a handle behind the eye
    return number(x) + " " + number(y);
  }

  void stroke() {
    const std::string button = oneOf(std::array{"left", "left", "left", "left", "right", "middle"});
    plan({"move " + somewhere(), "press " + button});
    for (int i = choose(8); i > 0; --i) plan({"wait", "move " + somewhere()});
    if (choose(6) == 0)
      plan({"key " + std::string(oneOf(std::array{"x", "y", "z", "p", "escape", "tab", "r"}))});
    plan({"release " + button});
  }

  std::string goalName() {
    return status_["goals"].empty() || choose(20) == 0 ? "nobody"
                                                       : oneOf(status_["goals"])["name"].get<std::string>();
  }

  void think() {
    static const std::array keys{"tab", "space", "delete", "home", "escape", "enter", "f12", "?", "backspace",
                                 "a",   "b",     "c",      "d",    "e",      "f",     "g",   "h", "i",
                                 "j",   "k",     "l",      "m",    "n",      "o",     "p",   "r", "s",
                                 "t",   "u",     "v",      "w",    "x",      "y",     "z",   "1", "2",
                                 "3",   "4",     "5",      "6",    "7",      "8",     "9",   "0"};
    static const std::array models{"figure",     "planar",    "panda",     "ur5",       "wave.bvh",
                                   "broken.bvh", "box.obj",   "two.dh",    "nobody",    "",
                                   "range.obj",  "empty.glb", "list.json", "notes.txt", "saved.json"};
    static const std::array tabs{"Solve",  "Model", "Skin",    "Binding", "Muscles",
                                 "Motion", "Lab",   "Lecture", "Plots"};
    static const std::array solvers{"drag", "two-link", "fabrik", "ccd", "dls", "lm-gain-ratio", "newton"};
    static const std::array shown{"skin",   "wireframe", "skeleton", "weights", "frames",
                                  "limits", "handles",   "ground",   "shadow"};
    static const std::array motions{
        "frame 7", "key",  "key-moved", "delete-key", "turn 20 0 5",        "smooth 3",
        "plant",   "undo", "redo",      "goals on",   "layer wave.bvh 0.5", "frame 999"};
    static const std::array words{"0.5", "-1e9", "nan",  "saved.json",          "wave.bvh",
                                  "../", "hand", "%s%n", "12345678901234567890"};
    const auto control = [&](const std::string& key) {
      plan({"keydown ctrl", "key " + key, "wait", "wait", "keyup ctrl"});
    };
    switch (choose(stage_.paints ? 30 : 26)) {
      case 0:
      case 1:
      case 2:
      case 3:
      case 4:
      case 5: stroke(); break;
      case 6:
      case 7:
      case 8: plan({"key " + std::string(oneOf(keys))}); break;
      case 9: {
        const std::string modifier = oneOf(std::array{"shift", "alt"});
        plan({"keydown " + modifier});
        stroke();
        plan({"keyup " + modifier});
        break;
      }
      case 10: plan({"wheel " + number(between(-5.0, 5.0))}); break;
      case 11:
      case 12: plan({"tab " + std::string(oneOf(tabs)), "wait"}); break;
      case 13: control("z"); break;
      case 14: control(oneOf(std::array{"y", "s", "o", "z"})); break;
      case 15:
        plan({"target " + goalName() + " " + number(between(-2.0, 2.0)) + " " + number(between(-2.0, 2.0)) +
              " " + number(choose(9) == 0 ? 1e4 : between(-2.0, 2.0))});
        break;
      case 16: plan({"pin " + goalName()}); break;
      case 17: plan({"free " + goalName()}); break;
      case 18: plan({"solver " + std::string(oneOf(solvers))}); break;
      case 19: plan({"show " + std::string(oneOf(shown)) + (choose(2) ? " on" : " off")}); break;
      case 20: plan({"text " + std::string(oneOf(words))}); break;
      case 21: plan({"select " + goalName()}); break;
      case 22: plan({"do Motion " + std::string(oneOf(motions))}); break;
      case 23:
        if (choose(3) == 0) plan({"drop " + std::string(oneOf(models))});
        break;
      case 24:
        if (choose(3) == 0) plan({"open " + std::string(oneOf(models))});
        break;
      case 25: plan({std::string("theme ") + (choose(2) ? "dark" : "light")}); break;
      default: plan({"tab Binding", "key " + std::string(oneOf(std::array{"b", "b", "v"}))}); stroke();
    }
  }

  // --- what must hold in every frame
  void check() {
    const std::string text = sandbox_.status();
    status_ = json::parse(text, nullptr, false);
    ASSERT_FALSE(status_.is_discarded()) << text;
    const Skeleton& skeleton = sandbox_.session().skeleton();
    ASSERT_EQ(status_["q"].size(), static_cast<std::size_t>(skeleton.nq()));
    Eigen::VectorXd q(skeleton.nq());
    for (int i = 0; i < skeleton.nq(); ++i) {
      ASSERT_TRUE(status_["q"][i].is_number()) << "q[" << i << "]: " << status_["q"][i];
      q[i] = status_["q"][i].get<double>();
    }
    ASSERT_TRUE(q.allFinite());
    EXPECT_LE(limitViolation(skeleton, q), 1e-6) << "frame " << frame_;
    std::set<std::string> names;
    for (const json& goal : status_["goals"]) {
      const std::string name = goal["name"];
      EXPECT_TRUE(names.insert(name).second) << "two goals called " << name;
      for (const char* entry : {"target", "reached"})
        for (const json& coordinate : goal[entry])
          ASSERT_TRUE(coordinate.is_number()) << name << ' ' << entry << ": " << goal[entry];
      ASSERT_TRUE(goal["error"].is_number()) << name << ": " << goal["error"];
      EXPECT_GE(goal["error"].get<double>(), 0.0) << name;
    }
    EXPECT_TRUE(status_["dragging"].is_null() || names.contains(status_["dragging"])) << status_["dragging"];
    for (const auto& goal : sandbox_.session().goals()) {
      EXPECT_GE(goal.goal.joint, 0);
      EXPECT_LT(goal.goal.joint, skeleton.jointCount())
          << goal.goal.name << " is held at a joint that is not there";
    }
    const json& view = status_["view"];
    EXPECT_TRUE(view["width"].get<double>() >= 0.0 &&
                view["x"].get<double>() + view["width"].get<double>() <= width);
  }

  std::mt19937_64 random_;
  OffscreenContext context_;
  GlDebugLog log_;
  Stage stage_;
  Sandbox sandbox_;
  ViewPicture target_;
  InputQueue queue_;
  std::deque<std::string> planned_;
  json status_ = {{"goals", json::array()}, {"view", nullptr}};
  fs::path replayPath_;
  std::ofstream replay_;
  int frame_ = 0;
};

void letLoose(int seed) {
  const Playground playground(seed);
  const std::string where = "seed " + std::to_string(seed) + ", stage " + stageOf(seed).model + ", replay " +
                            (fs::current_path() / "monkey.replay").string();
  std::printf("%s\n", where.c_str());
  std::fflush(stdout);  // a crash must not take it along
  SCOPED_TRACE(where);
  Monkey monkey(seed, "monkey.replay");
  for (int i = 0; i < frameCount && !::testing::Test::HasFailure() && monkey.frame();) ++i;
}

class MonkeyTest : public ::testing::TestWithParam<int> {};
TEST_P(MonkeyTest, NothingItDoesBreaksTheSandbox) { letLoose(GetParam()); }
// Where memory is watched, every stage at least once; elsewhere the other invariants, by a few.
INSTANTIATE_TEST_SUITE_P(Seeds, MonkeyTest, ::testing::Range(0, testing::sanitized ? 20 : 5));

TEST(Monkey, MoreByHand) {
  const char* range = std::getenv("GELENK_MONKEY");
  if (!range) GTEST_SKIP() << "GELENK_MONKEY=FIRST:COUNT names the seeds";
  int first = 0, count = 1;
  ASSERT_GE(std::sscanf(range, "%d:%d", &first, &count), 1) << range;
  for (int seed = first; seed < first + count && !HasFailure(); ++seed) letLoose(seed);
}

/// What is held, and where.
json heldGoals(const Sandbox& sandbox) {
  json held = json::array();
  const json status = json::parse(sandbox.status());
  for (const json& goal : status["goals"])
    if (goal["state"] != "free") held.push_back({goal["name"], goal["state"], goal["target"]});
  return held;
}

TEST(Monkey, UndoWalksBackThroughRandomEditsAndRedoForwardAgain) {
  const OffscreenContext context;
  for (const char* model : {"figure", "panda", "planar"}) {
    SCOPED_TRACE(model);
    std::mt19937_64 random(7);
    Sandbox sandbox({.model = model, .width = width, .height = height});
    ViewPicture target;
    target.resize(width, height);
    InputQueue queue;
    int frame = 0;
    const auto play = [&](const std::vector<std::string>& commands, int frames) {
      for (const std::string& command : commands)
        Replay::parse("edit", std::to_string(frame) + " " + command).play(frame, sandbox, queue);
      for (int i = 0; i < frames; ++i, ++frame) {
        glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer());
        sandbox.frame({.width = width, .height = height, .events = queue.take(sandbox.keys())}, 1.0 / 60.0);
      }
    };
    play({}, 2);
    std::vector<json> states{heldGoals(sandbox)};
    for (int edit = 0; edit < 25; ++edit) {
      const json goals = json::parse(sandbox.status())["goals"];
      const json& goal = goals[random() % goals.size()];
      const std::string name = goal["name"];
      const auto number = [&] { return std::to_string(2.0 * uniform01(random) - 1.0); };
      switch (random() % 5) {
        case 0: play({"pin " + name}, 2); break;
        case 1: play({"target " + name + " " + number() + " " + number() + " " + number()}, 2); break;
        case 2: play({"key r"}, 3); break;
        case 3: play({"grab " + name, "move 300 150", "release left"}, 5); break;
        default: play({"grab " + name, "release left"}, 5);  // a press without a move is no edit
      }
      states.push_back(heldGoals(sandbox));
    }
    play({"move 1 1", "keydown ctrl"}, 2);
    std::size_t at = states.size() - 1;
    for (int i = 0; i < 30; ++i) {
      play({"key z"}, 3);
      const json now = heldGoals(sandbox);
      while (at > 0 && states[at] != now) --at;
      ASSERT_EQ(states[at], now) << "undo " << i << " gives what never was";
    }
    EXPECT_EQ(heldGoals(sandbox), states.front());
    play({"keydown shift"}, 1);
    for (int i = 0; i < 30; ++i) play({"key z"}, 3);
    EXPECT_EQ(heldGoals(sandbox), states.back());
  }
}

}  // namespace
}  // namespace gelenk
