#include "solvers/problem/ik_report.h"

namespace gelenk {

const char* toString(Stop stop) {
  switch (stop) {
    case Stop::Converged: return "converged";
    case Stop::Stationary: return "stationary";
    case Stop::Saddle: return "saddle";
    case Stop::Stalled: return "stalled";
    case Stop::Budget: return "budget";
    case Stop::Failure: return "failure";
    case Stop::Unsupported: return "unsupported";
  }
  return "unknown";
}

}  // namespace gelenk
