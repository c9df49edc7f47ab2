#include "apps/python/binding.h"

#include <fmt/format.h>

#include <cmath>

#include "apps/commands/solve_batch.h"
#include "apps/document/configuration_input.h"
#include "kinematics/configuration.h"
#include "solvers/own_solver.h"

namespace gelenk::python {

using Eigen::Isometry3d;
using Eigen::MatrixXd;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

SharedModel::SharedModel(Model model, std::optional<ModelReference> reference)
    : model_(std::make_shared<const Model>(std::move(model))),
      pose_(model_->skeleton.rest()),
      reference_(std::move(reference)) {}

SharedModel::SharedModel(std::shared_ptr<const Model> model, VectorXd pose, std::vector<Goal> goals,
                         ModelReference reference)
    : model_(std::move(model)),
      pose_(std::move(pose)),
      goals_(std::move(goals)),
      reference_(std::move(reference)) {}

std::shared_ptr<const IkSolver> SharedModel::solver(const std::string& text) const {
  const std::lock_guard lock(mutex_);
  if (const int changes = solverChanges(); changes != changes_) {
    solvers_.clear();
    changes_ = changes;
  }
  if (const auto found = solvers_.find(text); found != solvers_.end()) return found->second;
  std::shared_ptr<IkSolver> solver = makeSolver(text);
  solver->prepare(skeleton());
  constexpr std::size_t most = 64;  // a sweep over a parameter leaves no trail of solvers
  if (solvers_.size() >= most) solvers_.clear();
  solvers_.emplace(text, solver);
  return solver;
}

BatchMemory SharedModel::batchMemory() const {
  const std::lock_guard lock(mutex_);
  return batch_;
}
void SharedModel::keep(BatchMemory memory) const {
  const std::lock_guard lock(mutex_);
  batch_ = std::move(memory);
}

// ---- in

namespace {

std::string shapeOf(const py::array& array) {
  std::string text = "(";
  for (py::ssize_t k = 0; k < array.ndim(); ++k)
    text += std::to_string(array.shape(k)) + (k + 1 < array.ndim() || array.ndim() == 1 ? ", " : "");
  if (text.ends_with(", ") && array.ndim() > 1) text.resize(text.size() - 2);
  if (text.ends_with(", ")) text.resize(text.size() - 1);
  return text + ")";
}

[[noreturn]] void wrongShape(const char* what, const std::string& wanted, const py::array& found) {
  throw std::invalid_argument(
      fmt::format("{}: expected an array of shape {}, found {}", what, wanted, shapeOf(found)));
}

void demandFinite(const double* data, py::ssize_t count, const char* what) {
  for (py::ssize_t i = 0; i < count; ++i)
    if (!std::isfinite(data[i]))
      throw std::invalid_argument(fmt::format("{} must be finite numbers; number {} is not", what, i + 1));
}

}  // namespace

Array numbers(py::handle value, const char* what) {
  if (py::isinstance<Array>(value)) return py::reinterpret_borrow<Array>(value);
  const py::array any = py::array::ensure(value);
  const char kind = any ? any.dtype().kind() : 'O';
  if (kind != 'f' && kind != 'i' && kind != 'u')
    throw std::invalid_argument(
        fmt::format("{}: expected real numbers, found {}", what,
                    any ? std::string(py::str(any.dtype())) : std::string(py::str(py::type::of(value)))));
  Array converted = Array::ensure(any);
  if (!converted) throw std::invalid_argument(fmt::format("{}: expected real numbers", what));
  return converted;
}

VectorXd vectorOf(py::handle value, int count, const char* what) {
  const Array array = numbers(value, what);
  if (array.ndim() != 1 || (count >= 0 && array.shape(0) != count))
    wrongShape(what, count >= 0 ? fmt::format("({},)", count) : "(n,)", array);
  demandFinite(array.data(), array.size(), what);
  return VectorXd::Map(array.data(), array.size());
}

Eigen::Vector2d pointInPlane(py::handle value, const char* what) { return vectorOf(value, 2, what); }
Vector3d point(py::handle value, const char* what) { return vectorOf(value, 3, what); }

Vector3d direction(py::handle value, const char* what) {
  const Vector3d v = point(value, what);
  const double length = v.norm();
  if (!(length > 1e-9)) throw std::invalid_argument(fmt::format("{}: a direction needs a length", what));
  return std::abs(length - 1.0) < 1e-12 ? v : v.normalized();  // what has length 1 keeps its bits
}

namespace {

Quaterniond ofMatrix(const Eigen::Matrix3d& R, const char* what) {
  if (!((R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-6) ||
      !(R.determinant() > 0.0))
    throw std::invalid_argument(fmt::format("{}: the matrix is no rotation (to 1e-6)", what));
  return Quaterniond(R).normalized();
}

Quaterniond ofNumbers(const double* wxyz, const char* what) {
  const Quaterniond q(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  if (!(std::abs(q.norm() - 1.0) < 1e-3))
    throw std::invalid_argument(
        fmt::format("{}: the quaternion must have length 1, not {:.6g}", what, q.norm()));
  return q.normalized();
}

}  // namespace

Quaterniond rotation(py::handle value, const char* what) {
  const Array array = numbers(value, what);
  demandFinite(array.data(), array.size(), what);
  if (array.ndim() == 1 && array.shape(0) == 4) return ofNumbers(array.data(), what);
  if (array.ndim() == 2 && array.shape(0) == 3 && array.shape(1) == 3)
    return ofMatrix(Eigen::Matrix<double, 3, 3, Eigen::RowMajor>::Map(array.data()), what);
  wrongShape(what, "(4,) or (3, 3)", array);
}

Eigen::Matrix3d rotationMatrix(py::handle value, const char* what) {
  const Quaterniond q = rotation(value, what);
  const Array array = numbers(value, what);
  return array.ndim() == 1 ? q.toRotationMatrix()
                           : Eigen::Matrix3d(Eigen::Matrix<double, 3, 3, Eigen::RowMajor>::Map(array.data()));
}

Isometry3d pose(py::handle value, const char* what) {
  const Array array = numbers(value, what);
  demandFinite(array.data(), array.size(), what);
  Isometry3d out = Isometry3d::Identity();
  if (array.ndim() == 1 && array.shape(0) == 7) {
    out.translation() = Vector3d::Map(array.data());
    out.linear() = ofNumbers(array.data() + 3, what).toRotationMatrix();
    return out;
  }
  if (array.ndim() != 2 || array.shape(0) != 4 || array.shape(1) != 4)
    wrongShape(what, "(4, 4) or (7,)", array);
  const Eigen::Matrix4d M = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>::Map(array.data());
  if (!((M.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() < 1e-9))
    throw std::invalid_argument(fmt::format("{}: the last row of a pose is 0, 0, 0, 1", what));
  ofMatrix(M.topLeftCorner<3, 3>(), what);
  out.matrix() = M;
  return out;
}

std::vector<Vector3d> points(py::handle value, const char* what) {
  const Array array = numbers(value, what);
  if (array.ndim() != 2 || array.shape(1) != 3) wrongShape(what, "(n, 3)", array);
  demandFinite(array.data(), array.size(), what);
  std::vector<Vector3d> out(array.shape(0));
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = Vector3d::Map(array.data() + 3 * i);
  return out;
}

VectorXd configuration(const Skeleton& skeleton, py::handle value, const char* what) {
  const Array array = numbers(value, what);
  if (array.ndim() != 1 || array.shape(0) != skeleton.nq())
    wrongShape(what, fmt::format("({},)", skeleton.nq()), array);
  return checkedConfiguration(skeleton, VectorXd::Map(array.data(), array.size()), what);
}

Configurations configurations(const Skeleton& skeleton, py::handle value, const char* what) {
  const Array array = numbers(value, what);
  const bool single = array.ndim() == 1;
  if ((array.ndim() != 1 && array.ndim() != 2) || array.shape(array.ndim() - 1) != skeleton.nq())
    wrongShape(what, fmt::format("({0},) or (n, {0})", skeleton.nq()), array);
  Configurations out{MatrixXd::Map(array.data(), skeleton.nq(), single ? 1 : array.shape(0)), single};
  for (Eigen::Index i = 0; i < out.q.cols(); ++i)
    out.q.col(i) = checkedConfiguration(skeleton, out.q.col(i), what);
  return out;
}

int jointOf(const Skeleton& skeleton, py::handle joint, const char* what) {
  if (py::isinstance<py::str>(joint)) return skeleton.jointIndex(joint.cast<std::string>());
  if (!PyIndex_Check(joint.ptr()) || PyBool_Check(joint.ptr()))
    throw std::invalid_argument(fmt::format("{}: expected a joint's name or index, found {}", what,
                                            std::string(py::str(py::type::of(joint)))));
  const py::ssize_t index = PyNumber_AsSsize_t(joint.ptr(), nullptr);
  if (index < 0 || index >= skeleton.jointCount())
    throw std::invalid_argument(
        fmt::format("{}: there are joints 0 to {}, not {}", what, skeleton.jointCount() - 1, index));
  return static_cast<int>(index);
}

Frames framesOf(py::handle value, int count, const char* what) {
  const Array array = numbers(value, what);
  if (array.ndim() != 3 || array.shape(0) != count || array.shape(1) != 4 || array.shape(2) != 4)
    wrongShape(what, fmt::format("({}, 4, 4)", count), array);
  demandFinite(array.data(), array.size(), what);
  Frames frames(count);
  for (int i = 0; i < count; ++i) {
    frames[i].matrix() = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>::Map(array.data() + 16 * i);
    if (frames[i].matrix().row(3) != Eigen::RowVector4d(0, 0, 0, 1))
      throw std::invalid_argument(fmt::format("{}: the last row of frame {} is not 0, 0, 0, 1", what, i));
  }
  return frames;
}

std::uint64_t wholeSeed(py::handle value, const char* what) {
  const auto refuse = [&] {
    throw std::invalid_argument(fmt::format("{}: a seed is a whole number from 0 to 2^64 - 1, found {}", what,
                                            std::string(py::repr(value))));
  };
  if (!PyIndex_Check(value.ptr()) || PyBool_Check(value.ptr())) refuse();
  const py::object number = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  if (!number) throw py::error_already_set();
  const std::uint64_t seed = PyLong_AsUnsignedLongLong(number.ptr());
  if (PyErr_Occurred()) {
    PyErr_Clear();
    refuse();
  }
  return seed;
}

std::uint64_t seedOf(py::handle rng) {
  const py::object numpy = py::module_::import("numpy");
  py::object generator = py::reinterpret_borrow<py::object>(rng);
  if (rng.is_none()) generator = numpy.attr("random").attr("default_rng")();
  if (py::hasattr(generator, "integers"))
    return generator.attr("integers")(0, std::uint64_t{1} << 63).cast<std::uint64_t>();
  if (!PyIndex_Check(rng.ptr()) || PyBool_Check(rng.ptr()))
    throw std::invalid_argument("rng: expected None, a seed, or a numpy random Generator");
  return wholeSeed(rng, "rng");
}

// ---- out

namespace {

/// The array owns the moved value, of which `data` is the first number.
template <typename T>
py::array_t<double> owning(T value, const double* (*data)(const T&), std::vector<py::ssize_t> shape,
                           std::vector<py::ssize_t> strides) {
  auto kept = std::make_unique<T>(std::move(value));
  const double* first = data(*kept);
  py::capsule owner(kept.release(), [](void* p) { delete static_cast<T*>(p); });
  return py::array_t<double>(std::move(shape), std::move(strides), first, owner);
}

}  // namespace

py::array_t<double> toArray(const VectorXd& v) { return py::array_t<double>(v.size(), v.data()); }
py::array_t<double> toArray(const Vector3d& v) { return py::array_t<double>(3, v.data()); }
py::array_t<double> toArray(const Isometry3d& pose) { return matrixArray(pose.matrix()); }

py::array_t<double> matrixArray(const Eigen::Ref<const MatrixXd>& M) {
  py::array_t<double> out({M.rows(), M.cols()});
  Eigen::Map<Eigen::Matrix<double, -1, -1, Eigen::RowMajor>>(out.mutable_data(), M.rows(), M.cols()) = M;
  return out;
}

py::array_t<double> samples(MatrixXd columns) {
  const py::ssize_t n = columns.cols(), each = columns.rows(), size = sizeof(double);
  return owning<MatrixXd>(std::move(columns), [](const MatrixXd& M) { return M.data(); }, {n, each},
                          {size * each, size});
}

py::array_t<double> pointsArray(std::vector<Vector3d> points) {
  const py::ssize_t n = static_cast<py::ssize_t>(points.size()), size = sizeof(double);
  using Points = std::vector<Vector3d>;
  return owning<Points>(std::move(points),
                        [](const Points& p) { return reinterpret_cast<const double*>(p.data()); }, {n, 3},
                        {3 * size, size});
}

py::array_t<double> framesArray(Frames frames) {
  static_assert(sizeof(Isometry3d) == 16 * sizeof(double));
  const py::ssize_t n = static_cast<py::ssize_t>(frames.size()), size = sizeof(double);
  return owning<Frames>(std::move(frames),
                        [](const Frames& f) { return reinterpret_cast<const double*>(f.data()); }, {n, 4, 4},
                        {16 * size, size, 4 * size});
}

py::array_t<double> view(std::vector<py::ssize_t> shape, std::vector<py::ssize_t> strides, const double* data,
                         py::handle owner) {
  return py::array_t<double>(std::move(shape), std::move(strides), data, owner);
}

py::array readOnly(py::array array) {
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

}  // namespace gelenk::python
