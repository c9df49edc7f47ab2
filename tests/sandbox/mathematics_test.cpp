#include "apps/sandbox/mathematics.h"

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
                  {.text = " - D"},
                  {.text = "f", .place = Place::Sub},
                  {.text = "(φ"},
                  {.text = "i", .place = Place::Super},
                  {.text = ")"},
                  {.text = "-1", .place = Place::Super}}));
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

TEST(Mathematics, OrdinaryWordsStayAsTheyAre) {
  for (const char* text : {"philosophy", "multiple", "at 3 ^ 4", "1.5e-07, (3, 4)", "sigmas"})
    EXPECT_EQ(setMathematics(text), (Runs{{.text = text}})) << text;
  EXPECT_TRUE(setMathematics("").empty());
}

}  // namespace
}  // namespace gelenk
