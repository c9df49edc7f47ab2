// Lecture 10.1.1 and 10.2: what its examples draw in space.

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <sstream>
#include <stdexcept>

#include "apps/document/chain_models.h"
#include "apps/lecture/slide_data.h"
#include "apps/render/lecture_drawing.h"
#include "apps/render/scene_view.h"
#include "kinematics/configuration.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr Colour red{0.83f, 0.24f, 0.20f, 1}, green{0.20f, 0.60f, 0.25f, 1}, blue{0.15f, 0.38f, 0.80f, 1};
constexpr Colour axisColours[] = {red, green, blue};

}  // namespace

// --- 10.2: Euler angles and quaternions

Vector3d RotationsDrawing::anglesOf(const Session& session, int joint) {
  const Eigen::Quaterniond q = ballRotation(session.skeleton(), session.q(), joint);
  const Eigen::Matrix3d R = q.normalized().toRotationMatrix();
  // At the lock the sliders' own angles describe the same rotation better than the convention c = 0.
  if ((rotationFromEuler(eulerOrder(), typed[joint]) - R).norm() < 1e-6) return typed[joint];
  return typed[joint] = eulerFromRotation(eulerOrder(), R);
}

void RotationsDrawing::draw(const LectureCanvas& canvas) {
  const Skeleton& skeleton = canvas.session.skeleton();
  if (joint >= skeleton.jointCount() || !skeleton.joint(joint).ball) return;  // another model
  const Vector3d angles = anglesOf(canvas.session, joint);
  const Frames& frames = canvas.session.frames();
  const Eigen::Matrix3d parent =
      joint == 0 ? Eigen::Matrix3d::Identity() : Eigen::Matrix3d(frames[joint - 1].linear());
  const Eigen::Matrix3d E = parent * eulerRates(eulerOrder(), angles);
  const Vector3d at = frames[joint].translation();
  const int axes[] = {eulerOrder().first, eulerOrder().second, eulerOrder().third};
  for (int k = 0; k < 3; ++k) {
    const double length = 0.75 - 0.1 * k;
    canvas.overlay.line(at - length * E.col(k), at + length * E.col(k), axisColours[axes[k]], 2.5f);
    canvas.labels.push_back(
        {at + 1.08 * length * E.col(k), fmt::format("{}: {}", k + 1, "xyz"[axes[k]]), axisColours[axes[k]]});
  }
  canvas.overlay.point(at, axisColours[axes[1]], 10.0f, Overlay::Shape::Ring);
}

std::string RotationsDrawing::save() const {
  std::string text = fmt::format("{} {}", joint, order);
  for (const Vector3d& angles : typed) text += fmt::format(" {} {} {}", angles.x(), angles.y(), angles.z());
  return text;
}
void RotationsDrawing::load(const Session&, const std::string& text) {
  std::istringstream words(text);
  int j;
  std::size_t o;
  if (!(words >> j >> o) || j < 0 || j > 2 || o >= eulerOrders().size()) return;
  joint = j, order = o;
  for (Vector3d& angles : typed)
    if (Vector3d a; words >> a.x() >> a.y() >> a.z()) angles = a;
}

// --- 10.2: Denavit-Hartenberg

void DhDrawing::draw(const LectureCanvas& canvas) {
  const VectorXd& q = canvas.session.q();
  if (q.size() != table.variableCount()) return;
  const Frames K = dhFrames(table, q);
  const double size = 0.09 * canvas.size;
  const LectureColours colours = lectureColours(canvas.session.document().theme);
  for (const AxisLine& axis : jointAxes(table, q))
    canvas.overlay.dashedLine(axis.point - 2.2 * size * axis.direction,
                              axis.point + 2.2 * size * axis.direction, 0.25 * size, withAlpha(blue, 0.8f),
                              2.0f);
  std::vector<std::pair<Vector3d, std::string>> names;
  for (std::size_t i = 0; i + 1 < K.size(); ++i) {
    const Vector3d origin = K[i].translation();
    if (frames) canvas.overlay.axes(K[i], size, 2.0f);
    const auto same = std::find_if(names.begin(), names.end(),
                                   [&](const auto& n) { return (n.first - origin).norm() < 1e-6; });
    if (same == names.end())
      names.emplace_back(origin, fmt::format("K{}", i + 1));
    else
      same->second += fmt::format(", {}", i + 1);
    if (i + 2 < K.size() && i < table.rows.size() &&
        std::abs(table.rows[i].a) > 1e-9) {  // the common normal of length a
      const bool modified = table.convention == DhConvention::Modified;
      const Vector3d x = K[modified ? i : i + 1].linear().col(0);
      const Vector3d from = modified ? origin : Vector3d(K[i + 1].translation() - table.rows[i].a * x);
      canvas.overlay.line(from, from + table.rows[i].a * x, colours.second, 3.0f);
    }
  }
  for (const auto& [at, text] : names)
    canvas.labels.push_back({at + 0.35 * size * Vector3d(1, -1, 1), text, colours.text});
}

std::string DhDrawing::save() const { return frames ? "1" : "0"; }
void DhDrawing::load(const Session& session, const std::string& text) {
  frames = text != "0";
  if (auto named = dhTableNamed(session.document().model.nameOrFile)) table = std::move(*named);
}

// --- 10.1.1: hierarchical animation of a leg

void LegDrawing::animate(const Skeleton& figure) {
  keyed = keyframedLegs(figure, lectureLegKeys());
  pinned = pinFeet(figure, keyed);
  keyedFeet = measureFeet(figure, keyed);
  pinnedFeet = measureFeet(figure, pinned);
}

int LegDrawing::frame() const {
  return std::clamp(static_cast<int>(time * keyed.framesPerSecond), 0, static_cast<int>(keyed.q.size()) - 1);
}

const Vector3d& LegDrawing::trail(const Skeleton& figure, int side, std::size_t f) {
  auto& points = trails_[pins ? 1 : 0][side];
  if (points.empty())
    for (const VectorXd& q : shown().q) points.push_back(solePoints(figure, q, side)[1]);
  return points[f];
}

void LegDrawing::draw(const LectureCanvas& canvas) {
  if (keyed.q.empty()) return;
  const LectureColours colours = lectureColours(canvas.session.document().theme);
  const Skeleton& figure = canvas.session.skeleton();
  const Colour ground = pins ? colours.truth : colours.linear;
  const auto now = static_cast<std::size_t>(frame());
  if (pins && ghost)
    canvas.ghosts.push_back({.worldFromJoint = forwardKinematics(figure, keyed.q[now]),
                             .tint = {0.85f, 0.35f, 0.25f},
                             .opacity = 0.45f});
  for (int side = 0; side < 2; ++side) {
    const bool standing = shown().onGround[now][side];
    for (const Vector3d& p : solePoints(figure, shown().q[now], side))
      canvas.overlay.point(p,
                           p.y() < -1e-6 ? colours.linear
                           : standing    ? colours.truth
                                         : colours.faint,
                           8.0f);
    // Where the ball of the foot stood until now: one spot, or a smear.
    for (std::size_t f = 0; f <= now; ++f) {
      if (!shown().onGround[f][side]) continue;
      const Vector3d& ball = trail(figure, side, f);
      if (f > 0 && shown().onGround[f - 1][side])
        canvas.overlay.line(trail(figure, side, f - 1), ball, ground, 4.0f);
      canvas.overlay.point({ball.x(), 0.0, ball.z()}, ground, 5.0f);
    }
  }
}

std::string LegDrawing::save() const { return fmt::format("{} {} {}", time, pins ? 1 : 0, ghost ? 1 : 0); }
void LegDrawing::load(const Session& session, const std::string& text) {
  if (keyed.q.empty()) animate(session.skeleton());
  std::istringstream words(text);
  double seconds;
  int withPins, withGhost = 1;
  if (!(words >> seconds >> withPins) || !(seconds >= 0.0) || seconds >= keyed.duration()) return;
  words >> withGhost;
  time = seconds, pins = withPins != 0, ghost = withGhost != 0;
}

std::unique_ptr<LectureDrawing> makeLectureDrawing(const std::string& topic) {
  if (topic == "planar-fk") return std::make_unique<ForwardDrawing>();
  if (topic == "two-link") return std::make_unique<TwoLinkDrawing>();
  if (topic == "newton-1d") return std::make_unique<OneDimensionDrawing>();
  if (topic == "newton-square") return std::make_unique<NewtonDrawing>(NewtonExample::Square);
  if (topic == "pseudo-inverse") return std::make_unique<NewtonDrawing>(NewtonExample::PseudoInverse);
  if (topic == "shortest") return std::make_unique<NewtonDrawing>(NewtonExample::Shortest);
  if (topic == "rotations") return std::make_unique<RotationsDrawing>();
  if (topic == "dh") return std::make_unique<DhDrawing>();
  if (topic == "leg") return std::make_unique<LegDrawing>();
  throw std::invalid_argument("the lecture has no drawing of '" + topic + "'");
}

}  // namespace gelenk
