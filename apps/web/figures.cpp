// Every value of the lecture's examples under Node, a line each: its id, then the numbers with the 11 digits
// that `gelenk lecture` prints.
#include <fmt/format.h>

#include <cstdio>

#include "apps/lecture/example.h"

int main() {
  try {
    for (const gelenk::LectureTopic& topic : gelenk::lectureTopics())
      for (const gelenk::LectureCheck& check : topic.checks) {
        std::string line = check.id;
        for (const double value : gelenk::evaluate(check).computed) line += fmt::format(" {:.11g}", value);
        std::puts(line.c_str());
      }
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}
