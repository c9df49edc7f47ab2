#include <fmt/format.h>

#include <cmath>

#include "apps/commands/command_line.h"
#include "apps/commands/commands.h"
#include "apps/document/model_files.h"
#include "apps/document/notes.h"
#include "apps/document/scene_file.h"
#include "apps/python/binding.h"
#include "kinematics/io/text_file.h"
#include "kinematics/motion/motion_edit.h"
#include "kinematics/motion/motion_retarget.h"

// Motion as arrays, motion for another model, and files.

namespace gelenk::python {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using namespace py::literals;

/// A motion with the model that it moves.
struct Clip {
  ModelPtr model;
  std::shared_ptr<const MotionClip> clip;

  Clip with(MotionClip other) const { return {model, std::make_shared<const MotionClip>(std::move(other))}; }
};

Clip makeClip(const ModelPtr& model, py::handle q, double framesPerSecond) {
  const Configurations all = configurations(model->skeleton(), q);
  MotionClip clip{.framesPerSecond = framesPerSecond, .q = all.q};
  validate(model->skeleton(), clip);
  return {model, std::make_shared<const MotionClip>(std::move(clip))};
}

void demandSameModel(const Clip& a, const Clip& b) {
  if (a.clip->q.rows() != b.clip->q.rows())
    throw std::invalid_argument("both clips must be of one model; retarget the second");
}

double demandPositive(double value, const char* what) {
  if (!(value > 0.0) || !std::isfinite(value))
    throw std::invalid_argument(fmt::format("{} must be above 0", what));
  return value;
}

py::array sampled(const Clip& self, py::handle seconds, bool loop) {
  const Skeleton& skeleton = self.model->skeleton();
  const BeyondEnd beyond = loop ? BeyondEnd::Loop : BeyondEnd::Stay;
  const Array times = numbers(seconds, "seconds");
  if (times.ndim() == 0) {
    const double t = vectorOf(py::make_tuple(seconds), 1, "seconds")[0];
    return toArray(sample(skeleton, *self.clip, t, beyond));
  }
  const VectorXd t = vectorOf(times, -1, "seconds");
  MatrixXd out(skeleton.nq(), t.size());
  VectorXd q;
  for (Eigen::Index i = 0; i < t.size(); ++i) {
    sample(skeleton, *self.clip, t[i], beyond, q);
    out.col(i) = q;
  }
  return samples(std::move(out));
}

py::tuple retarget(const Clip& self, const ModelPtr& target, std::optional<double> scale, bool feet,
                   bool hands) {
  RetargetOptions options{.targetUp = target->model().up, .keepFeet = feet, .keepHands = hands};
  if (scale) options.scale = demandPositive(*scale, "scale");
  RetargetedClip out;
  {
    const py::gil_scoped_release alone;
    out = retargeted(self.model->skeleton(), *self.clip, target->skeleton(), options);
  }
  py::dict remaining;
  for (const RemainingAngle& bone : out.remaining)
    remaining[py::str(target->skeleton().joint(bone.joint).name)] = py::make_tuple(bone.mean, bone.largest);
  return py::make_tuple(
      Clip{target, std::make_shared<const MotionClip>(std::move(out.clip))},
      py::dict("scale"_a = out.scale, "root_moves"_a = out.rootMoves, "remaining_angles"_a = remaining));
}

std::vector<int> jointsOf(const Skeleton& skeleton, const py::iterable& names) {
  std::vector<int> out;
  for (const py::handle& name : names) out.push_back(jointOf(skeleton, name));
  return out;
}

Clip overlaid(const Clip& self, const Clip& layer, double weight, const py::iterable& joints, bool additive) {
  demandSameModel(self, layer);
  return self.with(layered(self.model->skeleton(), *self.clip,
                           {.clip = *layer.clip,
                            .kind = additive ? Layer::Kind::Additive : Layer::Kind::Override,
                            .weight = weight,
                            .joints = jointsOf(self.model->skeleton(), joints)}));
}

py::tuple planted(const Clip& self, const py::iterable& feet, double floor) {
  const Skeleton& skeleton = self.model->skeleton();
  std::vector<Foot> list;
  for (const int ball : jointsOf(skeleton, feet)) list.push_back(footAt(skeleton, ball));
  if (list.empty()) list = cmuFeet(skeleton);
  if (list.empty())
    throw std::invalid_argument(
        "feet: name the joints at the balls of the feet (no joint is called ltoes or rtoes)");
  if (!std::isfinite(floor)) throw std::invalid_argument("floor must be a finite number");
  FootPlantOptions options;
  options.floor = floor;
  const std::vector<Contact> contacts = footContacts(skeleton, *self.clip, list, options);
  MotionClip out = footPlanted(skeleton, *self.clip, list, contacts, options);
  const FootFacts before = footFacts(skeleton, *self.clip, list, contacts, floor),
                  after = footFacts(skeleton, out, list, contacts, floor);
  return py::make_tuple(self.with(std::move(out)),
                        py::dict("contacts"_a = contacts.size(), "slide_before"_a = before.meanSlide,
                                 "slide_after"_a = after.meanSlide));
}

/// As `gelenk convert` writes it; what the format cannot hold: (kind, sentence).
py::list save(const py::object& where, const ModelPtr& model, const py::object& clip) {
  const std::string path = py::str(py::module_::import("os").attr("fspath")(where));
  Imported whole{.model = model->model()};
  whole.model.notes.clear();
  if (!clip.is_none()) {
    const Clip& given = clip.cast<const Clip&>();
    if (given.clip->q.rows() != model->skeleton().nq())
      throw std::invalid_argument("clip: it is of another model");
    if (isScene(path)) throw std::invalid_argument("a scene holds no clip; save it as .glb or .bvh");
    whole.model.clip = *given.clip;
  }
  {
    const py::gil_scoped_release alone;
    if (isScene(path))
      writeFile(path, sceneText(*model));
    else
      exportFile(path, whole);
  }
  return noteList(whole.model.notes);
}

/// A command of the program, in this process; its exit status.
int command(const py::args& words) {
  std::vector<std::string> list;
  for (const py::handle& word : words) list.push_back(py::str(word));
  if (list.empty()) throw std::invalid_argument("which command?");
  const py::gil_scoped_release alone;
  CommandLine line("Gelenk", GELENK_VERSION);
  Command root = line.root();
  addNoteOptions(root);
  addCommands(root);
  try {
    line.parse(list);
  } catch (const ExitStatus& status) {
    std::fflush(stdout);
    return status.status;
  }
  std::fflush(stdout);
  return 0;
}

py::object clipOf(const ModelPtr& model) {
  if (!model->model().clip) return py::none();
  return py::cast(Clip{model, std::shared_ptr<const MotionClip>(model->shared(), &*model->model().clip)});
}

}  // namespace

void addMotion(py::module_& m) {
  py::class_<Clip>(m, "Clip", "A motion of a model, sampled at a constant rate.")
      .def(py::init(&makeClip), modelArgument(), "q"_a, "frames_per_second"_a = 30.0, "q: (frames, nq).")
      .def_property_readonly(
          "model", [](const Clip& c) { return c.model; }, "The Model that it moves.")
      .def_property_readonly(
          "frames_per_second", [](const Clip& c) { return c.clip->framesPerSecond; }, "Hz.")
      .def_property_readonly(
          "duration", [](const Clip& c) { return c.clip->duration(); }, "Seconds.")
      .def_property_readonly(
          "q",
          [](const py::object& self) {
            const MatrixXd& q = self.cast<const Clip&>().clip->q;
            const py::ssize_t size = sizeof(double);
            return readOnly(view({q.cols(), q.rows()}, {q.rows() * size, size}, q.data(), self));
          },
          "(frames, nq); read only, no copy.")
      .def("__len__", [](const Clip& c) { return c.clip->frameCount(); })
      .def("sample", &sampled, "seconds"_a, "loop"_a = false,
           "(nq,) at a time, or (n, nq) at n times; rotations of whole joints along the shorter arc.")
      .def(
          "resampled",
          [](const Clip& c, double rate) {
            return c.with(resampled(c.model->skeleton(), *c.clip, demandPositive(rate, "frames_per_second")));
          },
          "frames_per_second"_a, "The same motion at another rate, Hz.")
      .def(
          "low_passed",
          [](const Clip& c, double cutoff) {
            return c.with(lowPassed(c.model->skeleton(), *c.clip, demandPositive(cutoff, "cutoff")));
          },
          "cutoff"_a, "Zero-phase Butterworth, Hz.")
      .def(
          "cross_faded",
          [](const Clip& c, const Clip& then, double seconds, bool align) {
            demandSameModel(c, then);
            return c.with(crossFaded(c.model->skeleton(), *c.clip, *then.clip,
                                     demandPositive(seconds, "seconds"), align));
          },
          "then"_a, "seconds"_a = 0.3, "align_root"_a = true,
          "This clip, then another one of the same model.")
      .def("layered", &overlaid, "layer"_a, "weight"_a = 1.0, "joints"_a = py::tuple(), "additive"_a = false,
           "Another clip laid over this one; joints: those that take part, default all.")
      .def("retarget", &retarget, modelArgument(), py::kw_only(), "scale"_a = py::none(),
           "keep_feet"_a = false, "keep_hands"_a = false,
           "(Clip of the other model, report) by joints of equal names; scale: of the path.")
      .def("foot_planted", &planted, "feet"_a = py::tuple(), "floor"_a = 0.0,
           "(Clip, report) with feet that stand still; feet: joints at their balls, default CMU's.")
      .def("__repr__", [](const Clip& c) {
        return fmt::format("<gelenk.Clip of '{}': {} frames at {:.6g} Hz>", c.model->model().name,
                           c.clip->frameCount(), c.clip->framesPerSecond);
      });
  m.attr("Model").attr("clip") = py::module_::import("builtins")
                                     .attr("property")(py::cpp_function(&clipOf), py::none(), py::none(),
                                                       "The Clip that came with it, or None.");
  m.def("save", &save, "path"_a, modelArgument(), "clip"_a = py::none(),
        "Writes a model, its skin and its motion (or another clip) in the format of the path's ending, as "
        "`gelenk "
        "convert`\n"
        "does, or as a scene (.json). A list of (kind, sentence) of what that format cannot hold.");
  m.def("command", &command,
        "A command of the program in this process, such as command('convert', 'walk.bvh', 'walk.glb'); "
        "prints what\n"
        "it prints and returns its exit status, 0 or 2; errors are exceptions.");
}

}  // namespace gelenk::python
