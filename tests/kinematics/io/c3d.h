#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace gelenk::testing {

/// Optical markers of a C3D file by label: per frame a position in file units (CMU: millimetres, axes y z x
/// of the ASF); frames without a measurement are NaN. Reads little-endian files with integer or float points,
/// enough for the checks here.
struct C3d {
  int frames = 0;
  std::map<std::string, std::vector<Eigen::Vector3d>> markers;
};

inline C3d parseC3d(const std::string& bytes) {
  const auto read = [&](std::size_t at, auto value) {
    if (at + sizeof value > bytes.size()) throw std::runtime_error("C3D: cut off");
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
  };
  const int points = read(2, std::int16_t{}), analogPerFrame = read(4, std::int16_t{});
  const int first = read(6, std::uint16_t{}), last = read(8, std::uint16_t{});
  const float scale = read(12, float{});
  const std::size_t data = (read(16, std::uint16_t{}) - 1) * std::size_t{512};
  const int wordSize = scale < 0 ? 4 : 2;

  // Parameters: records of name length, group id, name, offset to the next, ...; find LABELS of the group
  // POINT.
  std::vector<std::string> labels;
  std::size_t at = (static_cast<unsigned char>(bytes[0]) - 1) * std::size_t{512} + 4;
  int pointGroup = 0;
  for (int pass = 0; pass < 2; ++pass)  // groups may come after their parameters
    for (std::size_t p = at; bytes[p] != 0;) {
      const int nameLength = std::abs(read(p, std::int8_t{})), group = read(p + 1, std::int8_t{});
      const std::string name = bytes.substr(p + 2, nameLength);
      const std::size_t link = p + 2 + nameLength;
      const int next = read(link, std::int16_t{});
      if (group < 0 && name == "POINT") pointGroup = -group;
      if (group > 0 && group == pointGroup && name == "LABELS" && labels.empty()) {
        const int width = static_cast<unsigned char>(bytes[link + 4]),
                  count = static_cast<unsigned char>(bytes[link + 5]);
        for (int k = 0; k < count; ++k) {
          std::string label = bytes.substr(link + 6 + k * width, width);
          label.erase(label.find_last_not_of(' ') + 1);
          labels.push_back(label.substr(label.find(':') + 1));
        }
      }
      if (next == 0) break;
      p = link + next;
    }

  C3d result{.frames = last - first + 1, .markers = {}};
  const std::size_t frameSize = (4 * points + analogPerFrame) * std::size_t(wordSize);
  for (int f = 0; f < result.frames; ++f)
    for (int m = 0; m < points && m < static_cast<int>(labels.size()); ++m) {
      double v[4];
      for (int k = 0; k < 4; ++k) {
        const std::size_t word = data + f * frameSize + (4 * m + k) * wordSize;
        v[k] = scale < 0 ? read(word, float{}) : (k < 3 ? scale : 1.0f) * read(word, std::int16_t{});
      }
      const bool measured = v[3] >= 0.0;
      result.markers[labels[m]].push_back(measured ? Eigen::Vector3d(v[0], v[1], v[2])
                                                   : Eigen::Vector3d::Constant(std::nan("")));
    }
  return result;
}

}  // namespace gelenk::testing
