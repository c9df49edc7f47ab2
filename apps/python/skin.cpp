#include <fmt/format.h>

#include <cstring>

#include "apps/document/chosen_skin.h"
#include "apps/document/model_files.h"
#include "apps/document/muscle_settings.h"
#include "apps/python/binding.h"
#include "skinning/blend/linear_blend.h"
#include "skinning/blend/skin_choice.h"
#include "skinning/io/stl.h"
#include "skinning/rigging/auto_rig.h"
#include "skinning/rigging/bone_heat.h"

// Bodies: skins, muscle layers between skeleton and skin, rigging.

namespace gelenk::python {
namespace {

using Eigen::Vector3d;
using namespace py::literals;

/// (n, 3) without a copy; `owner` keeps the points.
py::array pointsView(const std::vector<Vector3d>& points, py::handle owner) {
  const py::ssize_t size = sizeof(double);
  return readOnly(view({static_cast<py::ssize_t>(points.size()), 3}, {3 * size, size},
                       reinterpret_cast<const double*>(points.data()), owner));
}

/// Frames of one pose (joints, 4, 4), or of many (n, joints, 4, 4): the surface of each.
template <typename Pose>
py::array posed(py::handle frames, int joints, std::size_t vertices, const Pose& pose) {
  const Array array = numbers(frames, "frames");
  if (array.ndim() == 3) {
    const Frames one = framesOf(array, joints);
    SkinnedVertices out;
    {
      const py::gil_scoped_release alone;
      pose(one, out);
    }
    return pointsArray(std::move(out.positions));
  }
  if (array.ndim() != 4)
    throw std::invalid_argument(
        fmt::format("frames: expected an array of shape ({0}, 4, 4) or (n, {0}, 4, 4)", joints));
  const py::ssize_t n = array.shape(0);
  py::array_t<double> out({n, static_cast<py::ssize_t>(vertices), py::ssize_t{3}});
  SkinnedVertices surface;
  for (py::ssize_t i = 0; i < n; ++i) {
    const Frames one = framesOf(array[py::int_(i)], joints);
    double* to = out.mutable_data() + 3 * vertices * i;
    const py::gil_scoped_release alone;
    pose(one, surface);
    std::memcpy(to, surface.positions.data(), 3 * sizeof(double) * vertices);
  }
  return out;
}

// ---- skins

/// A model's skin; keeps the model.
struct SkinOf {
  ModelPtr model;
  const Skin& skin() const { return *model->model().skin; }
  int joints() const { return skin().jointCount(); }
};

py::object skinOf(const ModelPtr& model) {
  return model->model().skin ? py::cast(SkinOf{model}) : py::none();
}

py::array trianglesOf(const Mesh& mesh, py::handle owner) {
  return readOnly(py::array_t<int>({static_cast<py::ssize_t>(mesh.triangles.size()), py::ssize_t{3}},
                                   mesh.triangles.empty() ? nullptr : mesh.triangles[0].data(), owner));
}

py::array influenceJoints(const Skin& skin) {
  py::array_t<int> out({static_cast<py::ssize_t>(skin.influences.size()), py::ssize_t{4}});
  for (std::size_t v = 0; v < skin.influences.size(); ++v)
    std::copy_n(skin.influences[v].joints.begin(), 4, out.mutable_data() + 4 * v);
  return out;
}
py::array influenceWeights(const Skin& skin) {
  py::array_t<double> out({static_cast<py::ssize_t>(skin.influences.size()), py::ssize_t{4}});
  for (std::size_t v = 0; v < skin.influences.size(); ++v)
    std::copy_n(skin.influences[v].weights.begin(), 4, out.mutable_data() + 4 * v);
  return out;
}

py::tuple withNormals(const SkinOf& self, py::handle frames) {
  SkinnedVertices out;
  linearBlendSkin(self.skin(), framesOf(frames, self.joints()), out);
  return py::make_tuple(pointsArray(std::move(out.positions)), pointsArray(std::move(out.normals)));
}

/// A skin made ready for one of the skinning methods; stands alone.
struct Blend {
  std::string choice;
  ChosenSkin skin;
  std::size_t vertices;
  SkinnedVertices at(const Frames& frames) const {
    SkinnedVertices out;
    skin.pose(frames, nullptr, out);
    return out;
  }
};

Blend prepareBlend(const SkinOf& self, const std::string& text) {
  const SkinChoice choice = parseSkinChoice(text);
  const py::gil_scoped_release alone;
  const Model& model = self.model->model();
  return {toString(choice), ChosenSkin(model, self.skin(), choice), self.skin().mesh.positions.size()};
}

py::tuple blendWithNormals(const Blend& self, py::handle frames) {
  SkinnedVertices out = self.at(framesOf(frames, self.skin.jointCount()));
  return py::make_tuple(pointsArray(std::move(out.positions)), pointsArray(std::move(out.normals)));
}

py::list methodTable() {
  py::list table;
  for (const SkinMethod* method : skinMethods())
    table.append(
        py::dict("name"_a = method->name, "title"_a = method->title, "reference"_a = method->reference));
  return table;
}

void addBlends(py::module_& m) {
  py::class_<Blend>(m, "Blend", "A skin made ready for a skinning method: blend(frames) -> vertices.")
      .def(
          "__call__",
          [](const Blend& self, py::handle frames) {
            return posed(frames, self.skin.jointCount(), self.vertices,
                         [&](const Frames& f, SkinnedVertices& out) { out = self.at(f); });
          },
          "frames"_a, "(vertices, 3), metres; (n, joints, 4, 4) gives (n, vertices, 3).")
      .def("with_normals", &blendWithNormals, "frames"_a, "(vertices, 3) and unit normals (vertices, 3).")
      .def_property_readonly(
          "method", [](const Blend& self) { return self.choice; }, "Text of the choice.")
      .def("__repr__", [](const Blend& self) { return "<gelenk.Blend " + self.choice + ">"; });
  m.def("skin_methods", &methodTable, "The skinning methods: dicts of name, title, reference.");
}

void addSkins(py::module_& m) {
  py::class_<SkinOf>(m, "Skin",
                     "A mesh bound to a model's joints: skin(frames) -> vertices, linear blend skinning.")
      .def(
          "__call__",
          [](const SkinOf& self, py::handle frames) {
            return posed(
                frames, self.joints(), self.skin().mesh.positions.size(),
                [&](const Frames& f, SkinnedVertices& out) { linearBlendSkin(self.skin(), f, out); });
          },
          "frames"_a, "(vertices, 3), metres, for model.fk(q); (n, joints, 4, 4) gives (n, vertices, 3).")
      .def("with_normals", &withNormals, "frames"_a, "(vertices, 3) and their unit normals (vertices, 3).")
      .def("method", &prepareBlend, "choice"_a,
           "The skin by another method: 'dqs', 'cor', ... (skin_methods()), with '+twist' spread along limbs "
           "and\n"
           "'+smooth=MM' of the weights: a Blend.")
      .def_property_readonly(
          "vertices",
          [](const py::object& self) {
            return pointsView(self.cast<const SkinOf&>().skin().mesh.positions, self);
          },
          "(vertices, 3) in the pose that the skin is bound in; read only, no copy.")
      .def_property_readonly(
          "triangles",
          [](const py::object& self) { return trianglesOf(self.cast<const SkinOf&>().skin().mesh, self); },
          "(triangles, 3) counter-clockwise from outside; read only, no copy.")
      .def_property_readonly(
          "joints", [](const SkinOf& self) { return influenceJoints(self.skin()); },
          "(vertices, 4) joints that carry each vertex.")
      .def_property_readonly(
          "weights", [](const SkinOf& self) { return influenceWeights(self.skin()); },
          "(vertices, 4) their weights, falling, of sum 1.")
      .def_property_readonly(
          "bind_frames", [](const SkinOf& self) { return framesArray(bindFrames(self.model->model())); },
          "(joints, 4, 4) of the pose that the skin is bound in.")
      .def("__repr__", [](const SkinOf& self) {
        return fmt::format("<gelenk.Skin of '{}': {} vertices, {} triangles>", self.model->model().name,
                           self.skin().mesh.positions.size(), self.skin().mesh.triangles.size());
      });
}

// ---- muscles

/// Muscle layers bound to a model's skin.
class Muscles {
 public:
  Muscles(ModelPtr model, double activation, bool keepVolume)
      : model_(std::move(model)), rig_(make(*model_, activation, keepVolume)) {}

  py::array operator()(py::handle frames) const {
    return posed(
        frames, model_->model().skin->jointCount(), rig_.body().skin.mesh.positions.size(),
        [&](const Frames& f, SkinnedVertices& out) { skinWithMuscles(rig_.body(), f, rig_.pose(f), out); });
  }
  std::vector<std::string> limbs() const {
    std::vector<std::string> names;
    for (const Limb& limb : rig_.body().limbs) names.push_back(limb.name);
    return names;
  }

 private:
  static MuscleRig make(const SharedModel& model, double activation, bool keepVolume) {
    if (!model.model().skin) throw std::invalid_argument("'" + model.model().name + "' has no skin");
    if (!(activation >= 0.0 && activation <= 1.0))
      throw std::invalid_argument("activation lies between 0 and 1");
    const std::vector<Limb> limbs = limbsOf(model.model());
    if (limbs.empty())
      throw std::invalid_argument("'" + model.model().name +
                                  "' has no limb of a known name (upperarm_l, lowerarm_l, hand_l, ...)");
    MuscleSettings settings = defaultMuscleSettings(limbs);
    for (auto& [name, limb] : settings.limbs) {
      limb.control.activation = activation;
      limb.control.keepVolume = keepVolume;
    }
    return makeMuscleRig(model.model(), *model.model().skin, settings);
  }

  ModelPtr model_;
  MuscleRig rig_;
};

// ---- rigging

Mesh meshFrom(py::handle body, py::handle triangles) {
  if (triangles.is_none()) {
    const std::string path = py::str(py::module_::import("os").attr("fspath")(body));
    if (path.ends_with(".stl") || path.ends_with(".STL")) return readStl(path);
    if (fileKind(path) == FileKind::Gltf) {
      Model model = openModelFile(path);
      if (!model.skin) throw std::invalid_argument("'" + path + "' holds no mesh");
      return std::move(model.skin->mesh);
    }
    return readMesh(path);
  }
  Mesh mesh{.positions = points(body, "vertices")};
  const py::array any = py::array::ensure(triangles);
  if (!any || (any.dtype().kind() != 'i' && any.dtype().kind() != 'u') || any.ndim() != 2 ||
      any.shape(1) != 3)
    throw std::invalid_argument("triangles: expected an array of whole numbers of shape (n, 3)");
  const py::array_t<std::int64_t, py::array::c_style | py::array::forcecast> list(any);
  for (py::ssize_t t = 0; t < list.shape(0); ++t) {
    std::array<int, 3> corner;
    for (int k = 0; k < 3; ++k) {
      const std::int64_t index = list.at(t, k);
      if (index < 0 || index >= static_cast<std::int64_t>(mesh.positions.size()))
        throw std::invalid_argument(
            fmt::format("triangles: row {} names vertex {} of {}", t, index, mesh.positions.size()));
      corner[k] = static_cast<int>(index);
    }
    mesh.triangles.push_back(corner);
  }
  validate(mesh);
  return mesh;
}

std::optional<Vector3d> axisOf(py::handle axis, const char* what) {
  if (axis.is_none()) return {};
  if (!py::isinstance<py::str>(axis)) return direction(axis, what);
  const std::string name = axis.cast<std::string>();
  if (name.empty() || name.size() > 2 || name.back() < 'x' || name.back() > 'z' ||
      (name.size() == 2 && name[0] != '-'))
    throw std::invalid_argument(fmt::format("{}: x, -z or the like, or three numbers, not '{}'", what, name));
  return Vector3d((name.size() == 2 ? -1.0 : 1.0) * Vector3d::Unit(name.back() - 'x'));
}

py::tuple rig(const py::object& body, const py::object& triangles, const py::object& skeleton,
              const py::object& up, const py::object& front, const std::string& name,
              const py::object& progress) {
  Mesh mesh = meshFrom(body, triangles);
  RigOptions options{.up = axisOf(up, "up"), .front = axisOf(front, "front")};
  if (py::isinstance<SharedModel>(skeleton)) {
    options.own = skeleton.cast<const SharedModel&>().skeleton();
  } else {
    const std::string word = py::str(skeleton);
    if (word == "pinocchio")
      options.skeleton = RigTemplate::Pinocchio;
    else if (word == "quadruped")
      options.skeleton = RigTemplate::Quadruped;
    else if (word != "human")
      throw std::invalid_argument("skeleton: human, pinocchio, quadruped or a Model, not '" + word + "'");
  }
  options.progress = [&](const std::string& stage, double done) {
    const py::gil_scoped_acquire lock;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    return progress.is_none() || !py::bool_(py::object(progress(stage, done)).is(py::bool_(false)));
  };
  Model model{.name = name};
  RigReport report;
  {
    const py::gil_scoped_release alone;
    RiggedBody rigged = rigBody(mesh, options);
    const int joints = rigged.skeleton.jointCount();
    model.skin = bindSkin(std::move(mesh), restFrames(rigged.skeleton), fourLargest(rigged.weights, joints));
    model.skeleton = std::move(rigged.skeleton);
    report = std::move(rigged.report);
  }
  const py::dict told("up"_a = toArray(report.up), "front"_a = toArray(report.front),
                      "height"_a = report.height, "confidence"_a = report.confidence,
                      "misfit"_a = report.misfit, "pose"_a = report.pose, "symmetric"_a = report.symmetric,
                      "lost_weight"_a = report.loss.mean, "repairs"_a = report.repairs,
                      "doubts"_a = report.doubts);
  return py::make_tuple(std::make_shared<SharedModel>(std::move(model)), told);
}

/// The model with another body, bound in its rest pose.
ModelPtr bound(const ModelPtr& model, const py::object& vertices, const py::object& triangles,
               const py::object& weights) {
  Model out = model->model();
  const int joints = out.skeleton.jointCount();
  Mesh mesh = meshFrom(vertices, triangles);
  const Frames rest = restFrames(out.skeleton);
  SparseWeights rows;
  if (weights.is_none()) {
    const py::gil_scoped_release alone;
    const std::vector<Bone> bones = bonesOf(out.skeleton, rest);
    rows = boneHeatWeights(mesh, bones);
  } else {
    const Array W = numbers(weights, "weights");
    if (W.ndim() != 2 || W.shape(0) != static_cast<py::ssize_t>(mesh.positions.size()) ||
        W.shape(1) != joints)
      throw std::invalid_argument(
          fmt::format("weights: expected an array of shape ({}, {})", mesh.positions.size(), joints));
    rows.resize(mesh.positions.size());
    for (std::size_t v = 0; v < rows.size(); ++v)
      for (int j = 0; j < joints; ++j)
        if (const double w = W.at(v, j); w != 0.0) rows[v].emplace_back(j, w);
  }
  out.skin = bindSkin(std::move(mesh), rest, fourLargest(rows, joints));
  return std::make_shared<SharedModel>(std::move(out));
}

}  // namespace

void addSkin(py::module_& m) {
  addBlends(m);
  addSkins(m);
  py::class_<Muscles>(
      m, "Muscles",
      "Muscle layers between skeleton and skin (docs/muscles.md): muscles(frames) -> vertices. Arms\n"
      "and legs of known names carry them. activation: 0 to 1, contraction without motion.")
      .def(py::init<ModelPtr, double, bool>(), modelArgument(), py::kw_only(), "activation"_a = 0.0,
           "keep_volume"_a = true)
      .def("__call__", &Muscles::operator(), "frames"_a,
           "(vertices, 3), metres; (n, joints, 4, 4) gives (n, vertices, 3).")
      .def_property_readonly("limbs", &Muscles::limbs, "Names of the limbs that carry muscles.");
  m.attr("Model").attr("skin") =
      py::module_::import("builtins")
          .attr("property")(py::cpp_function(&skinOf), py::none(), py::none(), "The Skin, or None.");
  m.def(
      "with_body",
      [](const ModelPtr& model) {
        const py::gil_scoped_release alone;
        return std::make_shared<SharedModel>(withBody(model->model()));
      },
      modelArgument(), "The model with a rounded body around its bones where it has no skin.");
  py::register_exception<RigRefused>(m, "RigRefused", PyExc_ValueError).doc() =
      "The body is none of the kind that was asked for, or no skeleton fits it.";
  m.def("rig", &rig, "body"_a, "triangles"_a = py::none(), py::kw_only(), "skeleton"_a = "human",
        "up"_a = py::none(), "front"_a = py::none(), "name"_a = "body", "progress"_a = py::none(),
        "A skeleton and weights for a body that has neither: (Model, report). body: a file (OBJ, STL, glTF), "
        "or\n"
        "vertices (n, 3) with triangles (m, 3). skeleton: 'human', 'pinocchio', 'quadruped' or a Model. up, "
        "front:\n"
        "'y', '-z', ... or three numbers; found out where not given. progress: a function (stage, done); "
        "False\n"
        "stops. Raises RigRefused where the body is none of that kind.");
  m.def("bind", &bound, modelArgument(), "vertices"_a, "triangles"_a, "weights"_a = py::none(),
        "The model with a mesh bound in its rest pose: weights (vertices, joints), of which the four largest "
        "are\n"
        "kept, or heat weights.");
}

}  // namespace gelenk::python
