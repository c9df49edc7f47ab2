#pragma once

#include <deque>
#include <string>
#include <vector>

#include "apps/sandbox/input.h"

namespace gelenk {

class Sandbox;

/// A recorded or written session: what happens in which frame (docs/sandbox.md lists the commands). Read
/// once, played frame by frame into the same input queue that a window fills.
class Replay {
 public:
  /// Throws ParseError with the line: a frame number missing or going back, an unknown command, a wrong
  /// number of values.
  static Replay read(const std::string& path);
  /// text: the file's content; name: for messages.
  static Replay parse(const std::string& name, const std::string& text);

  /// Adds what happens before frame `number` (from 0) to the queue; commands that are no input act on the
  /// sandbox at once. Throws std::invalid_argument, naming the line, for a goal or solver that is not there.
  void play(int number, Sandbox& sandbox, InputQueue& queue);

  /// First frame after the last event; a drag's moves included.
  int length() const { return length_; }

  struct Command {
    int frame = 0, line = 0;
    std::string verb;
    std::vector<std::string> words;
  };

 private:
  std::string name_;
  std::deque<Command> commands_;
  int length_ = 0;
};

}  // namespace gelenk
