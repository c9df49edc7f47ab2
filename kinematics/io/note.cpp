#include "kinematics/io/note.h"

#include <algorithm>

namespace gelenk {

std::string Note::line() const {
  return remedy.empty() ? lineWithoutRemedy() : lineWithoutRemedy() + " (" + remedy + ")";
}

std::string Note::lineWithoutRemedy() const {
  return count > 1 ? text + " (" + std::to_string(count) + " of this kind)" : text;
}

void tell(std::vector<Note>& notes, const std::string& kind, const std::string& text, int count,
          const std::string& remedy) {
  const auto known = std::find_if(notes.begin(), notes.end(), [&](const Note& n) { return n.kind == kind; });
  if (known != notes.end())
    known->count += count;
  else
    notes.push_back({.kind = kind, .text = text, .count = count, .remedy = remedy});
}

void tell(std::vector<Note>& notes, const std::vector<Note>& others) {
  for (const Note& note : others)
    note.fact ? tellFact(notes, note.kind, note.text, note.remedy)
              : tell(notes, note.kind, note.text, note.count, note.remedy);
}

void tellFact(std::vector<Note>& notes, const std::string& kind, const std::string& text,
              const std::string& remedy) {
  notes.push_back({.kind = kind, .text = text, .fact = true, .remedy = remedy});
}

std::string listed(const std::vector<std::string>& words, int most) {
  std::string list;
  const int shown = std::min(most, static_cast<int>(words.size()));
  for (int k = 0; k < shown; ++k) list += (k ? ", " : "") + words[k];
  const int more = static_cast<int>(words.size()) - shown;
  return more > 0 ? list + " and " + std::to_string(more) + " more" : list;
}

}  // namespace gelenk
