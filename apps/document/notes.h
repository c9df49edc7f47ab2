#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "kinematics/io/note.h"

namespace gelenk {

class Command;

/// --quiet and --strict, which every command understands. Before the commands are added.
void addNoteOptions(Command& program);

/// "note: ..." on standard error, one line a kind; nothing with --quiet. With --strict the first note that is
/// no mere fact is thrown as std::runtime_error. Commands call this before they write anything.
void sayNotes(const std::string& file, const std::vector<Note>& notes);

/// With --strict as above; for commands that print the notes in their own answer.
void demandNoNotes(const std::string& file, const std::vector<Note>& notes);

/// True with --quiet.
bool notesAreQuiet();

/// [{"kind", "text", "count", "fact"}, ...] and "remedy" where there is one, whatever --quiet says.
nlohmann::json asJson(const std::vector<Note>& notes);

}  // namespace gelenk
