#pragma once

#include <string>
#include <vector>

namespace gelenk {

/// What a user should know about a file that was read all the same: something taken otherwise than written,
/// passed over, or unlikely. All readers tell it in this one way.
struct Note {
  std::string kind;         ///< one word a kind, such as "frame-count": docs/formats/README.md lists them
  std::string text;         ///< of the first one that was met
  int count = 1;            ///< how many there are of this kind
  bool fact = false;        ///< worth knowing, but nothing departs from the file: --strict lets it pass
  std::string remedy = {};  ///< which option of the command line changes it; the window has its own ways

  /// The text, with the remedy, and with the count where there are several: one line a kind.
  std::string line() const;
  std::string lineWithoutRemedy() const;
  operator std::string() const { return line(); }
};

/// Adds a note; one of a kind that was told before only adds to its count.
void tell(std::vector<Note>& notes, const std::string& kind, const std::string& text, int count = 1,
          const std::string& remedy = {});
void tell(std::vector<Note>& notes, const std::vector<Note>& others);
void tellFact(std::vector<Note>& notes, const std::string& kind, const std::string& text,
              const std::string& remedy = {});

/// "a, b, c", with the rest counted where there are more than `most`: "a, b, c and 4 more".
std::string listed(const std::vector<std::string>& words, int most = 8);

}  // namespace gelenk
