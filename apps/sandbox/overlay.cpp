#include "apps/sandbox/overlay.h"

namespace gelenk {

void Overlay::line(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector4f& colour, float width,
                   bool dashed) {
  lines_.push_back({a, b, colour, width, dashed});
}
void Overlay::dot(const Eigen::Vector3d& at, const Eigen::Vector4f& colour, float radius, bool square) {
  dots_.push_back({at, colour, radius, square});
}
void Overlay::label(const Eigen::Vector3d& at, const std::string& text, const Eigen::Vector4f& colour) {
  labels_.push_back({at, colour, text});
}
void Overlay::patch(std::vector<Eigen::Vector3d> corners, const Eigen::Vector4f& colour) {
  patches_.push_back({std::move(corners), colour});
}
void Overlay::clear() {
  lines_.clear();
  dots_.clear();
  labels_.clear();
  patches_.clear();
}

}  // namespace gelenk
