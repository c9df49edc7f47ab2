#include "solvers/problem/pole.h"

namespace gelenk {

using Eigen::Vector3d;

Vector3d PoleBend::line() const { return (c - a) / std::max((c - a).norm(), 1e-12); }

Vector3d PoleBend::side(const Vector3d& target) const {
  const Vector3d u = line(), s = target - a;
  return s - u * u.dot(s);
}

double PoleBend::distanceFromPlane(const Vector3d& target) const {
  const double width = side(target).norm();
  return width > 1e-12 ? line().dot((b - a).cross(target - a)) / width : 0.0;
}

Vector3d PoleBend::onSide(const Vector3d& target) const {
  const Vector3d u = line(), across = side(target), foot = a + u * u.dot(b - a);
  const double width = across.norm();
  if (!((c - a).norm() > 1e-9 && width > 1e-9)) return b;
  return foot + (b - foot).norm() / width * across;
}

Vector3d polePoint(const Skeleton& skeleton, const Frames& frames, int middle) {
  PoleBend bend{frames[skeleton.parent(middle)].translation(), frames[middle].translation(), {}};
  bend.c =
      skeleton.children(middle).empty() ? bend.b : frames[skeleton.children(middle).front()].translation();
  const double length = (bend.b - bend.a).norm() + (bend.c - bend.b).norm();
  Vector3d side = (bend.c - bend.a).norm() > 0.0 ? bend.side(bend.b) : Vector3d(bend.b - bend.a);
  if (side.norm() < 1e-6 * length) side = frames[middle].linear().col(1);
  return bend.b + 0.5 * length * side.normalized();
}

}  // namespace gelenk
