#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

/// Every example in the order of the slides, one function each in topics_*.cpp. Table, tests and the
/// sandbox's menu learn it from here.
#define GELENK_LECTURE_TOPICS(ROW)                                          \
  ROW(planarForwardTopic)      /* 10.1, 10.1.1, 10.1.2 */                   \
  ROW(twoLinkTopic)            /* 10.1.3 */                                 \
  ROW(newtonOneDimensionTopic) /* 10.1.4 */                                 \
  ROW(newtonSquareTopic)       /* 10.1.4, n = m */                          \
  ROW(pseudoInverseTopic)      /* 10.1.4, n > m */                          \
  ROW(shortestPathTopic)       /* 10.1.4, the minimum over all solutions */ \
  ROW(rotationsTopic)          /* 10.2, Euler angles and quaternions */     \
  ROW(denavitHartenbergTopic)  /* 10.2, Denavit-Hartenberg */               \
  ROW(legTopic)                /* 10.1.1, hierarchical animation */

namespace gelenk {

/// How a computed value is held against the printed one.
enum class Comparison {
  Equal,    ///< |computed - printed| <= tolerance
  AtMost,   ///< computed <= printed (a bound that the lecture or a mathematical fact sets)
  AtLeast,  ///< computed >= printed
};

/// One printed value of the slides (a number, a point, a matrix row by row) or one checkable claim, and its
/// computation.
struct LectureCheck {
  std::string id;                 ///< unique, such as "planar-fk-p2"
  std::string section;            ///< where it stands on the slides
  std::string what;               ///< in words or symbols
  std::vector<double> printed;    ///< as on the slide
  std::vector<double> tolerance;  ///< half a printed digit each; one value stands for all
  std::function<std::vector<double>()> compute;
  Comparison comparison = Comparison::Equal;
  std::vector<double> corrected =
      {};                 ///< where the slide's value is wrong: what is compared instead; empty otherwise
  std::string note = {};  ///< where the slide rounds or is wrong: what and how
};

/// One example of the lecture: its checks, and the whole derivation with every intermediate value.
struct LectureTopic {
  std::string id;  ///< as typed: `gelenk lecture ID --steps`
  std::string section;
  std::string title;
  std::string (*steps)();
  std::vector<LectureCheck> checks;
};

/// Lecture 10.1 and 10.2, every example, in the order of the slides: one list for the table, the tests and
/// the sandbox.
const std::vector<LectureTopic>& lectureTopics();

struct LectureVerdict {
  std::vector<double> computed;
  double difference = 0.0;  ///< largest |computed - printed|
  bool ok = false;
};
LectureVerdict evaluate(const LectureCheck& check);

/// The topic of that id, or the one that holds a check of that id. Throws std::invalid_argument listing the
/// topics.
const LectureTopic& findLectureTopic(std::string_view id);

#define GELENK_DECLARE(topic) LectureTopic topic();
GELENK_LECTURE_TOPICS(GELENK_DECLARE)
#undef GELENK_DECLARE

}  // namespace gelenk
