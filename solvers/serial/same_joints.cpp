#include "solvers/serial/same_joints.h"

namespace gelenk {
namespace {

bool sameDof(const AxisDof& a, const AxisDof& b) {
  return a.kind == b.kind && a.axis == b.axis && a.lower == b.lower && a.upper == b.upper;
}

}  // namespace

bool sameJoints(const std::vector<Joint>& a, const std::vector<Joint>& b) {
  if (a.size() != b.size()) return false;
  for (size_t j = 0; j < a.size(); ++j) {
    if (a[j].parent != b[j].parent || a[j].ball != b[j].ball || a[j].axes.size() != b[j].axes.size() ||
        a[j].parentFromZero.matrix() != b[j].parentFromZero.matrix() || a[j].coupling != b[j].coupling)
      return false;
    for (size_t k = 0; k < a[j].axes.size(); ++k)
      if (!sameDof(a[j].axes[k], b[j].axes[k])) return false;
  }
  return true;
}

}  // namespace gelenk
