#pragma once

#include <functional>
#include <string>
#include <vector>

namespace gelenk {

class Sandbox;

/// Something that the sandbox can do, by its name.
struct Action {
  std::string name;  ///< "Open robot panda": what a person would look for
  std::string key;   ///< "Ctrl+S", empty for none
  std::function<void(Sandbox&)> run;
};

/// Every action, model, example, solver, tab and thing to be shown.
std::vector<Action> actionsOf(Sandbox& sandbox);

/// Whether every word of the query stands in the text, without regard to capitals. Words may be cut short:
/// "pan rob" finds "Open robot panda".
bool matches(const std::string& query, const std::string& text);

/// The list of all actions that a few letters narrow down, Ctrl+K.
class CommandPalette {
 public:
  void open();
  bool isOpen() const { return open_; }
  void close() { open_ = false; }
  void draw(Sandbox& sandbox);

 private:
  bool open_ = false, focus_ = false;
  int chosen_ = 0;
  char query_[128] = "";
  std::vector<Action> actions_;
};

}  // namespace gelenk
