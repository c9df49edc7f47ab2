// Lecture 10.1: what its examples draw in the plane, seen from above.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "apps/lecture/slide_data.h"
#include "apps/render/lecture_drawing.h"
#include "apps/render/ui_style.h"
#include "kinematics/notation/planar_chain.h"

namespace gelenk {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double degree = M_PI / 180.0;
const Vector3d ex = Vector3d::UnitX(), ey = Vector3d::UnitY();

Vector3d inSpace(const Vector2d& p) { return {p.x(), p.y(), 0.0}; }

std::string pair(const Vector2d& p, const char* format = "({:.5g}, {:.5g})") {
  return fmt::format(fmt::runtime(format), std::abs(p.x()) < 1e-12 ? 0.0 : p.x(),
                     std::abs(p.y()) < 1e-12 ? 0.0 : p.y());
}

/// Beside a mark, by so much.
void label(const LectureCanvas& canvas, const Vector3d& mark, const Vector3d& beside, const std::string& text,
           const Colour& colour) {
  canvas.labels.push_back({mark + beside, text, withAlpha(colour, 1.0f), mark});
}

LectureColours coloursOf(const LectureCanvas& canvas) {
  return lectureColours(canvas.session.document().theme);
}

}  // namespace

LectureColours lectureColours(Theme theme) {
  const ImVec4& ink = palette(theme).text;
  const Colour text{ink.x, ink.y, ink.z, 1.0f};
  if (theme == Theme::Dark)
    return {.first = {0.42f, 0.70f, 0.95f, 0.95f},
            .second = {0.95f, 0.62f, 0.25f, 0.95f},
            .linear = {0.98f, 0.48f, 0.58f, 1.0f},
            .truth = {0.35f, 0.80f, 0.62f, 1.0f},
            .target = {0.98f, 0.48f, 0.58f, 1.0f},
            .faint = {0.8f, 0.8f, 0.8f, 0.35f},
            .text = text};
  return {.first = {0.12f, 0.47f, 0.71f, 0.95f},
          .second = {0.84f, 0.45f, 0.07f, 0.95f},
          .linear = {0.80f, 0.20f, 0.35f, 1.0f},
          .truth = {0.10f, 0.55f, 0.40f, 1.0f},
          .target = {0.80f, 0.20f, 0.35f, 1.0f},
          .faint = {0.2f, 0.2f, 0.25f, 0.30f},
          .text = text};
}

void PlanarDrawing::links(Overlay& overlay, const VectorXd& phi, const Colour& colour, float width) const {
  std::vector<Vector3d> points;
  for (const Vector2d& p : linkPoints(chain, phi)) points.push_back(inSpace(p));
  overlay.polyline(points, colour, width);
  for (std::size_t i = 0; i + 1 < points.size(); ++i) overlay.point(points[i], colour, 7.0f);
  overlay.point(points.back(), colour, 9.0f, Overlay::Shape::Ring);
}

void PlanarDrawing::cross(const LectureCanvas& canvas, const Vector2d& at, const std::string& text) const {
  const Colour colour = coloursOf(canvas).target;
  const double a = 0.022 * chain.reach();
  const Vector3d p = inSpace(at);
  canvas.overlay.line(p - a * (ex + ey), p + a * (ex + ey), colour, 2.5f);
  canvas.overlay.line(p - a * (ex - ey), p + a * (ex - ey), colour, 2.5f);
  label(canvas, p, 1.4 * a * (ex + ey), text, colour);
}

// --- 10.1.2: forward kinematics

ForwardDrawing::ForwardDrawing()
    : PlanarDrawing({.base = Vector2d::Zero(),
                     .lengths = {slide::forwardLengths.begin(), slide::forwardLengths.end()}}) {}

void ForwardDrawing::draw(const LectureCanvas& canvas) {
  const LectureColours colours = coloursOf(canvas);
  const VectorXd& phi = canvas.session.q();
  if (phi.size() != chain.linkCount()) return;  // another model
  const auto P = linkPoints(chain, phi);
  const auto K = hierarchicalFrames(chain, phi);
  double sum = 0.0;
  for (int i = 0; i < chain.linkCount(); ++i) {  // the angle from the link before, and the frame K_i
    const double radius = 0.28 * chain.lengths[i];
    canvas.overlay.dashedLine(inSpace(P[i]),
                              inSpace(P[i]) + 1.5 * radius * (std::cos(sum) * ex + std::sin(sum) * ey),
                              0.12 * radius, colours.faint);
    const double turn = std::remainder(phi[i], 2.0 * M_PI);
    canvas.overlay.arc(inSpace(P[i]), ex, ey, radius, colours.second, 2.0f, std::min(sum, sum + turn),
                       std::max(sum, sum + turn));
    sum += phi[i];
    if (!frames) continue;
    const double length = 0.12 * chain.reach();
    const Vector3d at = inSpace(P[i]);
    canvas.overlay.line(at, at + length * inSpace(K[i].linear().col(0)), {0.83f, 0.24f, 0.20f, 1}, 2.5f);
    canvas.overlay.line(at, at + length * inSpace(K[i].linear().col(1)), {0.20f, 0.60f, 0.25f, 1}, 2.5f);
  }
  links(canvas.overlay, phi, colours.first);
  for (std::size_t i = 0; i < P.size(); ++i)
    label(canvas, inSpace(P[i]),
          chain.reach() * (i % 2 ? Vector3d(0.035, 0.045, 0) : Vector3d(0.035, -0.075, 0)),
          fmt::format("{}{} {}", i + 1 < P.size() ? "P" : "X = P", i + 1, pair(P[i], "({:.3f}, {:.3f})")),
          colours.text);
}

std::string ForwardDrawing::save() const { return frames ? "1" : "0"; }
void ForwardDrawing::load(const Session&, const std::string& text) { frames = text != "0"; }

// --- 10.1.3: two links

TwoLinkDrawing::TwoLinkDrawing()
    : PlanarDrawing({.base = Vector2d::Zero(), .lengths = {slide::armLength, slide::armLength}}),
      lastTarget(slide::armTarget) {}

Vector2d TwoLinkDrawing::target(const Session& session) {
  if (const auto goal = session.findGoal("end-effector"))
    if (const SceneGoal& g = session.goal(*goal); g.state != GoalState::Free)
      lastTarget = g.goal.target.head<2>();
  return lastTarget;
}

TwoLinkSolution TwoLinkDrawing::solve(const Session& session) {
  return solveTwoLink(chain.base, chain.lengths[0], chain.lengths[1], target(session));
}

void TwoLinkDrawing::draw(const LectureCanvas& canvas) {
  const LectureColours colours = coloursOf(canvas);
  const Vector2d X = target(canvas.session);
  const TwoLinkSolution solution = solve(canvas.session);
  const Colour branchColours[] = {colours.second, colours.first};
  for (int i = 0; i < solution.count; ++i) {
    const TwoLinkBranch& b = solution.branch[i];
    links(canvas.overlay, Vector2d(b.phi1, b.phi2), branchColours[i], 3.0f);
    label(
        canvas, inSpace(linkPoints(chain, Vector2d(b.phi1, b.phi2))[1]), Vector3d(0.6, 0.6, 0),
        fmt::format("phi = ({:.1f}, {:.1f}) deg", std::remainder(b.phi1, 2 * M_PI) / degree, b.phi2 / degree),
        branchColours[i]);
  }
  if (candidates)
    for (const ArctangentCandidate& c :
         arctangentCandidates(chain.base, chain.lengths[0], chain.lengths[1], X))
      if (c.distance > 1e-6 && std::isfinite(c.distance)) {
        const auto P = linkPoints(chain, Vector2d(c.phi1, c.phi2));
        for (int i = 0; i < 2; ++i)
          canvas.overlay.dashedLine(inSpace(P[i]), inSpace(P[i + 1]), 0.35, colours.linear, 1.5f);
        label(canvas, inSpace(P[1]), Vector3d(0.6, -0.8, 0), "arctangent, misses", colours.linear);
      }
  cross(canvas, X, "X " + pair(X, "({:.2f}, {:.2f})"));
}

std::string TwoLinkDrawing::save() const {
  return fmt::format("{} {} {}", lastTarget.x(), lastTarget.y(), candidates ? 1 : 0);
}
void TwoLinkDrawing::load(const Session&, const std::string& text) {
  std::istringstream words(text);
  Vector2d X;
  int shown = 1;
  if (!(words >> X.x() >> X.y() >> shown)) return;
  lastTarget = X;
  candidates = shown != 0;
}

// --- 10.1.4: one dimension

OneDimensionDrawing::OneDimensionDrawing()
    : PlanarDrawing({.base = Vector2d::Zero(), .lengths = {slide::armLength}}), start(slide::oneLinkStart) {
  restart();
}

void OneDimensionDrawing::restart() {
  run = newton1d(oneLinkHeight, start, target, delta, 1e-13);
  at = 0;
}

void OneDimensionDrawing::draw(const LectureCanvas& canvas) {
  const LectureColours colours = coloursOf(canvas);
  const double r = 1.1 * chain.reach();
  canvas.overlay.dashedLine({-r, target, 0}, {r, target, 0}, 0.3, colours.target, 2.0f);
  label(canvas, {-r, target, 0}, 0.5 * ey, fmt::format("height X = {:g}", target), colours.target);
  for (std::size_t i = 0; i < run.size() && i <= at; ++i) {
    const Vector3d end = inSpace(endEffector(chain, VectorXd::Constant(1, run[i].phi)));
    const bool now = i == at;
    canvas.overlay.line(Vector3d::Zero(), end, now ? colours.first : colours.faint, now ? 3.0f : 1.5f);
    canvas.overlay.point(end, now ? colours.first : colours.faint, now ? 10.0f : 7.0f);
    label(canvas, end, 0.05 * end, fmt::format("phi^{}", i), now ? colours.first : colours.text);
  }
}

std::string OneDimensionDrawing::save() const { return fmt::format("{} {} {} {}", start, target, delta, at); }
void OneDimensionDrawing::load(const Session&, const std::string& text) {
  std::istringstream words(text);
  double from, X, step;
  std::size_t shown;
  if (!(words >> from >> X >> step >> shown)) return;
  start = from, target = X, delta = step;
  restart();
  at = std::min(shown, run.size() - 1);
}

// --- 10.1.4: several dimensions

NewtonDrawing::NewtonDrawing(NewtonExample e)
    : PlanarDrawing(e == NewtonExample::Square ? PlanarChain{.base = Vector2d::Zero(),
                                                             .lengths = {slide::armLength, slide::armLength}}
                                               : lecturePlanarChain()),
      example(e) {
  setSlide();
  if (example == NewtonExample::Shortest) at = run.steps.size() - 1;
}

void NewtonDrawing::setSlide() {
  start = example == NewtonExample::Square ? VectorXd(slide::squareStart) : VectorXd(slide::startAngles);
  target = example == NewtonExample::Square ? slide::armTarget : slide::newTarget;
  restart();
}

void NewtonDrawing::restart() {
  run = planarNewton(chain, start, target, 1e-12 * chain.reach());
  best_.reset();
  at = 0;
}

const NearestSolution& NewtonDrawing::best() {
  if (!best_) best_ = nearestSolution(chain, start, target, run.steps.back().phi);
  return *best_;
}

/// The end-effector's real way while phi moves straight from phi^i to phi^(i+1).
void NewtonDrawing::truePath(Overlay& overlay, std::size_t i, const Colour& colour, float width) const {
  const NewtonStep& s = run.steps[i];
  if (s.step.size() == 0) return;
  std::vector<Vector3d> path;
  for (int k = 0; k <= 40; ++k) path.push_back(inSpace(endEffector(chain, s.phi + s.step * (k / 40.0))));
  overlay.polyline(path, colour, width);
}

void NewtonDrawing::draw(const LectureCanvas& canvas) {
  const LectureColours colours = coloursOf(canvas);
  Overlay& over = canvas.overlay;
  const NewtonStep& now = run.steps[at];
  for (std::size_t i = 0; i < at; ++i) {  // where it came from
    over.point(inSpace(run.steps[i].f), colours.faint, 7.0f);
    truePath(over, i, colours.faint, 1.5f);
  }
  if (example == NewtonExample::Shortest && best().phi.size() > 0)
    links(over, best().phi, colours.truth, 7.0f);
  links(over, now.phi, colours.first, 3.0f);
  if (now.step.size() > 0) {
    links(over, now.phi + now.step, colours.second, 2.0f);
    over.dashedLine(inSpace(now.f), inSpace(now.linearised), 0.018 * chain.reach(), colours.linear, 2.5f);
    truePath(over, at, colours.truth, 2.5f);
    const Vector2d end = run.steps[at + 1].f;
    if (now.step.norm() > 0.05)
      label(canvas, inSpace(end), Vector3d(0, -0.05 * chain.reach(), 0),
            fmt::format("f(phi^{}) {}", at + 1, pair(end, "({:.2f}, {:.2f})")), colours.truth);
  }
  if (now.g.norm() > 0.1 * chain.reach())
    label(canvas, inSpace(now.f), Vector3d(-0.02, 0.045, 0) * chain.reach(),
          fmt::format("f(phi^{}) {}", at, pair(now.f, "({:.2f}, {:.2f})")), colours.first);
  cross(canvas, target, "X^neu " + pair(target, "({:g}, {:g})"));
}

std::string NewtonDrawing::save() const {
  std::string text = fmt::format("{} {} {}", at, target.x(), target.y());
  for (const double angle : start) text += fmt::format(" {}", angle);
  return text;
}
void NewtonDrawing::load(const Session&, const std::string& text) {
  std::istringstream words(text);
  std::size_t shown;
  if (!(words >> shown)) return;
  Vector2d X;
  VectorXd from(start.size());
  words >> X.x() >> X.y();
  for (double& angle : from) words >> angle;
  if (words) {
    start = from, target = X;
    restart();
  }
  at = std::min(shown, run.steps.size() - 1);
}

}  // namespace gelenk
