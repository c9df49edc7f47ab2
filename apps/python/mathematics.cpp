#include <fmt/format.h>

#include "apps/document/chain_models.h"
#include "apps/lecture/example.h"
#include "apps/python/binding.h"
#include "kinematics/io/dh_text.h"
#include "kinematics/io/text_file.h"
#include "kinematics/notation/dh_table.h"
#include "kinematics/notation/euler.h"
#include "kinematics/notation/planar_chain.h"
#include "kinematics/notation/robots.h"
#include "kinematics/rotation.h"
#include "solvers/methods/two_link.h"

// The notations of the slides: planar chains, two links, rotations, Denavit-Hartenberg tables; the lecture's
// own numbers.

namespace gelenk::python {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;
using namespace py::literals;

// ---- planar chains

PlanarChain planarChain(py::handle lengths, py::handle base) {
  const VectorXd l = vectorOf(lengths, -1, "lengths");
  if (l.size() == 0 || !(l.minCoeff() >= 0.0))
    throw std::invalid_argument("lengths: one or more, none below 0");
  return {.base = base.is_none() ? Vector2d(0, 0) : pointInPlane(base, "base"),
          .lengths = {l.begin(), l.end()}};
}

/// "planar:X,Y:L1,L2,...", numbers exact.
std::string described(const PlanarChain& chain) {
  std::string text = "planar:" + exactNumber(chain.base.x()) + "," + exactNumber(chain.base.y()) + ":";
  for (std::size_t i = 0; i < chain.lengths.size(); ++i)
    text += (i ? "," : "") + exactNumber(chain.lengths[i]);
  return text;
}

VectorXd anglesOf(const PlanarChain& chain, py::handle phi) {
  return vectorOf(phi, chain.linkCount(), "phi");
}

py::array pointsOf(const PlanarChain& chain, py::handle phi) {
  const std::vector<Vector2d> points = linkPoints(chain, anglesOf(chain, phi));
  py::array_t<double> out({static_cast<py::ssize_t>(points.size()), py::ssize_t{2}});
  std::copy_n(points.data()->data(), 2 * points.size(), out.mutable_data());
  return out;
}

py::array planarFrames(const PlanarChain& chain, py::handle phi) {
  const auto frames = hierarchicalFrames(chain, anglesOf(chain, phi));
  py::array_t<double> out({static_cast<py::ssize_t>(frames.size()), py::ssize_t{3}, py::ssize_t{3}});
  double* to = out.mutable_data();
  for (const Eigen::Isometry2d& frame : frames) {
    Eigen::Matrix<double, 3, 3, Eigen::RowMajor>::Map(to) = frame.matrix();
    to += 9;
  }
  return out;
}

py::dict twoLink(double l1, double l2, py::handle target, py::handle base) {
  const TwoLinkSolution s = solveTwoLink(base.is_none() ? Vector2d(0, 0) : pointInPlane(base, "base"), l1, l2,
                                         pointInPlane(target, "target"));
  py::array_t<double> phi({static_cast<py::ssize_t>(s.count), py::ssize_t{2}});
  bool exact = true;
  for (int i = 0; i < s.count; ++i) {
    phi.mutable_at(i, 0) = s.branch[i].phi1;
    phi.mutable_at(i, 1) = s.branch[i].phi2;
    exact = exact && s.branch[i].exact;
  }
  return py::dict("phi"_a = phi, "exact"_a = exact, "case"_a = toString(s.kind), "gap"_a = s.gap);
}

py::array candidates(double l1, double l2, py::handle target, py::handle base) {
  const auto found = arctangentCandidates(base.is_none() ? Vector2d(0, 0) : pointInPlane(base, "base"), l1,
                                          l2, pointInPlane(target, "target"));
  py::array_t<double> out({py::ssize_t{4}, py::ssize_t{3}});
  for (int i = 0; i < 4; ++i) {
    out.mutable_at(i, 0) = found[i].phi1;
    out.mutable_at(i, 1) = found[i].phi2;
    out.mutable_at(i, 2) = found[i].distance;
  }
  return out;
}

// ---- Denavit-Hartenberg

DhConvention conventionOf(const std::string& word) {
  for (const DhConvention c : {DhConvention::Modified, DhConvention::Standard})
    if (word == toString(c)) return c;
  throw std::invalid_argument(fmt::format("a convention is {} or {}, not '{}'",
                                          toString(DhConvention::Modified), toString(DhConvention::Standard),
                                          word));
}

DhJoint jointKind(const std::string& word) {
  for (const DhJoint k : {DhJoint::Revolute, DhJoint::Prismatic, DhJoint::Fixed})
    if (word == toString(k)) return k;
  throw std::invalid_argument("a row is revolute, prismatic or fixed, not '" + word + "'");
}

DhRow dhRow(py::handle value) {
  DhRow row;
  if (py::isinstance<py::dict>(value)) {
    for (const auto& [key, entry] : py::reinterpret_borrow<py::dict>(value)) {
      const std::string name = py::str(key);
      if (name == "kind") {
        row.kind = jointKind(py::str(entry));
        continue;
      }
      double* const to = name == "a"       ? &row.a
                         : name == "alpha" ? &row.alpha
                         : name == "d"     ? &row.d
                         : name == "phi"   ? &row.phi
                         : name == "lower" ? &row.lower
                         : name == "upper" ? &row.upper
                                           : nullptr;
      if (!to)
        throw std::invalid_argument("a row has no entry '" + name +
                                    "'; there are: kind, a, alpha, d, phi, lower, upper");
      *to = entry.cast<double>();
    }
    return row;
  }
  const VectorXd v = vectorOf(value, 4, "a row a, alpha, d, phi");
  row.a = v[0], row.alpha = v[1], row.d = v[2], row.phi = v[3];
  return row;
}

DhTable dhTable(const py::iterable& rows, const std::string& convention, py::handle base, py::handle tool,
                const std::string& name) {
  DhTable table{.name = name, .convention = conventionOf(convention)};
  for (const py::handle& row : rows) table.rows.push_back(dhRow(row));
  if (!base.is_none()) table.base = pose(base, "base");
  if (!tool.is_none()) table.tool = pose(tool, "tool");
  validate(table);
  return table;
}

py::list rowsOf(const DhTable& table) {
  py::list rows;
  for (const DhRow& row : table.rows)
    rows.append(py::dict("kind"_a = toString(row.kind), "a"_a = row.a, "alpha"_a = row.alpha, "d"_a = row.d,
                         "phi"_a = row.phi, "lower"_a = row.lower, "upper"_a = row.upper));
  return rows;
}

DhTable dhOf(const SharedModel& model, py::handle end) {
  return dhFromSkeleton(model.skeleton(), end.is_none() ? -1 : jointOf(model.skeleton(), end, "end")).table;
}

// ---- rotations

EulerOrder orderOf(const std::string& name) {
  if (const auto order = findEulerOrder(name)) return *order;
  std::string names;
  for (const EulerOrder& order : eulerOrders())
    names += (names.empty() ? "" : ", ") + std::string(order.name);
  throw std::invalid_argument("no order of Euler angles is called '" + name + "'; there are: " + names);
}

py::array quaternionArray(const Eigen::Quaterniond& q) {
  const double wxyz[] = {q.w(), q.x(), q.y(), q.z()};
  return py::array_t<double>(4, wxyz);
}

// ---- the lecture

py::list lecture(const std::string& topic) {
  py::list checks;
  for (const LectureTopic& one : lectureTopics()) {
    if (!topic.empty() && &one != &findLectureTopic(topic)) continue;
    for (const LectureCheck& check : one.checks) {
      const LectureVerdict verdict = evaluate(check);
      checks.append(py::dict("topic"_a = one.id, "id"_a = check.id, "section"_a = check.section,
                             "what"_a = check.what, "printed"_a = check.printed,
                             "computed"_a = verdict.computed, "ok"_a = verdict.ok, "note"_a = check.note));
    }
  }
  return checks;
}

}  // namespace

void addMathematics(py::module_& m) {
  py::class_<PlanarChain>(
      m, "PlanarChain",
      "An unbranched chain in the plane (lecture 10.1): P_1 = base, link lengths l_i; phi_1 is\n"
      "measured from the x axis, every other angle from the link before. Radians.")
      .def(py::init(&planarChain), "lengths"_a, "base"_a = py::none())
      .def_static("lecture", &lecturePlanarChain, "P_1 = (50, 400), l = 150, 200, 100 (10.1.4).")
      .def_property_readonly(
          "lengths", [](const PlanarChain& c) { return c.lengths; }, "l_1 ... l_n.")
      .def_property_readonly(
          "base", [](const PlanarChain& c) { return toArray(VectorXd(c.base)); }, "(2,) P_1.")
      .def_property_readonly("degrees_of_freedom", &degreesOfFreedom, "n + 2: P_1 and n angles.")
      .def("points", &pointsOf, "phi"_a, "(n + 1, 2): P_1 ... P_{n+1}.")
      .def(
          "end_effector",
          [](const PlanarChain& c, py::handle phi) {
            return toArray(VectorXd(endEffector(c, anglesOf(c, phi))));
          },
          "phi"_a, "(2,): X = f(phi).")
      .def(
          "jacobian",
          [](const PlanarChain& c, py::handle phi) {
            return matrixArray(gelenk::jacobian(c, anglesOf(c, phi)));
          },
          "phi"_a, "(2, n): column i is X - P_i turned by +90 degrees (10.1.4).")
      .def("frames", &planarFrames, "phi"_a, "(n + 1, 3, 3): K_1 ... K_n and the frame at X (10.1.1).")
      .def(
          "model",
          [](const PlanarChain& c) {
            return std::make_shared<SharedModel>(planarModel(c), ModelReference{.nameOrFile = described(c)});
          },
          "The same chain as a Model in the x-y plane; q = phi.");
  m.def("two_link", &twoLink, "l1"_a, "l2"_a, "target"_a, "base"_a = py::none(),
        "All solutions of two links in the plane (lecture 10.1.3): a dict with phi (k, 2) in radians, k = 2\n"
        "inside the annulus, first the one with phi_2 >= 0; exact, case, gap (distance left).");
  m.def("two_link_candidates", &candidates, "l1"_a, "l2"_a, "target"_a, "base"_a = py::none(),
        "(4, 3): the slide's candidates phi_1, phi_2 and their distance from the target, 0 for those that "
        "hold.");

  py::class_<DhTable>(
      m, "DhTable",
      "An unbranched chain in Denavit-Hartenberg parameters (lecture 10.2), metres and radians.\n"
      "rows: dicts of kind, a, alpha, d, phi, lower, upper, or four numbers a, alpha, d, phi.\n"
      "'modified' (Craig; the lecture's): T = Rx(alpha) T(a, 0, d) Rz(phi); 'standard': Rz(phi)\n"
      "T(0, 0, d) T(a, 0, 0) Rx(alpha). base, tool: 4 x 4.")
      .def(py::init(&dhTable), "rows"_a, "convention"_a = "modified", "base"_a = py::none(),
           "tool"_a = py::none(), "name"_a = "")
      .def_static(
          "robot", [](const std::string& name) { return robotTable(name); }, "name"_a,
          "The table of a built-in robot.")
      .def_static(
          "parse", [](const std::string& text) { return parseDhTable(text, "text"); }, "text"_a,
          "A table as docs/formats/dh.md describes it.")
      .def_static("of", &dhOf, "model"_a, "end"_a = py::none(),
                  "A serial chain of a model by the common normals of its axes, modified convention.")
      .def_property_readonly(
          "name", [](const DhTable& t) { return t.name; }, "Of the robot.")
      .def_property_readonly(
          "convention", [](const DhTable& t) { return toString(t.convention); }, "modified or standard.")
      .def_property_readonly("rows", &rowsOf, "Dicts of kind, a, alpha, d, phi, lower, upper.")
      .def_property_readonly(
          "base", [](const DhTable& t) { return toArray(t.base); }, "(4, 4) before the first row.")
      .def_property_readonly(
          "tool", [](const DhTable& t) { return toArray(t.tool); }, "(4, 4) after the last row.")
      .def_property_readonly("variable_count", &DhTable::variableCount, "Rows that move: the length of q.")
      .def_property_readonly("parameter_count", &parameterCount, "4 n + 3.")
      .def(
          "frames",
          [](const DhTable& t, py::handle q) {
            return framesArray(dhFrames(t, vectorOf(q, t.variableCount(), "q")));
          },
          "q"_a, "(rows + 2, 4, 4): base, base T_1, ..., and last the tool.")
      .def(
          "transform",
          [](const DhTable& t, int row, double q) {
            if (row < 0 || row >= static_cast<int>(t.rows.size()))
              throw std::invalid_argument(
                  fmt::format("row: there are 0 to {}, not {}", t.rows.size() - 1, row));
            if (!std::isfinite(q)) throw std::invalid_argument("q must be a finite number");
            return toArray(dhTransform(t.rows[row], t.convention, q));
          },
          "row"_a, "q"_a, "(4, 4): T of one row at the value q of its variable.")
      .def(
          "to_convention",
          [](const DhTable& t, const std::string& c) { return toConvention(t, conventionOf(c)); },
          "convention"_a, "The same motion in the other convention.")
      .def("text", &formatDhTable, "As docs/formats/dh.md describes it; parse() gives the same values back.")
      .def(
          "model",
          [](const DhTable& t) {
            return std::make_shared<SharedModel>(dhModel(t), ModelReference{.nameOrFile = dhDescription(t)});
          },
          "The same robot as a Model.")
      .def("__repr__", [](const DhTable& t) {
        return fmt::format("<gelenk.DhTable '{}': {} rows, {}>", t.name, t.rows.size(),
                           toString(t.convention));
      });

  m.def(
      "rotation_from_euler",
      [](const std::string& order, py::handle angles) {
        return matrixArray(rotationFromEuler(orderOf(order), point(angles, "angles")));
      },
      "order"_a, "angles"_a, "(3, 3): R_first(a) R_second(b) R_third(c); order: 'xyz', 'zxz', ... Radians.");
  m.def(
      "euler_from_rotation",
      [](const std::string& order, py::handle R) {
        return toArray(eulerFromRotation(orderOf(order), rotationMatrix(R, "R")));
      },
      "order"_a, "R"_a, "(3,) angles; at gimbal lock the third is 0. R: (3, 3), or a quaternion w, x, y, z.");
  m.def(
      "exp", [](py::handle w) { return quaternionArray(expRotation(point(w, "w"))); }, "w"_a,
      "(4,) unit quaternion w, x, y, z of a rotation vector (axis times angle, radians).");
  m.def(
      "log", [](py::handle R) { return toArray(logRotation(rotation(R, "R"))); }, "R"_a,
      "(3,) rotation vector of a quaternion or a (3, 3) matrix.");
  m.def(
      "pose",
      [](py::handle position, py::handle orientation) {
        Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
        T.translation() = point(position, "position");
        if (!orientation.is_none()) T.linear() = rotationMatrix(orientation, "orientation");
        return toArray(T);
      },
      "position"_a, "orientation"_a = py::none(),
      "(4, 4) from a point and a quaternion w, x, y, z or a (3, 3) matrix.");
  m.def("lecture", &lecture, "topic"_a = "",
        "Every printed number of the lecture chapter beside its computation, as `gelenk lecture` shows them: "
        "a\n"
        "list of dicts with topic, id, section, what, printed, computed, ok, note.");
}

}  // namespace gelenk::python
