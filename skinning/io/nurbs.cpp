#include "skinning/io/nurbs.h"

#include <stdexcept>

#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"

namespace gelenk {
namespace {

class NurbsReader {
 public:
  NurbsReader(std::string_view text, const std::string& name) : name_(name) {
    int number = 0;
    for (const std::string_view line : splitLines(plainText(text, name))) {
      ++number;
      const auto words = splitWords(line.substr(0, line.find('#')));
      if (!words.empty()) lines_.push_back({number, words});
    }
  }

  NurbsSurface read() {
    NurbsSurface surface;
    const auto version = next("nurbs", 1, "'nurbs 1', the format's name and version");
    if (version[0] != "1") fail("version 1", "'" + std::string(version[0]) + "'");
    readPair("degree", surface.degreeU, surface.degreeV, 1, 9);
    readPair("points", surface.countU, surface.countV, 2, 10000);
    const long total = static_cast<long>(surface.countU) * surface.countV;
    if (total > 1000000) fail("at most 1000000 control points", std::to_string(total));
    surface.knotsU = readKnots("knots_u", surface.countU + surface.degreeU + 1);
    surface.knotsV = readKnots("knots_v", surface.countV + surface.degreeV + 1);
    for (long i = 0; i < total; ++i) {
      const auto words = next(
          "point", 4,
          "point " + std::to_string(i + 1) + " of " + std::to_string(total) + " as 'point x y z weight'");
      double values[4];
      for (int k = 0; k < 4; ++k) values[k] = number(words[k]);
      if (!(values[3] > 0.0)) fail("a positive weight", "'" + std::string(words[3]) + "'");
      surface.points.emplace_back(values[0], values[1], values[2]);
      surface.weights.push_back(values[3]);
    }
    if (at_ < lines_.size()) {
      line_ = lines_[at_].number;
      fail("the end of the file after " + std::to_string(total) + " points",
           "'" + std::string(lines_[at_].words[0]) + "'");
    }
    try {
      validate(surface);
    } catch (const std::invalid_argument& error) {
      throw ParseError(name_, 0, "a valid surface", error.what());
    }
    return surface;
  }

 private:
  struct Line {
    int number;
    std::vector<std::string_view> words;
  };

  [[noreturn]] void fail(const std::string& expected, const std::string& found) const {
    throw ParseError(name_, line_, expected, found);
  }

  /// The words after the keyword of the next line; count < 0: any number.
  std::vector<std::string_view> next(std::string_view keyword, int count, const std::string& expected) {
    if (at_ >= lines_.size()) fail(expected, "the end of the file");
    const Line& line = lines_[at_++];
    line_ = line.number;
    if (line.words[0] != keyword) fail(expected, "'" + std::string(line.words[0]) + "'");
    if (count >= 0 && static_cast<int>(line.words.size()) != count + 1)
      fail(expected + " (" + std::to_string(count) + " values)",
           std::to_string(line.words.size() - 1) + " values");
    return {line.words.begin() + 1, line.words.end()};
  }

  double number(std::string_view word) const {
    const auto value = parseNumber(word);
    if (!value) fail("a finite number", badNumber(word));
    return *value;
  }

  void readPair(const char* keyword, int& u, int& v, int lower, int upper) {
    const auto words = next(keyword, 2, std::string("'") + keyword + "' with two integers");
    int* targets[] = {&u, &v};
    for (int k = 0; k < 2; ++k) {
      const auto value = parseInteger(words[k]);
      if (!value || *value < lower || *value > upper)
        fail("an integer from " + std::to_string(lower) + " to " + std::to_string(upper),
             "'" + std::string(words[k]) + "'");
      *targets[k] = *value;
    }
  }

  std::vector<double> readKnots(const char* keyword, int count) {
    const auto words =
        next(keyword, count,
             std::string("'") + keyword + "' with points + degree + 1 = " + std::to_string(count) + " knots");
    std::vector<double> knots;
    for (const std::string_view word : words) {
      knots.push_back(number(word));
      if (knots.size() > 1 && knots.back() < knots[knots.size() - 2])
        fail("knots that do not decrease", "'" + std::string(word) + "'");
    }
    return knots;
  }

  std::string name_;
  std::vector<Line> lines_;
  std::size_t at_ = 0;
  int line_ = 0;
};

}  // namespace

NurbsSurface parseNurbs(std::string_view text, const std::string& name) {
  return NurbsReader(text, name).read();
}

NurbsSurface readNurbs(const std::string& path) { return parseNurbs(readFile(path), path); }

std::string nurbsText(const NurbsSurface& surface) {
  std::string text = "nurbs 1\ndegree " + std::to_string(surface.degreeU) + " " +
                     std::to_string(surface.degreeV) + "\npoints " + std::to_string(surface.countU) + " " +
                     std::to_string(surface.countV) + "\n";
  const auto knots = [&](const char* keyword, const std::vector<double>& values) {
    text += keyword;
    for (const double value : values) text += " " + exactNumber(value);
    text += "\n";
  };
  knots("knots_u", surface.knotsU);
  knots("knots_v", surface.knotsV);
  for (std::size_t i = 0; i < surface.points.size(); ++i)
    text += "point " + exactNumber(surface.points[i].x()) + " " + exactNumber(surface.points[i].y()) + " " +
            exactNumber(surface.points[i].z()) + " " + exactNumber(surface.weights[i]) + "\n";
  return text;
}

}  // namespace gelenk
