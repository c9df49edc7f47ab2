// The commands as a person types them.
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/commands/command_line.h"
#include "apps/commands/commands.h"
#include "apps/document/model.h"
#include "kinematics/configuration.h"
#include "kinematics/forward_kinematics.h"
#include "kinematics/io/csv.h"
#include "kinematics/io/text_file.h"
#include "solvers/problem/goal_text.h"
#include "solvers/problem/ik_solver.h"
#include "solvers/problem/judge.h"
#include "tests/places.h"
#include "tests/sandbox/program.h"

namespace gelenk {

void addCompareCommand(Command& app);
void addSolveCommand(Command& app);

namespace {

namespace fs = std::filesystem;

/// What a command printed, and its exit status or its complaint.
struct Outcome {
  int status = 0;
  std::string output, complaint;
};
Outcome type(std::vector<std::string> words) {
  CommandLine line("", "");
  Command program = line.root();
  addCompareCommand(program);
  addSolveCommand(program);
  Outcome outcome;
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  try {
    line.parse(std::move(words));
  } catch (const ExitStatus& answer) {
    outcome.status = answer.status;
  } catch (const std::exception& error) {
    outcome.status = 1;
    outcome.complaint = error.what();
  }
  outcome.output = ::testing::internal::GetCapturedStdout();
  ::testing::internal::GetCapturedStderr();
  return outcome;
}

std::vector<std::string> targetWords(const Skeleton& panda, const Eigen::VectorXd& q) {
  const Eigen::Isometry3d tip = forwardKinematics(panda, q).back();
  const Eigen::Quaterniond r(tip.linear());
  std::vector<std::string> words;
  for (double x :
       {tip.translation().x(), tip.translation().y(), tip.translation().z(), r.w(), r.x(), r.y(), r.z()})
    words.push_back(exactNumber(x));
  return words;
}

TEST(SolveCommand, PrintsASolutionThatForwardKinematicsConfirms) {
  const Skeleton panda = openModel("panda").skeleton;
  std::mt19937_64 random(4);
  for (const char* solver : {"default", "lm-gain-ratio", "exact-hessian"}) {
    const Eigen::VectorXd there = randomWithinLimits(panda, random);
    std::vector<std::string> words{"solve", "--model", "panda", "--solver", solver, "--target"};
    for (const std::string& word : targetWords(panda, there)) words.push_back(word);
    const Outcome outcome = type(words);
    EXPECT_EQ(outcome.status, 0) << outcome.complaint;
    const auto out = nlohmann::json::parse(outcome.output);
    EXPECT_TRUE(out["solved"].get<bool>());
    const auto q = out["solution"].get<std::vector<double>>();
    const Eigen::Isometry3d reached = forwardKinematics(panda, Eigen::VectorXd::Map(q.data(), 7)).back();
    const Eigen::Isometry3d wanted = forwardKinematics(panda, there).back();
    EXPECT_LE((reached.translation() - wanted.translation()).norm(), 1e-6);
    EXPECT_LE(Eigen::AngleAxisd(reached.linear().transpose() * wanted.linear()).angle(), 1e-6 + 1e-8);
  }
}

TEST(SolveCommand, SaysByItsExitStatusThatATargetIsOutOfReach) {
  const Outcome outcome = type({"solve", "--model", "panda", "--target", "5", "0", "0", "--solver",
                                "lm-gain-ratio", "--restarts", "2", "--trace"});
  EXPECT_EQ(outcome.status, 2);
  const auto out = nlohmann::json::parse(outcome.output);
  EXPECT_FALSE(out["solved"].get<bool>());
  EXPECT_GT(out["position_error"].get<double>(), 3.0);
  EXPECT_GT(out["trace"].size(), 3u);
}

TEST(SolveCommand, TheDefaultFitsTheModel) {
  for (std::vector<std::string> words :
       {std::vector<std::string>{"--model", "figure", "--joint", "hand_r", "--target", "-0.3", "1.2", "0.3"},
        {"--model", "figure", "--goal", "hand_r=-0.3,1.2,0.3", "--goal", "hand_l=0.3,1.2,0.3"},
        {"--model", "balls:1,1,1", "--target", "1", "1", "0.5"}}) {
    words.insert(words.begin(), "solve");
    const Outcome outcome = type(words);
    EXPECT_EQ(outcome.status, 0) << outcome.output << outcome.complaint;
  }
}

/// data/cases: an arm with its target on its own line, and a robot whose other arm is nobody's business.
TEST(SolveCommand, AStraightArmBendsAndTheOtherArmStays) {
  const std::string cases = testing::dataFolder() + "/cases/";
  if (!fs::exists(cases + "two_arms.urdf")) GTEST_SKIP() << "no trial data";
  for (const char* solver :
       {"default", "serial-pose", "drag", "lm-chan", "lm-gain-ratio", "exact-hessian", "dls", "ccd", "fabrik",
        "evolution", "qp", "bfgs", "ceres-lm", "task-priority"}) {
    const Outcome straight =
        type({"solve", "--model", cases + "straight.urdf", "--target", "1.2", "0", "0", "--start", "0", "0",
              "--solver", solver, "--restarts", "0", "--max-iterations", "2000"});
    EXPECT_EQ(straight.status, 0) << solver << straight.output << straight.complaint;
    if (straight.status == 0) {  // q = +-(0.9273, -1.8546)
      const auto q = nlohmann::json::parse(straight.output)["solution"].get<std::vector<double>>();
      const double elbow = std::remainder(q[1], 2.0 * M_PI), shoulder = std::remainder(q[0], 2.0 * M_PI);
      EXPECT_NEAR(std::abs(elbow), 1.8546, 1e-4) << solver;
      EXPECT_NEAR(shoulder, -0.5 * elbow, 1e-4) << solver;
    }
    for (const char* x : {"1.2", "3.5"}) {  // with restarts in vain too
      const Outcome two =
          type({"solve", "--model", cases + "two_arms.urdf", "--joint", "ltip", "--target", x, "0.1", "0",
                "--start", "0", "0.3", "0", "--restarts", "5", "--solver", solver});
      const auto out = nlohmann::json::parse(two.output);
      EXPECT_EQ(two.status, x[0] == '1' ? 0 : 2) << solver << two.output;
      EXPECT_EQ(out["joints"]["ra"].get<double>(), 0.3) << solver;
    }
  }
}

TEST(SolveCommand, NumbersAreNamedAndComeInDegreesOnDemand) {
  const std::vector<std::string> words{"solve", "--model", "panda", "--target", "0.4", "0.2", "0.5"};
  std::vector<std::string> inDegrees = words;
  inDegrees.insert(inDegrees.end(), {"--q-format", "degrees"});
  const auto radians = nlohmann::json::parse(type(words).output),
             degrees = nlohmann::json::parse(type(inDegrees).output);
  const Skeleton panda = openModel("panda").skeleton;
  const auto names = radians["coordinates"].get<std::vector<std::string>>();
  ASSERT_EQ(names.size(), 7u);
  for (std::size_t k = 0; k < 7; ++k) {
    EXPECT_NEAR(degrees["solution"][k].get<double>(), radians["solution"][k].get<double>() * 180.0 / M_PI,
                1e-9);
    EXPECT_EQ(radians["joints"][names[k]], radians["solution"][k]);
    EXPECT_GE(panda.jointIndex(names[k]), 0);
  }
  EXPECT_EQ(degrees["q_format"], "degrees");
  inDegrees.insert(inDegrees.end(), {"--start"});
  for (int k = 0; k < 7; ++k) inDegrees.push_back(exactNumber(degrees["solution"][k].get<double>()));
  const auto again = nlohmann::json::parse(type(inDegrees).output);  // starts where it ended: nothing to do
  for (std::size_t k = 0; k < 7; ++k)
    EXPECT_NEAR(again["solution"][k].get<double>(), degrees["solution"][k].get<double>(), 1e-6);
}

/// An arm of five joints, its target turned out of what it can do.
class FiveJoints : public ::testing::Test {
 protected:
  void SetUp() override {
    path = (fs::path(::testing::TempDir()) / "gelenk-five.dh").string();
    std::ofstream(path)
        << "dh standard\nname five\nrevolute 0 pi/2 0.1 0 -2.6 2.6\nrevolute 0.2 0 0 0 -2.6 2.6\n"
           "revolute 0.2 0 0 0 -2.6 2.6\nrevolute 0 pi/2 0 pi/2 -2.6 2.6\nrevolute 0 0 0.12 0 -2.6 2.6\n";
  }
  nlohmann::json solve(std::vector<std::string> more) const {
    std::vector<std::string> words{"solve", "--model", path,  "--target", "0.25", "0.1",
                                   "0.2",   "0.5",     "0.5", "0.5",      "0.5"};
    words.insert(words.end(), more.begin(), more.end());
    return nlohmann::json::parse(type(words).output);
  }
  std::string path;
};

TEST_F(FiveJoints, PositionFirstMeetsThePositionAndTurnsAsWellAsItCan) {
  const auto plain = solve({}), first = solve({"--position-first"});
  EXPECT_GT(plain["position_error"].get<double>(), 1e-3);
  EXPECT_LE(first["position_error"].get<double>(), 1e-6);
  // no better orientation at this place: the lowest of a thousand starts of the same two-part problem
  const Skeleton arm = openModel(path).skeleton;
  const Eigen::Quaterniond wanted(0.5, 0.5, 0.5, 0.5);
  std::mt19937_64 random(2);
  double best = 10.0;
  for (int i = 0; i < 1000; ++i) {
    IkProblem problem{.skeleton = &arm, .start = randomWithinLimits(arm, random)};
    problem.goals = {{.joint = 5, .target = {0.25, 0.1, 0.2}, .priority = 0},
                     {.kind = GoalKind::Orientation, .joint = 5, .orientation = wanted, .priority = 1}};
    const IkReport report = makeSolver("task-priority")
                                ->solve(problem, {.maxIterations = 100, .maxSeconds = 1e9}, TraceLevel::Off);
    const Judgement verdict = judge(problem, report.q);
    if (verdict.goals[0].position <= 1e-5) best = std::min(best, verdict.goals[1].orientation);
  }
  EXPECT_LE(first["orientation_error"].get<double>(), best + 1e-3);
}

TEST_F(FiveJoints, AnAxisAloneIsMet) {
  // the tool's axis in the plane of the arm at this azimuth: what five joints can do
  const double azimuth = std::atan2(0.1, 0.25);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(azimuth, Eigen::Vector3d::UnitZ()) *
                                Eigen::AngleAxisd(2.0, Eigen::Vector3d::UnitY()) *
                                Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()));
  std::vector<std::string> words{"solve", "--model", path, "--axis", "z", "--target", "0.25", "0.1", "0.2"};
  for (double x : {turn.w(), turn.x(), turn.y(), turn.z()}) words.push_back(exactNumber(x));
  const Outcome outcome = type(words);
  const auto out = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  const auto q = out["solution"].get<std::vector<double>>();
  const Eigen::Isometry3d tip =
      forwardKinematics(openModel(path).skeleton, Eigen::VectorXd::Map(q.data(), 5)).back();
  EXPECT_LE((tip.translation() - Eigen::Vector3d(0.25, 0.1, 0.2)).norm(), 1e-6);
  EXPECT_LE((tip.linear().col(2) - turn.toRotationMatrix().col(2)).norm(), 1e-5);
  const Goal told = goalFromText(out["goals"][1]["goal"].get<std::string>(), openModel(path).skeleton);
  EXPECT_EQ(out["goals"][1]["kind"], "direction");
  EXPECT_EQ(told.axisInJoint, Eigen::Vector3d::UnitZ());
  EXPECT_LE((told.direction - turn.toRotationMatrix().col(2)).norm(), 1e-15);  // rounding
}

/// The answer says what was asked for, in numbers that a person may have typed.
TEST(SolveCommand, GoalsAreToldAsTheyWereGiven) {
  const std::string file = (fs::path(::testing::TempDir()) / "gelenk-told-goals.json").string();
  std::ofstream(file) << R"([{"joint": "head", "axis": [0, 0, 2], "direction": [0, 0, -1]}])";
  const std::string goals[] = {"direction joint=head axis=0,0,1 direction=0,0,-1",
                               "aim joint=head axis=0,0,1 target=0,0,-1000000000000",
                               "position joint=hand_r point=0,0,0.125 target=-0.25,1.125,0.25"};
  const auto told = [](const std::vector<std::string>& words) {
    return nlohmann::json::parse(type(words).output)["goals"][0]["goal"].get<std::string>();
  };
  EXPECT_EQ(told({"solve", "--model", "figure", "--restarts", "0", "--goals", file}), goals[0]);
  EXPECT_EQ(told({"solve", "--model", "panda", "--axis=-y", "--target", "0", "1", "0", "0"}),
            "direction joint=tool axis=0,-1,0 direction=0,1,0");
  const Skeleton figure = openModel("figure").skeleton;
  for (const std::string& goal : goals) {
    const std::string back = told({"solve", "--model", "figure", "--restarts", "0", "--goal", goal});
    EXPECT_TRUE(asksTheSame(goalFromText(back, figure), goalFromText(goal, figure))) << back;
  }
}

TEST_F(FiveJoints, WeightsShiftTheErrorFromOnePartToTheOther) {
  const auto positions = solve({"--goal-weights", "100", "1"}), turns = solve({"--goal-weights", "1", "100"});
  EXPECT_LT(positions["position_error"].get<double>(), 0.5 * turns["position_error"].get<double>());
  EXPECT_GT(positions["orientation_error"].get<double>(), turns["orientation_error"].get<double>());
}

TEST(SolveCommand, OrientationAloneAndGoalsFromAFile) {
  const Outcome turned = type({"solve", "--model", "panda", "--target", "0.5", "0.5", "0.5", "0.5"});
  EXPECT_EQ(turned.status, 0) << turned.output;
  const auto out = nlohmann::json::parse(turned.output);
  EXPECT_EQ(out["goals"][0]["kind"], "orientation");
  const auto q = out["solution"].get<std::vector<double>>();
  const Eigen::Isometry3d tip =
      forwardKinematics(openModel("panda").skeleton, Eigen::VectorXd::Map(q.data(), 7)).back();
  EXPECT_LE(Eigen::Quaterniond(tip.linear()).angularDistance(Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5)),
            1e-6 + 1e-8);
  const std::string file = (fs::path(::testing::TempDir()) / "gelenk-goals.json").string();
  std::ofstream(file) << R"([{"joint": "hand_r", "target": [-0.3, 1.2, 0.3], "weight": 2},
                             {"joint": "head", "axis": [0, 0, 1], "direction": [1, 0, 1]}])";
  const Outcome both = type({"solve", "--model", "figure", "--goals", file});
  EXPECT_EQ(both.status, 0) << both.output << both.complaint;
  std::ofstream(file) << R"([{"joint": "hand_r", "targt": [-0.3, 1.2, 0.3]}])";
  EXPECT_NE(type({"solve", "--model", "figure", "--goals", file}).complaint.find("'targt'"),
            std::string::npos);
  std::ofstream(file) << "[{";
  EXPECT_NE(type({"solve", "--model", "figure", "--goals", file}).complaint.find("JSON"), std::string::npos);
}

TEST(SolveCommand, ATableOfTargetsGivesATableOfAnswers) {
  const std::string in = (fs::path(::testing::TempDir()) / "gelenk-targets.csv").string(),
                    out = (fs::path(::testing::TempDir()) / "gelenk-answers.csv").string();
  const Skeleton panda = openModel("panda").skeleton;
  std::mt19937_64 random(6);
  std::string text = "x,y,z,qw,qx,qy,qz\n";
  std::vector<Eigen::Isometry3d> wanted;
  for (int i = 0; i < 200; ++i) {
    const Eigen::VectorXd there = randomWithinLimits(panda, random);
    std::string line;
    for (const std::string& word : targetWords(panda, there)) line += (line.empty() ? "" : ",") + word;
    text += line + '\n';
    wanted.push_back(forwardKinematics(panda, there).back());
  }
  std::ofstream(in) << text;
  const Outcome outcome = type({"solve", "--model", "panda", "--targets", in, "--answers", out});
  EXPECT_EQ(outcome.status, 0) << outcome.complaint;
  const std::string answers = readFile(out);
  CsvReader reader(answers);
  std::vector<std::string> fields;
  ASSERT_TRUE(reader.next(fields));
  ASSERT_EQ(fields.size(), 12u);
  EXPECT_EQ(fields[4], "orientation_error");
  for (int i = 0; i < 200; ++i) {
    ASSERT_TRUE(reader.next(fields));
    EXPECT_EQ(fields[2], "1");
    Eigen::VectorXd q(7);
    for (int k = 0; k < 7; ++k) q[k] = *parseNumber(fields[5 + k]);
    const Eigen::Isometry3d tip = forwardKinematics(panda, q).back();
    EXPECT_LE((tip.translation() - wanted[i].translation()).norm(), 1e-6);
    EXPECT_EQ(limitViolation(panda, q), 0.0);
  }
  EXPECT_FALSE(reader.next(fields));
  // positions, another solver, an unreachable one among them
  std::ofstream(in) << "x,y,z\n0.4,0.2,0.5\n9,0,0\n";
  const Outcome some =
      type({"solve", "--model", "panda", "--targets", in, "--solver", "dls", "--restarts", "5"});
  EXPECT_EQ(some.status, 2);
  EXPECT_NE(some.output.find("\n1,converged,1,"), std::string::npos);
  EXPECT_NE(some.output.find("\n2,"), std::string::npos);
  // as a spreadsheet writes it
  std::ofstream(in) << "\xef\xbb\xbfX, Y, Z\r\n 0.4 , 0.2,0.5\r\n  \r\n\"0.3\",0.2,+5e-1\r\n";
  const Outcome sheet = type({"solve", "--targets", in});
  EXPECT_EQ(sheet.status, 0) << sheet.complaint;
  EXPECT_NE(sheet.output.find("\n2,converged,1,"), std::string::npos);
  std::ofstream(in) << "x,y,z\n0.4,0.2,\"0,5\"\n";
  EXPECT_NE(
      type({"solve", "--targets", in}).complaint.find(":2: expected a finite number, found '0,5' (the "),
      std::string::npos);
  std::ofstream(in) << "x,y,z\n0.4,0.2,0.5\n9,0\n";
  EXPECT_NE(type({"solve", "--targets", in}).complaint.find(":3: expected 3 values"), std::string::npos);
  std::ofstream(in) << "a,b\n";
  EXPECT_NE(type({"solve", "--targets", in}).complaint.find(":1: expected a header"), std::string::npos);
}

TEST(SolveCommand, ParametersReachTheSolver) {
  const std::vector<std::string> words{"solve",    "--target", "0.4",        "0.2", "0.5",
                                       "--solver", "dls",      "--restarts", "0"};
  std::vector<std::string> with = words;
  with.insert(with.end(), {"--set", "dls.lambda=2", "--set", "dls.largest-step=0.1"});
  const auto usual = nlohmann::json::parse(type(words).output),
             set = nlohmann::json::parse(type(with).output);
  EXPECT_NE(usual["counters"]["iterations"], set["counters"]["iterations"]);
  EXPECT_EQ(set["solver"], "dls[lambda=2,largest-step=0.1]");
  for (const char* bad : {"dls.lamda=2", "dls.lambda=99", "lambda=2", "ccd.arm=2"}) {
    std::vector<std::string> wrong = words;
    wrong.insert(wrong.end(), {"--set", bad});
    EXPECT_NE(type(wrong).complaint, "") << bad;
  }
}

TEST(SolveCommand, MistakesAreNamed) {
  EXPECT_NE(type({"solve"}).complaint.find("nothing is asked for"), std::string::npos);
  EXPECT_NE(type({"solve", "--goal", "hand"}).complaint.find("position, orientation, pose"),
            std::string::npos);
  EXPECT_NE(type({"solve", "--goal", "hand=1,2,3"}).complaint.find("hand"), std::string::npos);
  EXPECT_NE(type({"solve", "--target", "1", "2", "3", "--axis", "z"}).complaint.find("QW QX QY QZ"),
            std::string::npos);
  EXPECT_NE(type({"solve", "--target", "1", "2"}).complaint.find("X Y Z QW QX QY QZ"), std::string::npos);
  EXPECT_NE(type({"solve", "--target", "1", "2", "3", "1", "1", "0", "0"}).complaint.find("length 1"),
            std::string::npos);
  EXPECT_NE(type({"solve", "--target", "1", "0", "0", "--solver", "newtonn"}).complaint.find("exact-hessian"),
            std::string::npos);
  EXPECT_NE(type({"solve", "--target", "1", "0", "0", "--joint", "hand"}).complaint.find("hand"),
            std::string::npos);
  EXPECT_NE(type({"solve", "--target", "1", "0", "0", "--start", "1"}).complaint.find("7 values"),
            std::string::npos);
  EXPECT_NE(type({"solve", "--model", "pandda", "--target", "1", "0", "0"}).complaint.find("panda"),
            std::string::npos);
}

TEST(CompareCommand, WritesTheFolderItPromises) {
  const std::string folder = (fs::path(::testing::TempDir()) / "gelenk-compare-command").string();
  fs::remove_all(folder);
  const Outcome outcome = type({"compare", "--model", "panda", "--set", "D1", "--solver", "dls", "--solver",
                                "default", "--problems", "5", "--out", folder});
  EXPECT_EQ(outcome.status, 0) << outcome.complaint;
  EXPECT_NE(outcome.output.find("D1[restarts=50]"), std::string::npos);  // one attempt, and what a user gets
  for (const char* file : {"results.csv", "solutions.csv", "solvers.csv", "summary.json", "report.html"})
    EXPECT_TRUE(fs::exists(folder + '/' + file)) << file;
  const std::string solutions = readFile(folder + "/solutions.csv");
  EXPECT_EQ(
      solutions.substr(0, solutions.find('\n')),
      "model,set,solver,problem,status,start_1,start_2,start_3,start_4,start_5,start_6,start_7,target_x,"
      "target_y,target_z,target_qw,target_qx,"
      "target_qy,target_qz,solution_1,solution_2,solution_3,solution_4,solution_5,solution_6,solution_7");
  fs::remove_all(folder);
}

/// The file without its last columns, which hold times.
std::string withoutLastColumns(const std::string& path, int columns) {
  std::string out;
  const std::string text = readFile(path);
  for (std::string_view line : splitLines(text)) {
    for (int k = 0; k < columns; ++k) line = line.substr(0, line.rfind(','));
    out += std::string(line) + '\n';
  }
  return out;
}

TEST(CompareCommand, ARunThatIsKilledAgainAndAgainEndsWithTheBitsOfAnUninterruptedOne) {
  const fs::path folder = fs::path(::testing::TempDir()) / "gelenk-compare-killed";
  fs::remove_all(folder);
  const auto words = [&](const char* out) {
    return std::vector<std::string>{testing::programFile(),
                                    "compare",
                                    "--model",
                                    "panda",
                                    "--set",
                                    "D1",
                                    "--set",
                                    "D5",
                                    "--solver",
                                    "sdls",
                                    "--solver",
                                    "evolution",
                                    "--problems",
                                    "100",
                                    "--seeds",
                                    "3",
                                    "--traces",
                                    "20",
                                    "--restarts",
                                    "0",
                                    "--out",
                                    (folder / out).string()};
  };
  ASSERT_EQ(testing::runProgram(words("whole")).status, 0);
  const fs::path results = folder / "cut" / "results.csv";
  const auto size = [&] { return fs::exists(results) ? fs::file_size(results) : 0; };
  int kills = 0;
  for (bool ended = false; !ended;) {
    testing::Program program(words("cut"));
    const auto before = size();
    // mid-solve: a few more lines than there were, and no end of the run
    while (program.running() && size() < before + 4000)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ended = !program.running();
    if (ended) break;
    program.kill();
    ++kills;
    ASSERT_LT(kills, 100);
  }
  EXPECT_GE(kills, 1);
  for (const auto& [file, times] : {std::pair{"/results.csv", 2},
                                    {"/seeds.csv", 1},
                                    {"/traces.csv", 1},
                                    {"/solutions.csv", 0},
                                    {"/goals.csv", 0},
                                    {"/problem_sets.csv", 0}})
    EXPECT_EQ(withoutLastColumns((folder / "whole").string() + file, times),
              withoutLastColumns((folder / "cut").string() + file, times))
        << file;
  EXPECT_TRUE(fs::exists(folder / "cut" / "report.html"));
  fs::remove_all(folder);
}

TEST(CompareCommand, MistakesAreNamedAndNothingIsWritten) {
  const std::string folder = (fs::path(::testing::TempDir()) / "gelenk-compare-mistakes").string();
  fs::remove_all(folder);
  const auto complaint = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "compare");
    words.insert(words.end(), {"--out", folder});
    const Outcome outcome = type(words);
    EXPECT_EQ(outcome.status, 1);
    EXPECT_FALSE(fs::exists(folder));
    return outcome.complaint;
  };
  EXPECT_NE(complaint({"--solver", "newtonn"}).find("pseudo-inverse"), std::string::npos);
  EXPECT_NE(complaint({"--set", "D9"}).find("D1, D2"), std::string::npos);
  EXPECT_NE(complaint({"--solver", "dls", "--set", "dls.lamda=1"}).find("there are: lambda"),
            std::string::npos);
  EXPECT_NE(complaint({"--solver", "ccd", "--set", "dls.lambda=1"}).find("not used"), std::string::npos);
  EXPECT_NE(complaint({"--solver", "dls[lambda=99]"}).find("0 to 10"), std::string::npos);
  EXPECT_NE(complaint({"--sweep", "dls.lambda=1:2"}).find("logN or linN"), std::string::npos);
  EXPECT_NE(complaint({"--problems", "0"}).find("at least 1"), std::string::npos);
  EXPECT_NE(complaint({"--tolerance", "-1"}).find("positive"), std::string::npos);
  EXPECT_NE(complaint({"--traces", "-4"}).find("traces"), std::string::npos);
  EXPECT_NE(complaint({"--model", "nobody.bvh"}).find("nobody.bvh"), std::string::npos);
  EXPECT_NE(complaint({"--shard", "3"}).find("K/N"), std::string::npos);
  EXPECT_NE(complaint({"--reproduce", "cold-fusion"}).find("fabrik-2011"), std::string::npos);
}

TEST(CompareCommand, ASweepRunsItsGridAndPlotsIt) {
  const std::string folder = (fs::path(::testing::TempDir()) / "gelenk-compare-sweep").string();
  fs::remove_all(folder);
  const Outcome outcome =
      type({"compare", "--model", "planar:0,0:1,1,1", "--sweep", "dls.lambda=0.01:1:log5", "--set", "D1",
            "--set", "dls.largest-step=0.3", "--problems", "10", "--restarts", "0", "--out", folder});
  EXPECT_EQ(outcome.status, 0) << outcome.complaint;
  EXPECT_NE(outcome.output.find("dls[lambda=0.03162,largest-step=0.3]"), std::string::npos) << outcome.output;
  EXPECT_EQ(outcome.output.find("dls[largest-step=0.3]"), std::string::npos);  // the grid is in its place
  const std::string html = readFile(folder + "/report.html");
  if (html.find("gnuplot was not found") == std::string::npos) {
    EXPECT_NE(html.find("dls.lambda of dls[largest-step=0.3]"), std::string::npos);
  }
  fs::remove_all(folder);
}

TEST(CompareCommand, AnExperimentWritesOverItsOwnFilesOnly) {
  const std::string folder = (fs::path(::testing::TempDir()) / "gelenk-compare-reproduce").string(),
                    page = folder + "/squared-tolerance.md";
  fs::remove_all(folder);
  fs::create_directories(folder);
  writeFile(page, "my notes\n");
  const std::vector<std::string> words{"compare", "--reproduce", "squared-tolerance", "--out", folder};
  EXPECT_NE(type(words).complaint.find("nothing was changed"), std::string::npos);
  EXPECT_EQ(readFile(page), "my notes\n");
  EXPECT_FALSE(fs::exists(folder + "/squared-tolerance.json"));
  fs::remove(page);
  EXPECT_EQ(type(words).complaint, "");
  EXPECT_EQ(type(words).complaint, "");
  fs::remove_all(folder);
}

TEST(Program, EndsWithZeroOneOrTwo) {
  const auto status = [](std::vector<std::string> words) {
    words.insert(words.begin(), testing::programFile());
    return testing::runProgram(words).status;
  };
  EXPECT_EQ(status({}), 1);
  EXPECT_EQ(status({"solve"}), 1);
  EXPECT_EQ(status({"compare", "--nothing"}), 1);
  EXPECT_EQ(status({"compare", "--goal", "aim"}), 1);
  EXPECT_EQ(status({"fk", "panda", "--q", "0", "--csv"}), 1);
  EXPECT_EQ(status({"solve", "--target", "9", "0", "0"}), 2);
  EXPECT_EQ(status({"solve", "--target", "0.4", "0.2", "0.5"}), 0);
  EXPECT_EQ(status({"--help"}), 0);
  EXPECT_EQ(status({"fk", "--help"}), 0);
}

}  // namespace
}  // namespace gelenk
