#include "apps/sandbox/remote.h"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/sandbox/requests.h"
#include "apps/sandbox/sandbox.h"
#include "solvers/iteration/evaluator.h"
#include "solvers/own_solver.h"
#include "solvers/problem/goal_text.h"
#include "solvers/problem/judge.h"

namespace gelenk {
namespace {

std::string dumped(const Json& message) {
  return message.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

/// The pipe: lines in from a thread, lines out, and the solves that the other end does.
struct Remote::Link {
  std::function<void()> wake;
  int out = -1;
  int stop[2] = {-1, -1};  ///< a pipe that ends the reader
  std::atomic<bool> over = false, keep = false, gone = false;
  std::mutex mutex;
  std::condition_variable arrived;
  std::deque<std::string> lines;
  std::map<long, Json> solved;
  long lastSolve = 0;

  void send(const Json& message) {
    const std::string text = dumped(message);
    for (std::size_t done = 0; done < text.size();) {
      const ssize_t n = write(out, text.data() + done, text.size() - done);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) {
        gone = true;
        return;
      }
      done += static_cast<std::size_t>(n);
    }
  }

  void take(std::string line) {
    const std::lock_guard lock(mutex);
    if (line.find("\"solved\"") != std::string::npos) {  // an answer to a solve that may be waited for
      const Json message = Json::parse(line, nullptr, false);
      if (message.is_object() && message.value("do", "") == "solved") {
        solved[message.value("of", 0L)] = message;
        arrived.notify_all();
        return;
      }
    }
    lines.push_back(std::move(line));
    arrived.notify_all();
  }

  void read() {
    std::string rest;
    char chunk[65536];
    while (true) {
      pollfd two[] = {{STDIN_FILENO, POLLIN, 0}, {stop[0], POLLIN, 0}};
      if (poll(two, 2, -1) < 0 && errno != EINTR) break;
      if (two[1].revents) return;
      if (!two[0].revents) continue;
      const ssize_t n = ::read(STDIN_FILENO, chunk, sizeof chunk);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) break;
      rest.append(chunk, static_cast<std::size_t>(n));
      for (std::size_t end; (end = rest.find('\n')) != std::string::npos; rest.erase(0, end + 1))
        take(rest.substr(0, end));
      wake();
    }
    gone = true;
    arrived.notify_all();
    wake();
  }

  /// Asks the other end to solve; an empty object where it does not answer in time.
  Json solve(Json question) {
    long id = 0;
    {
      const std::lock_guard lock(mutex);
      id = ++lastSolve;
    }
    question["of"] = id;
    send(question);
    std::unique_lock lock(mutex);
    constexpr std::chrono::seconds patience(5);
    arrived.wait_for(lock, patience, [&] { return solved.count(id) || gone; });
    const auto found = solved.find(id);
    Json answer = found == solved.end() ? Json::object() : found->second;
    solved.clear();
    return answer;
  }
};

namespace {

/// A method that runs at the other end of the pipe.
class RemoteSolver final : public IkSolver {
 public:
  using Ask = std::function<Json(Json)>;
  RemoteSolver(std::string name, ParameterValues values, Ask ask)
      : name_(std::move(name)), values_(std::move(values)), ask_(std::move(ask)) {}
  std::string whyUnsupported(const IkProblem&) const override { return {}; }
  IkReport solve(const IkProblem& problem, const Budget& budget, TraceLevel) const override {
    const auto begin = std::chrono::steady_clock::now();
    Json goals = Json::array();
    for (const Goal& goal : problem.goals) goals.push_back(goalToText(goal, *problem.skeleton));
    const Json answer = ask_({{"gelenk", messageVersion},
                              {"event", "solve"},
                              {"solver", name_},
                              {"parameters", values_},
                              {"q", std::vector<double>(problem.start.begin(), problem.start.end())},
                              {"goals", goals},
                              {"tolerance", problem.positionTolerance},
                              {"max_iterations", budget.maxIterations}});
    IkReport report;  // a failure, unless an answer comes
    report.q = problem.start;
    if (answer.contains("q") && answer["q"].is_array() &&
        static_cast<int>(answer["q"].size()) == problem.skeleton->nq() &&
        std::all_of(answer["q"].begin(), answer["q"].end(), [](const Json& v) { return v.is_number(); })) {
      const auto q = answer["q"].get<std::vector<double>>();
      report.q = Eigen::VectorXd::Map(q.data(), static_cast<Eigen::Index>(q.size()));
      report.why = judge(problem, report.q).solved ? Stop::Converged : Stop::Stalled;
      report.counters.iterations = answer.value("iterations", 0);
    }
    if (!report.q.allFinite()) {
      report = {};
      report.q = problem.start;
    }
    CountedEvaluator at(problem);
    at.moveTo(report.q);
    report.residual = at.residual().norm();
    report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return report;
  }

 private:
  std::string name_;
  ParameterValues values_;
  Ask ask_;
};

}  // namespace

Remote::Remote(std::function<void()> wake) : link_(std::make_shared<Link>()) {
  link_->wake = std::move(wake);
  std::fflush(stdout);
  link_->out = dup(STDOUT_FILENO);
  if (link_->out < 0 || pipe(link_->stop) != 0 || dup2(STDERR_FILENO, STDOUT_FILENO) < 0)
    throw std::runtime_error("cannot take over standard output");
  signal(SIGPIPE, SIG_IGN);
  reader_ = std::thread([link = link_] { link->read(); });
}

Remote::~Remote() {
  close(link_->stop[1]);
  reader_.join();
  close(link_->stop[0]);
  link_->send({{"gelenk", messageVersion}, {"event", "closed"}});
}

bool Remote::isOver() const {
  const std::lock_guard lock(link_->mutex);  // what came before the end is answered yet
  return link_->over || (link_->gone && !link_->keep && link_->lines.empty());
}

void Remote::wait(double seconds) {
  std::unique_lock lock(link_->mutex);
  link_->arrived.wait_for(lock, std::chrono::duration<double>(std::min(seconds, 0.5)),
                          [&] { return !link_->lines.empty() || link_->gone; });
}

void Remote::receive(Sandbox& sandbox) {
  while (true) {
    std::string line;
    {
      const std::lock_guard lock(link_->mutex);
      if (link_->lines.empty()) return;
      line = std::move(link_->lines.front());
      link_->lines.pop_front();
    }
    answer(sandbox, line);
  }
}

void Remote::answer(Sandbox& sandbox, const std::string& line) {
  Json reply, id;
  try {
    const Json request = Json::parse(line);
    const std::string what = checkedRequest(request);
    id = request.value("id", Json());
    reply = Json::object();
    if (auto answered = answerRequest(sandbox, what, request)) {
      reply = std::move(*answered);
    } else if (what == "events") {
      events_ = request.value("on", true);
      told_.clear();
    } else if (what == "solver") {  // one that runs at the other end
      OwnSolver solver{
          .name = request.at("name"), .title = request.value("title", ""), .reference = "script"};
      for (const Json& p : request.value("parameters", Json::array()))
        solver.parameters.push_back(
            {.name = p.at("name"), .value = p.at("value"), .lower = p.at("lower"), .upper = p.at("upper")});
      solver.make = [name = solver.name, link = link_](const ParameterValues& values) {
        return std::make_unique<RemoteSolver>(name, values,
                                              [link](Json q) { return link->solve(std::move(q)); });
      };
      addSolver(std::move(solver));
    } else if (what == "keep") {
      link_->keep = true;
    } else if (what == "close") {
      link_->over = true;
    } else {
      throw std::invalid_argument("no message is called '" + what + "'; there are: " + requestNames +
                                  ", events, solver, keep, close");
    }
    reply["ok"] = true;
  } catch (const std::exception& error) {
    reply = {{"ok", false}, {"error", error.what()}};
  }
  Json out{{"gelenk", messageVersion}, {"id", id}};
  out.update(reply);
  link_->send(out);
}

void Remote::tell(const Sandbox& sandbox) {
  if (!events_) return;
  Json now = poseMessage(sandbox);
  std::string text = now.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (text == told_) return;
  told_ = std::move(text);
  Json event{{"gelenk", messageVersion}, {"event", "pose"}};
  event.update(now);
  link_->send(event);
}

}  // namespace gelenk
