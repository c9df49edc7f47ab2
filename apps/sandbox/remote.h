#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

namespace gelenk {

class Sandbox;

/// A program that drives the sandbox over standard input and output: a JSON object a line, requests in,
/// replies and events out (docs/sandbox.md, "Driven by a program"). Standard output belongs to it from then
/// on; what else is printed goes to standard error. One at a time.
class Remote {
 public:
  /// wake: called from another thread when something has arrived.
  explicit Remote(std::function<void()> wake);
  ~Remote();
  Remote(const Remote&) = delete;
  Remote& operator=(const Remote&) = delete;

  /// Answers the requests that have arrived. Between frames.
  void receive(Sandbox& sandbox);
  /// Tells the pose and the goals where they changed and events were asked for. After a frame.
  void tell(const Sandbox& sandbox);
  /// The program has ended or asked for the end, and did not ask that the window stays.
  bool isOver() const;
  /// Sleeps until something arrives, at most so many seconds.
  void wait(double seconds);

 private:
  struct Link;  ///< what own solvers share with it, and may outlive it
  void answer(Sandbox& sandbox, const std::string& line);

  std::shared_ptr<Link> link_;
  std::thread reader_;
  std::string told_;
  bool events_ = false;
};

}  // namespace gelenk
