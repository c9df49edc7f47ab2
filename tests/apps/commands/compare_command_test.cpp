// The commands as a person types them.
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/commands/commands.h"
#include "apps/document/model.h"
#include "kinematics/configuration.h"
#include "kinematics/forward_kinematics.h"
#include "kinematics/io/text_file.h"
#include "tests/sandbox/program.h"
#include "tests/places.h"

namespace gelenk {

void addCompareCommand(CLI::App& app);
void addSolveCommand(CLI::App& app);

namespace {

namespace fs = std::filesystem;

/// What a command printed, and its exit status or its complaint.
struct Outcome {
  int status = 0;
  std::string output, complaint;
};
Outcome type(std::vector<std::string> words) {
  CLI::App app;
  addCompareCommand(app);
  addSolveCommand(app);
  std::reverse(words.begin(), words.end());  // CLI11 takes them from the back
  Outcome outcome;
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  try {
    app.parse(words);
  } catch (const CLI::RuntimeError& error) {
    outcome.status = error.get_exit_code();
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

TEST(SolveCommand, MistakesAreNamed) {
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
  for (const char* file : {"results.csv", "solutions.csv", "summary.json", "report.html"})
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
    return std::vector<std::string>{testing::programFile(), "compare", "--model",  "panda",
                                    "--set",        "D1",      "--set",    "D5",
                                    "--solver",     "sdls",    "--solver", "evolution",
                                    "--problems",   "100",     "--seeds",  "3",
                                    "--traces",     "20",      "--out",    (folder / out).string()};
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
  EXPECT_NE(complaint({"--problems", "0"}).find("at least 1"), std::string::npos);
  EXPECT_NE(complaint({"--tolerance", "-1"}).find("positive"), std::string::npos);
  EXPECT_NE(complaint({"--traces", "-4"}).find("traces"), std::string::npos);
  EXPECT_NE(complaint({"--model", "nobody.bvh"}).find("nobody.bvh"), std::string::npos);
  EXPECT_NE(complaint({"--shard", "3"}).find("K/N"), std::string::npos);
  EXPECT_NE(complaint({"--reproduce", "cold-fusion"}).find("fabrik-2011"), std::string::npos);
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
