#include "apps/lecture/example.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace gelenk {

const std::vector<LectureTopic>& lectureTopics() {
#define GELENK_MAKE(topic) topic(),
  static const std::vector<LectureTopic> topics{GELENK_LECTURE_TOPICS(GELENK_MAKE)};
#undef GELENK_MAKE
  return topics;
}

LectureVerdict evaluate(const LectureCheck& check) {
  LectureVerdict verdict{.computed = check.compute(), .ok = true};
  if (verdict.computed.size() != check.printed.size()) {
    verdict.ok = false;
    verdict.difference = std::numeric_limits<double>::infinity();
    return verdict;
  }
  const std::vector<double>& expected = check.corrected.empty() ? check.printed : check.corrected;
  for (std::size_t i = 0; i < check.printed.size(); ++i) {
    const double printed = expected.at(i), computed = verdict.computed[i];
    const double tolerance = check.tolerance.size() == 1 ? check.tolerance[0] : check.tolerance.at(i);
    const double allowed =
        tolerance * (1.0 + 1e-9);  // a value that stands exactly between two printed digits
    verdict.difference = std::max(verdict.difference, std::abs(computed - check.printed[i]));
    switch (check.comparison) {
      case Comparison::Equal: verdict.ok = verdict.ok && std::abs(computed - printed) <= allowed; break;
      case Comparison::AtMost: verdict.ok = verdict.ok && computed <= printed; break;
      case Comparison::AtLeast: verdict.ok = verdict.ok && computed >= printed; break;
    }
  }
  return verdict;
}

const LectureTopic& findLectureTopic(std::string_view id) {
  std::string known;
  for (const LectureTopic& topic : lectureTopics()) {
    if (topic.id == id) return topic;
    for (const LectureCheck& check : topic.checks)
      if (check.id == id) return topic;
    known += (known.empty() ? "" : ", ") + topic.id;
  }
  throw std::invalid_argument("no example of the lecture is called '" + std::string(id) +
                              "'; there are: " + known);
}

}  // namespace gelenk
