#include "apps/commands/command_line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>

#include "apps/commands/commands.h"

namespace gelenk {
namespace {

using ::testing::HasSubstr;

/// One option of every kind of number.
struct Numbers {
  int count = 0;
  double factor = 0.0, rate = 0.0, share = 0.0;
  std::uint64_t seed = 0;
  std::optional<double> angle;
  std::optional<int> layers;
  std::vector<double> q;
  std::string name, view;
};

/// The error's sentence; empty where the words are taken.
std::string sentence(std::vector<std::string> words, Numbers* read = nullptr) {
  Numbers numbers;
  CommandLine line("test", "0");
  Command command = line.root().command("count", "");
  command.option("--keys", numbers.count, "").positive();
  command.option("--factor", numbers.factor, "").positive();
  command.option("--share", numbers.share, "").range(0.1, 8.0);
  command.option("--fps", numbers.rate, "").frameRate();
  command.option("--seed", numbers.seed, "");
  command.option("--angle", numbers.angle, "");
  command.option("--layers", numbers.layers, "").range(1, 4);
  command.option("--q", numbers.q, "");
  command.option("--name", numbers.name, "");
  command.option("--view", numbers.view, "").oneOf({"front", "side"});
  words.insert(words.begin(), "count");
  try {
    line.parse(words);
  } catch (const UsageError& error) {
    return error.what();
  }
  if (read) *read = numbers;
  return "";
}

TEST(CommandLine, NoNumberIsNanOrInfinite) {
  for (const char* option : {"--factor", "--share", "--fps", "--angle", "--q"}) {
    for (const char* word :
         {"nan", "NaN", "-nan", "inf", "-inf", "Infinity", "1e999", "-1e999", "", "x", "1,5"})
      EXPECT_THAT(sentence({option, word}), HasSubstr(std::string(option) + ": expected a number, found '"))
          << word;
    EXPECT_EQ(sentence({option, "+1.5e0"}), "");
  }
  EXPECT_THAT(sentence({"--q", "0.1", "nan", "0.2"}), HasSubstr("found 'nan' (not a number)"));
  for (const char* option : {"--keys", "--seed", "--layers"})
    for (const char* word : {"nan", "inf", "1.5", "1e3", "99999999999999999999999"})
      EXPECT_THAT(sentence({option, word}),
                  HasSubstr(std::string(option) + ": expected a whole number, found '"))
          << word;
}

TEST(CommandLine, ErrorsOfRangesSayWhatIsExpectedAndFound) {
  EXPECT_EQ(sentence({"--keys", "0"}), "--keys: expected a whole number above 0, found 0");
  EXPECT_EQ(sentence({"--factor", "-2.5"}), "--factor: expected a number above 0, found -2.5");
  EXPECT_EQ(sentence({"--share", "9"}), "--share: expected a number from 0.1 to 8, found 9");
  EXPECT_EQ(sentence({"--layers", "5"}), "--layers: expected a whole number from 1 to 4, found 5");
  for (const char* rate : {"1e-300", "0", "1e12"})
    EXPECT_EQ(sentence({"--fps", rate}),
              std::string("--fps: expected a number from 0.01 to 10000, found ") + rate);
}

TEST(CommandLine, AnEmptyWordIsNotTakenForNone) {
  EXPECT_EQ(sentence({"--name", ""}), "--name: expected a word, found ''");
  EXPECT_EQ(sentence({"--name", " "}), "");
}

TEST(CommandLine, AWordThatIsNoneOfTheListIsToldWithTheList) {
  EXPECT_EQ(sentence({"--view", "back"}), "--view: expected one of front, side, found 'back'");
  EXPECT_EQ(sentence({"--view", "side"}), "");
}

TEST(CommandLine, NumbersAreReadAsTheyStand) {
  Numbers read;
  ASSERT_EQ(sentence({"--keys", "7", "--seed", "18446744073709551615", "--angle", "-12.5", "--q", "-1",
                      "2e-3", "--fps", "120"},
                     &read),
            "");
  EXPECT_EQ(read.count, 7);
  EXPECT_EQ(read.seed, 18446744073709551615u);
  EXPECT_EQ(read.angle, -12.5);
  EXPECT_EQ(read.q, (std::vector<double>{-1.0, 2e-3}));
  EXPECT_EQ(read.rate, 120.0);
}

}  // namespace
}  // namespace gelenk
