#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <Eigen/Geometry>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "apps/commands/solve_batch.h"
#include "apps/document/model.h"
#include "apps/document/model_reference.h"
#include "kinematics/forward_kinematics.h"
#include "solvers/problem/ik_solver.h"

// What the files of the Python module share: models as Python holds them, numbers in and out.

namespace gelenk::python {

namespace py = pybind11;

/// A model and what belongs to it: constant, so that threads may share it.
class SharedModel {
 public:
  explicit SharedModel(Model model, std::optional<ModelReference> reference = {});
  SharedModel(std::shared_ptr<const Model> model, Eigen::VectorXd pose, std::vector<Goal> goals,
              ModelReference reference);

  const Model& model() const { return *model_; }
  std::shared_ptr<const Model> shared() const { return model_; }
  const Skeleton& skeleton() const { return model_->skeleton; }
  const Eigen::VectorXd& pose() const { return pose_; }      ///< nq: the scene's own, else the rest pose
  const std::vector<Goal>& goals() const { return goals_; }  ///< a scene's
  /// The files that another process opens to have the same model; none where it was made here.
  const std::optional<ModelReference>& reference() const { return reference_; }

  /// The solver of a choice's text, prepared for this skeleton once. Throws std::invalid_argument.
  std::shared_ptr<const IkSolver> solver(const std::string& text) const;
  /// What the last large batch left for the next one.
  BatchMemory batchMemory() const;
  void keep(BatchMemory memory) const;

 private:
  std::shared_ptr<const Model> model_;
  Eigen::VectorXd pose_;
  std::vector<Goal> goals_;
  std::optional<ModelReference> reference_;
  mutable std::mutex mutex_;
  mutable std::map<std::string, std::shared_ptr<const IkSolver>, std::less<>> solvers_;
  mutable int changes_ = 0;  ///< of the catalogue when they were made
  mutable BatchMemory batch_;
};
using ModelPtr = std::shared_ptr<SharedModel>;
/// The argument `model`; None is none.
inline py::arg modelArgument() { return py::arg("model").none(false); }

// ---- numbers in: what is no array of real numbers of the wanted shape is a ValueError that begins with
// `what`

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;
/// Real numbers of any shape, NaN included.
Array numbers(py::handle value, const char* what);
/// Finite numbers; count < 0: any count.
Eigen::VectorXd vectorOf(py::handle value, int count, const char* what);
Eigen::Vector2d pointInPlane(py::handle value, const char* what);
Eigen::Vector3d point(py::handle value, const char* what);
Eigen::Vector3d direction(py::handle value, const char* what);  ///< made of length 1
/// Four numbers w, x, y, z of length 1 (to 1e-3, then made so), or a 3 x 3 rotation matrix (to 1e-6).
Eigen::Quaterniond rotation(py::handle value, const char* what);
/// The same as a matrix; one that is given keeps its bits.
Eigen::Matrix3d rotationMatrix(py::handle value, const char* what);
/// A 4 x 4 matrix whose rotation is one to 1e-6, or seven numbers x, y, z, w, x, y, z.
Eigen::Isometry3d pose(py::handle value, const char* what);
/// n x 3.
std::vector<Eigen::Vector3d> points(py::handle value, const char* what);
/// nq finite numbers, quaternions of length 1 to 1e-3 and then made so (checkedConfiguration).
Eigen::VectorXd configuration(const Skeleton& skeleton, py::handle q, const char* what = "q");
/// One configuration, or (n, nq) of them, by columns.
struct Configurations {
  Eigen::MatrixXd q;  ///< nq x n
  bool single = false;
};
Configurations configurations(const Skeleton& skeleton, py::handle q, const char* what = "q");
/// A joint by its name or index.
int jointOf(const Skeleton& skeleton, py::handle joint, const char* what = "joint");
/// One frame a joint, (joints, 4, 4), last rows 0, 0, 0, 1.
Frames framesOf(py::handle frames, int count, const char* what = "frames");
/// The argument `seed`: a whole number from 0 to 2^64 - 1, anything else is a ValueError.
struct Seed {
  std::uint64_t value = 1;
};
std::uint64_t wholeSeed(py::handle number, const char* what);
/// A seed from None (the system's randomness), a whole number, or a numpy random Generator.
std::uint64_t seedOf(py::handle rng);

// ---- numbers out

py::array_t<double> toArray(const Eigen::VectorXd& v);
py::array_t<double> toArray(const Eigen::Vector3d& v);
py::array_t<double> toArray(const Eigen::Isometry3d& pose);
/// Rows as in the matrix, C order.
py::array_t<double> matrixArray(const Eigen::Ref<const Eigen::MatrixXd>& M);
/// (n, columns of one sample): the columns of the matrix as rows; no copy: the array owns the moved matrix.
py::array_t<double> samples(Eigen::MatrixXd columns);
py::array_t<double> pointsArray(std::vector<Eigen::Vector3d> points);  ///< (n, 3), owns the moved points
/// (joints, 4, 4) with strides 128, 8, 32: the array owns the moved frames.
py::array_t<double> framesArray(Frames frames);
/// A view of memory that `owner` keeps.
py::array_t<double> view(std::vector<py::ssize_t> shape, std::vector<py::ssize_t> strides, const double* data,
                         py::handle owner);
py::array readOnly(py::array array);
py::list noteList(const std::vector<Note>& notes);  ///< (kind, sentence)

/// The scene that opens this model elsewhere.
std::string sceneText(const SharedModel& model);

// ---- one function a subject, each in its file

void addModel(py::module_& m);
void addMathematics(py::module_& m);
void addGoals(py::module_& m);
void addSolve(py::module_& m);
void addOwn(py::module_& m);
void addLab(py::module_& m);
void addSkin(py::module_& m);
void addMotion(py::module_& m);

}  // namespace gelenk::python

template <>
struct pybind11::detail::type_caster<gelenk::python::Seed> {
  PYBIND11_TYPE_CASTER(gelenk::python::Seed, const_name("int"));
  bool load(handle number, bool) {
    value.value = gelenk::python::wholeSeed(number, "seed");
    return true;
  }
};
