#include "apps/render/mathematics.h"

#include <gtest/gtest.h>

namespace gelenk {
namespace {

using Place = MathRun::Place;
using Runs = std::vector<MathRun>;

TEST(Mathematics, NewtonsStepIsSetAsOnTheSlide) {
  EXPECT_EQ(setMathematics("phi^(i+1) = phi^i - D_f(phi^i)^-1"),
            (Runs{{.text = "φ"},
                  {.text = "i+1", .place = Place::Super},
                  {.text = " = φ"},
                  {.text = "i", .place = Place::Super},
                  {.text = " − D"},
                  {.text = "f", .place = Place::Sub},
                  {.text = "(φ"},
                  {.text = "i", .place = Place::Super},
                  {.text = ")"},
                  {.text = "−1", .place = Place::Super}}));
}

TEST(Mathematics, ScriptsStandAboveEachOther) {
  EXPECT_EQ(setMathematics("D_f^+"),
            (Runs{{.text = "D"}, {.text = "f", .place = Place::Sub}, {.text = "+", .place = Place::Super}}));
  EXPECT_EQ(setMathematics("X^neu"), (Runs{{.text = "X"}, {.text = "neu", .place = Place::Super}}));
  EXPECT_EQ(setMathematics("phi_1"), (Runs{{.text = "φ"}, {.text = "1", .place = Place::Sub}}));
}

TEST(Mathematics, RootsAndSigns) {
  EXPECT_EQ(setMathematics("sqrt(l_1^2) <= pi"), (Runs{{.text = "√"},
                                                       {.text = "l", .overline = true},
                                                       {.text = "1", .place = Place::Sub, .overline = true},
                                                       {.text = "2", .place = Place::Super, .overline = true},
                                                       {.text = " ≤ π"}}));
}

TEST(Mathematics, FractionsStandOverABar) {
  EXPECT_EQ(setMathematics("phi - (f(phi) - X) / f'(phi), or"),
            (Runs{{.text = "φ − "},
                  {.above = {{.text = "f(φ) − X"}}, .below = {{.text = "f'(φ)"}}},
                  {.text = ", or"}}));
  const Runs cosine = setMathematics("c = (dx^2 - l_1) / (2 l_1 (a + b)) = 1");
  ASSERT_EQ(cosine.size(), 3u);
  EXPECT_EQ(cosine[1].above.size(), 4u);
  EXPECT_EQ(cosine[1].below,
            (Runs{{.text = "2 l"}, {.text = "1", .place = Place::Sub}, {.text = " (a + b)"}}));
  EXPECT_EQ(setMathematics("f(x) / 2"),
            (Runs{{.text = "f(x) / 2"}}));  // a function's bracket is no numerator
}

TEST(Mathematics, DifferentialsOfGreekLettersAndTheirQuotients) {
  EXPECT_EQ(
      setMathematics("df / dphi_1"),
      (Runs{{.above = {{.text = "df"}}, .below = {{.text = "dφ"}, {.text = "1", .place = Place::Sub}}}}));
  EXPECT_EQ(setMathematics("J dtheta"), (Runs{{.text = "J dθ"}}));
  EXPECT_EQ(setMathematics("distance / d, d / d"), (Runs{{.text = "distance / d, d / d"}}));
}

TEST(Mathematics, PowersOfTenIndicesAndArrows) {
  EXPECT_EQ(setMathematics("-1.5e-07, D = 1e-6"), (Runs{{.text = "−1.5 · 10"},
                                                        {.text = "−7", .place = Place::Super},
                                                        {.text = ", D = 10"},
                                                        {.text = "−6", .place = Place::Super}}));
  EXPECT_EQ(setMathematics("5.529e+00"), (Runs{{.text = "5.529"}}));
  EXPECT_EQ(setMathematics("0.0e+00"), (Runs{{.text = "0"}}));
  EXPECT_EQ(setMathematics("{-60, 2}"), (Runs{{.text = "{−60, 2}"}}));
  EXPECT_EQ(setMathematics("P1"), (Runs{{.text = "P"}, {.text = "1", .place = Place::Sub}}));
  EXPECT_EQ(setMathematics("| ||q|| - 1 |"), (Runs{{.text = "| ‖q‖ − 1 |"}}));
  EXPECT_EQ(setMathematics("T_(i -> j)"), (Runs{{.text = "T"},
                                                {.text = "i ", .place = Place::Sub},
                                                {.text = "→", .place = Place::Sub},
                                                {.text = " j", .place = Place::Sub}}));
}

TEST(Mathematics, OrdinaryWordsStayAsTheyAre) {
  for (const char* text : {"philosophy", "multiple", "at 3 ^ 4", "(3, 4)", "sigmas", "AB12", "e",
                           "version 1.25, 7", "a well-known arm", "x1.5"})
    EXPECT_EQ(setMathematics(text), (Runs{{.text = text}})) << text;
  EXPECT_TRUE(setMathematics("").empty());
}

}  // namespace
}  // namespace gelenk
