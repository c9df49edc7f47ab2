#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <system_error>

#include "apps/commands/solve_batch.h"
#include "apps/document/chain_models.h"
#include "apps/document/described_model.h"
#include "apps/document/model_files.h"
#include "apps/document/scene_file.h"
#include "apps/document/session.h"
#include "apps/python/goal_value.h"
#include "kinematics/configuration.h"
#include "kinematics/io/text_file.h"
#include "kinematics/jacobian.h"
#include "kinematics/motion/motion_clip.h"
#include "kinematics/symmetry.h"

// Models and their mathematics: opening, forward kinematics, Jacobians, steps on the manifold.

namespace gelenk::python {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using namespace py::literals;

ModelPtr builtIn(const std::string& name) {
  const std::vector<std::string> names = builtInModels();
  const bool described = name.starts_with("planar:") || name.starts_with("balls:") || name.starts_with("dh:");
  if (!described && std::find(names.begin(), names.end(), name) == names.end())
    throw std::invalid_argument(
        fmt::format("no model is called '{}'; there are: {}. Files are opened by gelenk.load", name,
                    listed(names, static_cast<int>(names.size()))));
  return std::make_shared<SharedModel>(openModel(name), ModelReference{.nameOrFile = name});
}

ModelPtr load(const py::object& path, const py::object& skeleton, const py::object& weights,
              const py::object& asf, const py::object& amc, const py::object& mapping,
              const py::object& figure, const py::object& clip, const py::object& unit,
              std::optional<double> fps, std::optional<double> sampleAt, const py::object& up, bool zUp,
              bool body) {
  const auto text = [](const py::object& value) {
    return value.is_none() ? std::string()
                           : std::string(py::str(py::module_::import("os").attr("fspath")(value)));
  };
  ModelReference reference{.nameOrFile = text(path)};
  reference.files = {.skeleton = text(skeleton),
                     .weights = text(weights),
                     .asf = text(asf),
                     .amc = text(amc),
                     .mapping = text(mapping),
                     .figure = text(figure),
                     .clip = text(clip),
                     .up = up.is_none() ? std::string() : std::string(py::str(up))};
  ImportOptions options{.framesPerSecond = fps, .sampleAt = sampleAt, .zUp = zUp};
  if (py::isinstance<py::str>(unit))
    options.metresPerUnit = metresPerUnit(unit.cast<std::string>());
  else if (!unit.is_none())
    options.metresPerUnit = vectorOf(py::make_tuple(unit), 1, "unit")[0];
  if (options.metresPerUnit && !(*options.metresPerUnit > 0.0))
    throw std::invalid_argument("unit: metres a unit must be above 0");
  if (fps && !(*fps > 0.0 && *fps < 1e6)) throw std::invalid_argument("fps must be above 0");
  if (sampleAt && !(*sampleAt > 0.0 && *sampleAt < 1e6))
    throw std::invalid_argument("sample_at must be above 0");
  py::gil_scoped_release alone;
  if (isScene(reference.nameOrFile)) {
    Opened opened = openDocument(reference, Body::AsItComes);
    VectorXd pose = opened.document.edits.q;
    std::vector<Goal> goals = Session(opened.model, opened.document).problem().goals;
    return std::make_shared<SharedModel>(opened.model, std::move(pose), std::move(goals), reference);
  }
  if (std::error_code error; !std::filesystem::exists(reference.nameOrFile, error))
    throw std::system_error(ENOENT, std::generic_category(),
                            "'" + reference.nameOrFile + "' (built-in models are opened by gelenk.model)");
  Model model = importFiles(reference.nameOrFile, reference.files, options).model;
  // What files do not say no other process can be told by their names alone.
  const bool asFilesSay = !options.metresPerUnit && !fps && !sampleAt && !zUp;
  return std::make_shared<SharedModel>(body ? withBody(std::move(model)) : std::move(model),
                                       asFilesSay ? std::optional(reference) : std::nullopt);
}

py::array fk(const SharedModel& model, py::handle value) {
  const Skeleton& skeleton = model.skeleton();
  if (const Array array = numbers(value, "q"); array.ndim() == 1)
    return framesArray(forwardKinematics(skeleton, configuration(skeleton, array)));
  const Configurations all = configurations(skeleton, value);
  const py::ssize_t n = all.q.cols(), joints = skeleton.jointCount();
  py::array_t<double> out({n, joints, py::ssize_t{4}, py::ssize_t{4}});
  double* to = out.mutable_data();
  py::gil_scoped_release alone;
  Frames frames;
  VectorXd q;
  for (py::ssize_t i = 0; i < n; ++i) {
    q = all.q.col(i);
    forwardKinematics(skeleton, q, frames);
    for (const Eigen::Isometry3d& frame : frames) {
      Eigen::Matrix<double, 4, 4, Eigen::RowMajor>::Map(to) = frame.matrix();
      to += 16;
    }
  }
  return out;
}

/// f of one configuration, or of every row: (size,) or (n, size).
template <typename Function>
py::array ofEach(const SharedModel& model, py::handle q, Eigen::Index size, const Function& f) {
  const Configurations all = configurations(model.skeleton(), q);
  MatrixXd out(size, all.q.cols());
  {
    const py::gil_scoped_release alone;
    for (Eigen::Index i = 0; i < out.cols(); ++i) out.col(i) = f(VectorXd(all.q.col(i)));
  }
  return all.single ? toArray(VectorXd(out.col(0))) : samples(std::move(out));
}

py::object violation(const SharedModel& model, py::handle q) {
  const py::array all = ofEach(model, q, 1, [&](const VectorXd& one) {
    return Eigen::Matrix<double, 1, 1>(limitViolation(model.skeleton(), one));
  });
  return all.ndim() == 1 ? py::object(all[py::int_(0)]) : all.attr("ravel")();
}

/// from, to and s: one, or as many of each.
py::array interpolated(const SharedModel& model, py::handle from, py::handle to, py::handle s) {
  const Skeleton& skeleton = model.skeleton();
  const Configurations a = configurations(skeleton, from, "from_"), b = configurations(skeleton, to, "to");
  const bool oneTime = numbers(s, "s").ndim() == 0;
  const VectorXd t = oneTime ? vectorOf(py::make_tuple(s), 1, "s") : vectorOf(s, -1, "s");
  std::set<Eigen::Index> counts;
  if (!a.single) counts.insert(a.q.cols());
  if (!b.single) counts.insert(b.q.cols());
  if (!oneTime) counts.insert(t.size());
  if (counts.size() > 1)
    throw std::invalid_argument(
        fmt::format("from_, to and s: {}, {} and {} of them", a.q.cols(), b.q.cols(), t.size()));
  MatrixXd out(skeleton.nq(), counts.empty() ? 1 : *counts.begin());
  VectorXd q;
  for (Eigen::Index i = 0; i < out.cols(); ++i) {
    interpolate(skeleton, VectorXd(a.q.col(a.single ? 0 : i)), VectorXd(b.q.col(b.single ? 0 : i)),
                t[oneTime ? 0 : i], q);
    out.col(i) = q;
  }
  return counts.empty() ? toArray(VectorXd(out.col(0))) : samples(std::move(out));
}

py::array centreOfMassOf(const SharedModel& model, py::handle q) {
  if (!model.model().masses) throw std::invalid_argument("'" + model.model().name + "' has no masses");
  return ofEach(model, q, 3, [&](const VectorXd& one) {
    return centreOfMass(*model.model().masses, forwardKinematics(model.skeleton(), one));
  });
}

/// 6 x nv: linear rows first.
void jacobianInto(const Skeleton& skeleton, const VectorXd& q, int joint, const Vector3d& inJoint,
                  double* rowMajor) {
  const Frames frames = forwardKinematics(skeleton, q);
  const Twists twists = dofTwists(skeleton, q, frames);
  MatrixXd J(6, skeleton.nv());
  pointJacobian(skeleton, twists, joint, frames[joint] * inJoint, J.topRows<3>());
  rotationJacobian(skeleton, twists, joint, J.bottomRows<3>());
  Eigen::Map<Eigen::Matrix<double, -1, -1, Eigen::RowMajor>>(rowMajor, 6, skeleton.nv()) = J;
}

py::array jacobian(const SharedModel& model, py::handle value, py::handle joint, py::handle pointInJoint) {
  const Skeleton& skeleton = model.skeleton();
  const int j = effector(model, joint);
  const Vector3d inJoint = pointInJoint.is_none() ? Vector3d(0, 0, 0) : point(pointInJoint, "point");
  const Configurations all = configurations(skeleton, value);
  const py::ssize_t n = all.q.cols(), nv = skeleton.nv();
  py::array_t<double> out(all.single ? std::vector<py::ssize_t>{6, nv} : std::vector<py::ssize_t>{n, 6, nv});
  double* to = out.mutable_data();
  py::gil_scoped_release alone;
  for (py::ssize_t i = 0; i < n; ++i) jacobianInto(skeleton, all.q.col(i), j, inJoint, to + 6 * nv * i);
  return out;
}

py::array integrated(const SharedModel& model, py::handle q, py::handle dq) {
  const Skeleton& skeleton = model.skeleton();
  const Configurations all = configurations(skeleton, q);
  if (all.single)
    return toArray(integrate(skeleton, VectorXd(all.q.col(0)), vectorOf(dq, skeleton.nv(), "dq")));
  const Array steps = numbers(dq, "dq");
  if (steps.ndim() != 2 || steps.shape(0) != all.q.cols() || steps.shape(1) != skeleton.nv())
    throw std::invalid_argument(
        fmt::format("dq: expected an array of shape ({}, {})", all.q.cols(), skeleton.nv()));
  const auto D = MatrixXd::Map(steps.data(), skeleton.nv(), all.q.cols());
  if (!D.allFinite()) throw std::invalid_argument("dq must be finite numbers");
  MatrixXd out(skeleton.nq(), all.q.cols());
  for (Eigen::Index i = 0; i < out.cols(); ++i)
    out.col(i) = integrate(skeleton, VectorXd(all.q.col(i)), VectorXd(D.col(i)));
  return samples(std::move(out));
}

py::array differenceOf(const SharedModel& model, py::handle from, py::handle to) {
  const Skeleton& skeleton = model.skeleton();
  const Configurations a = configurations(skeleton, from, "from_"), b = configurations(skeleton, to, "to");
  if (a.q.cols() != b.q.cols() || a.single != b.single)
    throw std::invalid_argument(
        fmt::format("from_ and to: {} and {} configurations", a.q.cols(), b.q.cols()));
  if (a.single) return toArray(difference(skeleton, VectorXd(a.q.col(0)), VectorXd(b.q.col(0))));
  MatrixXd out(skeleton.nv(), a.q.cols());
  for (Eigen::Index i = 0; i < out.cols(); ++i)
    out.col(i) = difference(skeleton, VectorXd(a.q.col(i)), VectorXd(b.q.col(i)));
  return samples(std::move(out));
}

py::array randomPose(const SharedModel& model, py::handle rng, std::optional<int> count) {
  if (count && (*count < 0 || *count > 100'000'000))
    throw std::invalid_argument(fmt::format("count: expected 0 or more, found {}", *count));
  std::mt19937_64 random(seedOf(rng));
  if (!count) return toArray(randomWithinLimits(model.skeleton(), random));
  MatrixXd out(model.skeleton().nq(), *count);
  for (int i = 0; i < *count; ++i) out.col(i) = randomWithinLimits(model.skeleton(), random);
  return samples(std::move(out));
}

/// (nq, 2): lower and upper end of every coordinate.
py::array limits(const SharedModel& model) {
  const Skeleton& skeleton = model.skeleton();
  MatrixXd out(skeleton.nq(), 2);
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    int row = skeleton.qIndex(i);
    for (const AxisDof& dof : skeleton.joint(i).axes) out.row(row++) << dof.lower, dof.upper;
    for (int k = 0; skeleton.joint(i).ball && k < 4; ++k) out.row(row++) << -1.0, 1.0;
  }
  return matrixArray(out);
}

py::dict ballLimitDict(const BallLimit& limit) {
  return py::dict("swing_centre"_a = toArray(VectorXd(limit.swingCentre)),
                  "swing_radii"_a = toArray(VectorXd(limit.swingRadii)),
                  "twist"_a = py::make_tuple(limit.twistLower, limit.twistUpper));
}

py::dict ballLimits(const SharedModel& model) {
  py::dict out;
  for (const Joint& joint : model.skeleton().joints())
    if (joint.ball && joint.ballLimit) out[py::str(joint.name)] = ballLimitDict(*joint.ballLimit);
  return out;
}

// ---- models from joints

py::dict jointDict(const Skeleton& skeleton, int i) {
  const Joint& joint = skeleton.joint(i);
  py::list axes;
  for (const AxisDof& dof : joint.axes)
    axes.append(py::dict("kind"_a = dof.kind == AxisDof::Kind::Rotation ? "rotation" : "translation",
                         "axis"_a = toArray(dof.axis), "lower"_a = dof.lower, "upper"_a = dof.upper));
  py::dict out("name"_a = joint.name,
               "parent"_a = joint.parent < 0 ? py::object(py::none())
                                             : py::object(py::str(skeleton.joint(joint.parent).name)),
               "offset"_a = toArray(joint.parentFromZero), "axes"_a = axes, "ball"_a = joint.ball);
  if (joint.ballLimit) out["ball_limit"] = ballLimitDict(*joint.ballLimit);
  if (const auto& follows = joint.coupling)
    out["mimic"] = py::dict("joint"_a = skeleton.joint(follows->source).name,
                            "multiplier"_a = follows->multiplier, "offset"_a = follows->offset);
  return out;
}

void knownKeys(const py::dict& dict, std::initializer_list<std::string_view> known, const char* what) {
  for (const auto& [key, value] : dict) {
    const std::string name = py::str(key);
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw std::invalid_argument(
          fmt::format("{}: unknown entry '{}'; there are: {}", what, name,
                      listed(std::vector<std::string>(known.begin(), known.end()), 20)));
  }
}

double finite(const py::handle& value, const char* what) {
  return vectorOf(py::make_tuple(value), 1, what)[0];
}

/// An end of a range: a number, which may be infinite.
double bound(const py::handle& value, const char* what) {
  const Array number = numbers(py::make_tuple(value), what);
  if (number.ndim() != 1 || std::isnan(number.at(0)))
    throw std::invalid_argument(fmt::format("{}: expected a number", what));
  return number.at(0);
}

py::dict dictOf(const py::handle& value, const char* what, const char* entries) {
  if (!py::isinstance<py::dict>(value))
    throw std::invalid_argument(fmt::format("{}: expected a dict of {}", what, entries));
  return py::reinterpret_borrow<py::dict>(value);
}

BallLimit ballLimitFrom(const py::handle& value) {
  const py::dict dict = dictOf(value, "ball_limit", "swing_centre, swing_radii, twist");
  knownKeys(dict, {"swing_centre", "swing_radii", "twist"}, "a ball_limit");
  BallLimit limit;
  if (dict.contains("swing_centre")) limit.swingCentre = pointInPlane(dict["swing_centre"], "swing_centre");
  if (dict.contains("swing_radii")) limit.swingRadii = pointInPlane(dict["swing_radii"], "swing_radii");
  if (dict.contains("twist")) {
    const Array twist = numbers(dict["twist"], "twist");
    if (twist.ndim() != 1 || twist.shape(0) != 2)
      throw std::invalid_argument("twist: expected two numbers, lower and upper");
    limit.twistLower = twist.at(0);
    limit.twistUpper = twist.at(1);
  }
  return limit;
}

/// What one dict says but for the joint that it follows, whose place is not known yet.
Joint jointFrom(const py::dict& dict, const std::map<std::string, int>& indices) {
  knownKeys(dict, {"name", "parent", "offset", "axes", "ball", "ball_limit", "mimic"}, "a joint");
  if (!dict.contains("name")) throw std::invalid_argument("a joint needs a name");
  Joint joint{.name = py::str(dict["name"])};
  if (dict.contains("parent") && !dict["parent"].is_none()) {
    const std::string parent = py::str(dict["parent"]);
    const auto found = indices.find(parent);
    if (found == indices.end())
      throw std::invalid_argument("joint '" + joint.name + "': its parent '" + parent +
                                  "' does not come before it");
    joint.parent = found->second;
  }
  if (dict.contains("offset")) {
    const Array offset = numbers(dict["offset"], "offset");
    if (offset.ndim() == 1 && offset.shape(0) == 3)
      joint.parentFromZero.translation() = point(offset, "offset");
    else
      joint.parentFromZero = pose(offset, "offset");
  }
  if (dict.contains("axes"))
    for (const py::handle& one : dict["axes"]) {
      if (!py::isinstance<py::dict>(one))
        throw std::invalid_argument("axes: a list of dicts with kind, axis, lower, upper");
      const py::dict row = py::reinterpret_borrow<py::dict>(one);
      knownKeys(row, {"kind", "axis", "lower", "upper"}, "an axis");
      AxisDof dof;
      const std::string kind = row.contains("kind") ? std::string(py::str(row["kind"])) : "rotation";
      if (kind != "rotation" && kind != "translation")
        throw std::invalid_argument("an axis is a rotation or a translation, not '" + kind + "'");
      dof.kind = kind == "rotation" ? AxisDof::Kind::Rotation : AxisDof::Kind::Translation;
      if (row.contains("axis")) dof.axis = direction(row["axis"], "axis");
      if (row.contains("lower")) dof.lower = bound(row["lower"], "lower");
      if (row.contains("upper")) dof.upper = bound(row["upper"], "upper");
      joint.axes.push_back(dof);
    }
  if (dict.contains("ball")) joint.ball = dict["ball"].cast<bool>();
  if (dict.contains("ball_limit") && !dict["ball_limit"].is_none()) {
    if (!joint.ball) throw std::invalid_argument("joint '" + joint.name + "': a ball_limit without a ball");
    joint.ballLimit = ballLimitFrom(dict["ball_limit"]);
  }
  return joint;
}

Coupling couplingFrom(const py::handle& value, const std::string& follower,
                      const std::map<std::string, int>& indices) {
  const py::dict dict = dictOf(value, "mimic", "joint, multiplier, offset");
  knownKeys(dict, {"joint", "multiplier", "offset"}, "a mimic");
  const std::string source = dict.contains("joint") ? std::string(py::str(dict["joint"])) : "";
  const auto found = indices.find(source);
  if (found == indices.end())
    throw std::invalid_argument("joint '" + follower + "': it mimics '" + source + "', which is no joint");
  Coupling coupling{.source = found->second};
  if (dict.contains("multiplier")) coupling.multiplier = finite(dict["multiplier"], "multiplier");
  if (dict.contains("offset")) coupling.offset = finite(dict["offset"], "offset");
  return coupling;
}

ModelPtr fromJoints(const py::list& rows, const std::string& name, const py::object& rest) {
  std::vector<Joint> joints;
  std::map<std::string, int> indices;
  for (const py::handle& row : rows) {
    if (!py::isinstance<py::dict>(row)) throw std::invalid_argument("joints: expected a list of dicts");
    joints.push_back(jointFrom(py::reinterpret_borrow<py::dict>(row), indices));
    indices[joints.back().name] = static_cast<int>(joints.size()) - 1;
  }
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const py::dict row = py::reinterpret_borrow<py::dict>(rows[i]);
    if (row.contains("mimic") && !row["mimic"].is_none())
      joints[i].coupling = couplingFrom(row["mimic"], joints[i].name, indices);
  }
  Model model{.name = name, .skeleton = Skeleton(joints)};
  if (!rest.is_none()) model.skeleton = Skeleton(joints, configuration(model.skeleton, rest, "rest"));
  return std::make_shared<SharedModel>(std::move(model));
}

std::vector<std::string> namesOf(const Skeleton& skeleton) {
  std::vector<std::string> names;
  for (const Joint& joint : skeleton.joints()) names.push_back(joint.name);
  return names;
}

}  // namespace

py::list noteList(const std::vector<Note>& notes) {
  py::list out;
  for (const Note& note : notes) out.append(py::make_tuple(note.kind, note.lineWithoutRemedy()));
  return out;
}

std::string sceneText(const SharedModel& model) {
  if (model.reference() && isScene(model.reference()->nameOrFile))
    return readFile(model.reference()->nameOrFile);
  const ModelReference reference =
      model.reference().value_or(ModelReference{.nameOrFile = jointsDescription(model.model())});
  const Model shown = withBody(model.model());
  Document document = newDocument(shown, reference);
  document.view.camera.distance = 0.0;  // the whole is shown
  return formatScene(document, shown);
}

int effector(const SharedModel& model, py::handle joint) {
  if (!joint.is_none()) return jointOf(model.skeleton(), joint);
  std::vector<std::string> ends;
  int last = 0;
  for (int i = 0; i < model.skeleton().jointCount(); ++i)
    if (model.skeleton().children(i).empty()) ends.push_back(model.skeleton().joint(last = i).name);
  if (ends.size() == 1) return last;
  throw std::invalid_argument(
      fmt::format("'{}' has several ends; choose one with joint=: {}", model.model().name, listed(ends, 40)));
}

void addModel(py::module_& m) {
  py::class_<SharedModel, ModelPtr>(
      m, "Model",
      "An articulated model: joints, rest pose, perhaps a skin and a motion. Constant: threads may share "
      "it.\n\n"
      "q: (nq,) one value an axis (radians, metres) joint by joint, then for a ball a unit quaternion w, x,\n"
      "y, z. dq: (nv,) the tangent: one value an axis, three for a ball (a rotation vector in its own "
      "frame).\n"
      "Where a q is taken, (n, nq) gives n answers at once.")
      .def_static(
          "from_joints", &fromJoints, "joints"_a, py::kw_only(), "name"_a = "model", "rest"_a = py::none(),
          "A model from dicts, parents first: name, parent (a name), offset (x, y, z or a 4 x 4 pose in\n"
          "the parent), axes (dicts of kind 'rotation' or 'translation', axis, lower, upper), ball,\n"
          "ball_limit (a dict as in ball_limits), mimic (a dict of joint, multiplier, offset).")
      .def_property_readonly(
          "name", [](const SharedModel& m) { return m.model().name; }, "Of the model or its file.")
      .def_property_readonly(
          "nq", [](const SharedModel& m) { return m.skeleton().nq(); }, "Length of a configuration.")
      .def_property_readonly(
          "nv", [](const SharedModel& m) { return m.skeleton().nv(); },
          "Length of a tangent: the degrees of freedom.")
      .def_property_readonly(
          "joint_names", [](const SharedModel& m) { return namesOf(m.skeleton()); },
          "In the order of their indices.")
      .def_property_readonly(
          "joint_count", [](const SharedModel& m) { return m.skeleton().jointCount(); },
          "How many joints, fixed ones among them.")
      .def_property_readonly(
          "parents",
          [](const SharedModel& m) {
            std::vector<int> parents;
            for (const Joint& joint : m.skeleton().joints()) parents.push_back(joint.parent);
            return parents;
          },
          "Index of every joint's parent, -1 for the root.")
      .def_property_readonly(
          "ends",
          [](const SharedModel& m) {
            std::vector<std::string> ends;
            for (int i = 0; i < m.skeleton().jointCount(); ++i)
              if (m.skeleton().children(i).empty()) ends.push_back(m.skeleton().joint(i).name);
            return ends;
          },
          "Names of the joints without children.")
      .def_property_readonly(
          "handles", [](const SharedModel& m) { return m.model().handles; },
          "Joints by which the model is dragged; empty: its ends.")
      .def(
          "index", [](const SharedModel& m, py::handle joint) { return jointOf(m.skeleton(), joint); },
          "joint"_a, "Index of a joint. Raises ValueError that lists the names.")
      .def(
          "joint",
          [](const SharedModel& m, py::handle joint) {
            return jointDict(m.skeleton(), jointOf(m.skeleton(), joint));
          },
          "joint"_a, "The joint as a dict that Model.from_joints takes.")
      .def(
          "q_slice",
          [](const SharedModel& m, py::handle joint) {
            const int i = jointOf(m.skeleton(), joint), first = m.skeleton().qIndex(i);
            return py::slice(first, first + m.skeleton().qCount(i), 1);
          },
          "joint"_a, "Where the joint's values stand in q.")
      .def(
          "v_slice",
          [](const SharedModel& m, py::handle joint) {
            const int i = jointOf(m.skeleton(), joint), first = m.skeleton().vIndex(i);
            return py::slice(first, first + m.skeleton().vCount(i), 1);
          },
          "joint"_a, "Where the joint's values stand in dq.")
      .def_property_readonly(
          "coordinate_names", [](const SharedModel& m) { return coordinateNames(m.skeleton()); },
          "One a value of q: 'shoulder', or 'hip.1', 'shoulder.qw' where a joint has several.")
      .def_property_readonly(
          "rest", [](const SharedModel& m) { return toArray(m.skeleton().rest()); },
          "(nq,) the rest pose; a copy.")
      .def_property_readonly(
          "pose", [](const SharedModel& m) { return toArray(m.pose()); },
          "(nq,) the pose that a scene was saved in; else the rest pose.")
      .def_property_readonly(
          "neutral", [](const SharedModel& m) { return toArray(neutral(m.skeleton())); },
          "(nq,) zeros and identities.")
      .def_property_readonly(
          "limits", &limits,
          "(nq, 2) lower and upper ends, radians and metres; -inf and inf: none; -1 and 1 for\n"
          "the parts of a quaternion, whose limits are ball_limits.")
      .def_property_readonly(
          "ball_limits", &ballLimits,
          "Of balls by name: swing_centre, swing_radii and twist in swing-twist coordinates.")
      .def_property_readonly(
          "up", [](const SharedModel& m) { return toArray(m.model().up); }, "(3,) against gravity.")
      .def_property_readonly(
          "notes", [](const SharedModel& m) { return noteList(m.model().notes); },
          "(kind, sentence) of all that the reader wants known.")
      .def("fk", &fk, "q"_a,
           "Forward kinematics: worldFromJoint of every joint, (joints, 4, 4), metres. (n, nq) gives\n"
           "(n, joints, 4, 4). One pose comes without a copy, with strides (128, 8, 32).")
      .def(
          "jacobian", &jacobian, "q"_a, "joint"_a = py::none(), "point"_a = py::none(),
          "(6, nv), world axes: rows 0-2 the velocity of the point (metres, frame of the joint; default its\n"
          "origin), rows 3-5 the angular velocity. joint: name or index; default: the model's only end.")
      .def("integrate", &integrated, "q"_a, "dq"_a, "q (+) dq, (nq,): balls take q * exp(dq). No limits.")
      .def("difference", &differenceOf, "from_"_a, "to"_a,
           "(nv,) the tangent with integrate(from_, difference(from_, to)) == to.")
      .def("random", &randomPose, "rng"_a = py::none(), "count"_a = py::none(),
           "(nq,) uniform within limits; with count (count, nq). rng: a seed, a numpy Generator, or None.")
      .def(
          "project",
          [](const SharedModel& m, py::handle q) {
            return ofEach(m, q, m.skeleton().nq(),
                          [&](const VectorXd& one) { return projectToLimits(m.skeleton(), one); });
          },
          "q"_a, "(nq,) the nearest configuration within limits, joint by joint.")
      .def("violation", &violation, "q"_a,
           "How far the worst joint lies outside its limits, radians or metres; 0 within.")
      .def(
          "mirror",
          [](const SharedModel& m, py::handle q) {
            return ofEach(m, q, m.skeleton().nq(),
                          [&](const VectorXd& one) { return mirrorPose(m.skeleton(), one); });
          },
          "q"_a, "(nq,) left and right exchanged. Raises ValueError where the model is not symmetric.")
      .def("interpolate", &interpolated, "from_"_a, "to"_a, "s"_a,
           "(nq,) rotations of whole joints along the shorter arc; s from 0 to 1. Many of from_, to or s "
           "give\n"
           "(n, nq).")
      .def(
          "coupled",
          [](const SharedModel& m, py::handle q) {
            return ofEach(m, q, m.skeleton().nq(), [&](VectorXd one) {
              m.skeleton().couple(one);
              return one;
            });
          },
          "q"_a, "(nq,) with what a URDF's mimic joints follow put in, as `gelenk fk` does.")
      .def_property_readonly(
          "mass",
          [](const SharedModel& m) -> py::object {
            return m.model().masses ? py::object(py::float_(m.model().masses->total())) : py::none();
          },
          "kg, None where the masses are unknown.")
      .def("centre_of_mass", &centreOfMassOf, "q"_a, "(3,) metres, world.")
      .def_property_readonly("_scene", &sceneText, "Text of the scene that opens this model elsewhere.")
      .def("__repr__", [](const SharedModel& m) {
        return fmt::format("<gelenk.Model '{}': {} joints, nq {}, nv {}{}{}>", m.model().name,
                           m.skeleton().jointCount(), m.skeleton().nq(), m.skeleton().nv(),
                           m.model().skin ? ", skin" : "", m.model().clip ? ", motion" : "");
      });

  m.def("models", &builtInModels, "Names of the built-in models.");
  m.def("model", &builtIn, "name"_a,
        "A built-in model: a name of models(), 'planar:X,Y:L1,L2,...' or 'balls:L1,L2,...'.");
  m.def(
      "load", &load, "path"_a, py::kw_only(), "skeleton"_a = py::none(), "weights"_a = py::none(),
      "asf"_a = py::none(), "amc"_a = py::none(), "mapping"_a = py::none(), "figure"_a = py::none(),
      "clip"_a = py::none(), "unit"_a = py::none(), "fps"_a = py::none(), "sample_at"_a = py::none(),
      "up"_a = py::none(), "z_up"_a = false, "body"_a = false,
      "The model that a file holds, told by its extension: .urdf, .dh, .skel, .asf, .amc (with asf=), .bvh,\n"
      ".gltf, .glb, .obj (with skeleton=), .nurbs, .figure, .pose (with figure=), or a scene (.json).\n"
      "unit: metres a unit, or 'cm', 'in', ...; fps: of an AMC; sample_at: Hz, of motions of splines;\n"
      "up: 'y' or 'z' where the format does not say which axis points up; z_up: the file has z up and is "
      "turned\n"
      "to y up; body: makes a rounded body around bones without a skin.\n"
      "Raises ParseError (file, line, expected, found) and ValueError.");
}

}  // namespace gelenk::python
