#include "apps/document/notes.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "apps/commands/command_line.h"

namespace gelenk {
namespace {

struct Voice {
  bool quiet = false, strict = false;
};

/// Of the process: set once, by its command line.
Voice& voice() {
  static Voice chosen;
  return chosen;
}

}  // namespace

void addNoteOptions(Command& program) {
  voice() = {};  // of the command line before this one, in tests
  program.optionsAnywhere();
  const Option quiet = program.flag("--quiet", voice().quiet, "Notes about files are not told");
  program.flag("--strict", voice().strict, "Every note about a file is an error").excludes(quiet);
}

void demandNoNotes(const std::string& file, const std::vector<Note>& notes) {
  if (!voice().strict) return;
  for (const Note& note : notes)
    if (!note.fact) throw std::runtime_error(file + ": " + note.line() + " (a note, and --strict)");
}

void sayNotes(const std::string& file, const std::vector<Note>& notes) {
  demandNoNotes(file, notes);
  if (voice().quiet) return;
  for (const Note& note : notes) fmt::print(stderr, "note: {}\n", note.line());
}

bool notesAreQuiet() { return voice().quiet; }

nlohmann::json asJson(const std::vector<Note>& notes) {
  nlohmann::json list = nlohmann::json::array();
  for (const Note& note : notes) {
    list.push_back({{"kind", note.kind}, {"text", note.text}, {"count", note.count}, {"fact", note.fact}});
    if (!note.remedy.empty()) list.back()["remedy"] = note.remedy;
  }
  return list;
}

}  // namespace gelenk
