#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "kinematics/configuration.h"
#include "kinematics/io/parse_error.h"
#include "kinematics/rotation.h"
#include "skinning/blend/linear_blend.h"
#include "skinning/io/gltf.h"
#include "tests/kinematics/random_skeleton.h"
#include "tests/places.h"

// Files of other programs: the smallest inputs of the kinds that were once read wrongly, and files built
// here.

namespace gelenk {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using nlohmann::json;
using ::testing::HasSubstr;

const std::string inputs = testing::inputFolder() + "/";

std::string base64(const std::string& bytes) {
  static const char* letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned block = 0;
    for (std::size_t k = 0; k < 3; ++k)
      block = block << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0);
    for (std::size_t k = 0; k < 4; ++k)
      out += k <= bytes.size() - i ? letters[block >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

/// A glTF in the making: nodes and the like are JSON, numbers go to one buffer.
struct Builder {
  json root{{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", {{{"nodes", {0}}}}}};
  std::string bytes;

  template <class T>
  int accessor(const std::vector<T>& values, const std::string& type, int componentType, int components) {
    while (bytes.size() % 4) bytes += '\0';
    root["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", values.size() * sizeof(T)}});
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    root["accessors"].push_back({{"bufferView", root["bufferViews"].size() - 1},
                                 {"componentType", componentType},
                                 {"count", values.size() / components},
                                 {"type", type}});
    return static_cast<int>(root["accessors"].size()) - 1;
  }
  int scalars(const std::vector<float>& v) { return accessor(v, "SCALAR", 5126, 1); }
  int vectors(const std::vector<float>& v) { return accessor(v, "VEC3", 5126, 3); }
  int quaternions(const std::vector<float>& v) { return accessor(v, "VEC4", 5126, 4); }
  int indices(const std::vector<std::uint16_t>& v) { return accessor(v, "SCALAR", 5123, 1); }

  std::string text() {
    if (!bytes.empty())
      root["buffers"] = json::array(
          {{{"byteLength", bytes.size()}, {"uri", "data:application/octet-stream;base64," + base64(bytes)}}});
    return root.dump();
  }
  GltfModel read(const GltfOptions& options = {}) { return parseGltf(text(), "test.gltf", "", options); }
};

Vector3d tipAt(const GltfModel& model, int frame) {
  return forwardKinematics(model.skeleton, model.clips.at(0).clip.q.col(frame)).back().translation();
}

TEST(GltfAnimation, StepsHoldTheirKeyAtEveryRate) {
  // Keys at 0, 0.5, 1 s; appendix C of glTF 2.0: a key holds until the next one.
  const Vector3d first(0, 1, 0);
  const GltfModel keys = readGltf(inputs + "step.gltf", {.framesPerSecond = 2.0});
  ASSERT_EQ(keys.clips.at(0).clip.frameCount(), 3);
  EXPECT_LT((tipAt(keys, 0) - first).norm(), 1e-9);
  for (const double rate : {4.0, 7.0, 20.0, 29.97, 60.0, 240.0}) {
    const GltfModel model = readGltf(inputs + "step.gltf", {.framesPerSecond = rate});
    for (int f = 0; f < model.clips[0].clip.frameCount(); ++f) {
      const int key = static_cast<int>(std::floor(f / rate / 0.5 + 1e-6));
      EXPECT_LT((tipAt(model, f) - tipAt(keys, std::min(key, 2))).norm(), 1e-9) << rate << " Hz, frame " << f;
    }
  }
  const GltfModel plain = readGltf(inputs + "step.gltf");
  EXPECT_EQ(plain.clips[0].clip.framesPerSecond, 60.0);
  ASSERT_EQ(plain.notes.size(), 1u);
  EXPECT_EQ(plain.notes[0].kind, "resampled");
  EXPECT_LT((tipAt(plain, 15) - first).norm(), 1e-9);  // t = 0.25
}

TEST(GltfAnimation, CubicSplinesAreHermiteSplinesOfTheQuaternionsComponents) {
  const GltfModel model = readGltf(inputs + "cubic.gltf", {.framesPerSecond = 20.0});
  const auto expectTip = [&](int frame, double x, double y) {
    EXPECT_LT((tipAt(model, frame) - Vector3d(x, y, 0)).norm(), 2e-6) << frame << ": " << tipAt(model, frame);
  };
  expectTip(5, -0.913793, 0.406181);
  expectTip(10, -0.998607, -0.052773);
  expectTip(15, -0.997158, -0.075338);
}

/// The motion as the specification defines it, evaluated here by its own words.
Eigen::VectorXd evaluated(const std::string& kind, const std::vector<float>& times,
                          const std::vector<float>& values, int n, double t) {
  const int stride = kind == "CUBICSPLINE" ? 3 * n : n, middle = kind == "CUBICSPLINE" ? n : 0;
  const auto part = [&](std::size_t key, int offset) {
    return Eigen::VectorXf::Map(&values[key * stride + offset], n).cast<double>().eval();
  };
  if (t <= times.front()) return part(0, middle);
  if (t >= times.back()) return part(times.size() - 1, middle);
  std::size_t k = 0;
  while (times[k + 1] <= t) ++k;
  const double span = static_cast<double>(times[k + 1]) - times[k], s = (t - times[k]) / span;
  if (kind == "STEP") return part(k, 0);
  if (kind == "CUBICSPLINE")
    return (2 * s * s * s - 3 * s * s + 1) * part(k, n) +
           span * (s * s * s - 2 * s * s + s) * part(k, 2 * n) +
           (3 * s * s - 2 * s * s * s) * part(k + 1, n) + span * (s * s * s - s * s) * part(k + 1, 0);
  Eigen::VectorXd a = part(k, 0), b = part(k + 1, 0);
  if (n == 3) return (1 - s) * a + s * b;
  if (a.dot(b) < 0) b = -b;
  const double angle = std::acos(std::min(1.0, a.dot(b)));
  return angle < 1e-6 ? a
                      : ((std::sin((1 - s) * angle) * a + std::sin(s * angle) * b) / std::sin(angle)).eval();
}

TEST(GltfAnimation, EveryInterpolationOfEveryPathIsExactAtEveryRate) {
  std::mt19937_64 random(11);
  for (const std::string kind : {"LINEAR", "STEP", "CUBICSPLINE"})
    for (const bool evenly : {true, false})
      for (const std::string path : {"rotation", "translation"}) {
        const int n = path == "rotation" ? 4 : 3;
        std::vector<float> times, values;
        for (int k = 0; k < 6; ++k) {
          times.push_back(static_cast<float>(
              evenly ? 0.2 + 0.3 * k : (k ? times.back() + 0.05 + 0.4 * uniform01(random) : 0.2)));
          for (int part = 0; part < (kind == "CUBICSPLINE" ? 3 : 1); ++part) {
            const Quaterniond q = expRotation(3.0 * uniform01(random) * gelenk::testing::randomUnit(random));
            Eigen::Vector4d v(q.x(), q.y(), q.z(), q.w());
            if (kind == "CUBICSPLINE" && part != 1) v *= 2.0;
            for (int c = 0; c < n; ++c) values.push_back(static_cast<float>(v[c]));
          }
        }
        Builder file;
        file.root["nodes"] = {{{"name", "a"}, {"children", {1}}, {"translation", {0.5, 0, 0}}},
                              {{"name", "b"}, {"rotation", {0, 0, 0.6, 0.8}}, {"children", {2}}},
                              {{"name", "tip"}, {"translation", {0, 1, 0.5}}}};
        const int input = file.scalars(times),
                  output = n == 4 ? file.quaternions(values) : file.vectors(values);
        file.root["animations"] = {
            {{"samplers", {{{"input", input}, {"output", output}, {"interpolation", kind}}}},
             {"channels", {{{"sampler", 0}, {"target", {{"node", 1}, {"path", path}}}}}}}};
        for (const double rate : {0.0, 13.0, 60.0, 97.3}) {
          GltfOptions options;
          if (rate > 0.0) options.framesPerSecond = rate;
          const GltfModel model = file.read(options);
          const MotionClip& clip = model.clips.at(0).clip;
          for (int f = 0; f < clip.frameCount(); ++f) {
            double t = times[0] + f / clip.framesPerSecond;
            if (kind == "STEP")  // a frame may miss its key by rounding
              for (const float key : times)
                if (std::abs(key - t) < 1e-6) t = key;
            const Eigen::VectorXd v = evaluated(kind, times, values, n, t);
            Eigen::Isometry3d local = Eigen::Isometry3d::Identity();
            local.linear() = n == 4 ? Quaterniond(v[3], v[0], v[1], v[2]).normalized().toRotationMatrix()
                                    : Quaterniond(0.8, 0, 0, 0.6).toRotationMatrix();
            if (n == 3) local.translation() = v;
            const Vector3d expected = Vector3d(0.5, 0, 0) + local * Vector3d(0, 1, 0.5);
            EXPECT_LT((tipAt(model, f) - expected).norm(), 3e-6)
                << kind << " " << path << (evenly ? " even " : " uneven ") << rate << " Hz, frame " << f;
          }
        }
      }
}

TEST(GltfAnimation, SeveralClipsKeepTheirNamesAndRepeatedNamesAreToldApart) {
  const GltfModel model = readGltf(inputs + "two_clips.gltf");
  ASSERT_EQ(model.clips.size(), 2u);
  EXPECT_EQ(model.clips[0].name, "rest");
  EXPECT_EQ(model.clips[1].name, "wave");
  Builder file;
  file.root["nodes"] = {{{"name", "a"}}};
  const int input = file.scalars({0, 1}), output = file.vectors({0, 0, 0, 1, 0, 0});
  const json clip{{"name", "walk"},
                  {"samplers", {{{"input", input}, {"output", output}}}},
                  {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}};
  file.root["animations"] = {clip, clip, clip};
  const GltfModel repeated = file.read();
  ASSERT_EQ(repeated.clips.size(), 3u);
  EXPECT_EQ(repeated.clips[1].name, "walk_2");
  EXPECT_EQ(repeated.clips[2].name, "walk_3");
}

TEST(GltfBody, ABodyBelowATurnedNodeStandsAsInTheScene) {
  const GltfModel model = readGltf(inputs + "turned_root.gltf");
  ASSERT_TRUE(model.skin);
  Eigen::AlignedBox3d bounds;
  for (const Vector3d& p : model.skin->mesh.positions) bounds.extend(p);
  EXPECT_LT((bounds.min() - Vector3d(-0.1, 0, -2)).norm(), 1e-6) << bounds.min().transpose();
  EXPECT_LT((bounds.max() - Vector3d(0.1, 0, 0)).norm(), 1e-6) << bounds.max().transpose();
  const auto posed = linearBlendSkin(*model.skin, restFrames(model.skeleton)).positions;
  for (std::size_t v = 0; v < posed.size(); ++v)
    EXPECT_LT((posed[v] - model.skin->mesh.positions[v]).norm(), 1e-6);
}

TEST(GltfBody, RequiredExtensionsThatAreNotReadAreNamed) {
  const auto message = [](const std::function<void()>& read) -> std::string {
    try {
      read();
    } catch (const ParseError& error) {
      return error.what();
    }
    return "read";
  };
  EXPECT_THAT(message([] { readGltf(inputs + "draco_required.gltf"); }),
              HasSubstr("needs KHR_draco_mesh_compression, which is not read"));
  for (const char* name : {"EXT_meshopt_compression", "EXT_mesh_gpu_instancing", "VENDOR_new"}) {
    Builder file;
    file.root["nodes"] = {{{"name", "a"}}};
    file.root["extensionsRequired"] = {name};
    EXPECT_THAT(message([&] { file.read(); }), HasSubstr(std::string("needs ") + name));
  }
  for (const auto& [name, isRead] : {std::pair{"KHR_texture_transform", false},
                                     {"KHR_texture_basisu", false},
                                     {"KHR_materials_unlit", false},
                                     {"KHR_lights_punctual", false},
                                     {"KHR_mesh_quantization", true}}) {
    Builder file;
    file.root["nodes"] = {{{"name", "a"}}};
    file.root["extensionsRequired"] = {name};
    EXPECT_EQ(message([&] { file.read(); }), "read") << name;
    const std::vector<Note> notes = file.read().notes;
    ASSERT_EQ(notes.size(), isRead ? 0u : 1u) << name;
    if (isRead) continue;
    EXPECT_EQ(notes[0].kind, "extension-unread");
    EXPECT_FALSE(notes[0].fact);
    EXPECT_THAT(notes[0].text, HasSubstr(name));
  }
}

TEST(GltfBody, StripsAndFansAreTheSameTrianglesAsLists) {
  // Five points of a pentagon in the plane z = 0, counter-clockwise.
  std::vector<float> points;
  for (int k = 0; k < 5; ++k)
    for (const double c : {std::cos(2 * M_PI * k / 5), std::sin(2 * M_PI * k / 5), 0.0})
      points.push_back(static_cast<float>(c));
  const double area = 2.5 * std::sin(2 * M_PI / 5);
  const auto read = [&](int mode, const std::vector<std::uint16_t>& order) {
    Builder file;
    const int positions = file.vectors(points);
    json primitive{{"attributes", {{"POSITION", positions}}}, {"mode", mode}};
    if (!order.empty()) primitive["indices"] = file.indices(order);
    file.root["meshes"] = {{{"primitives", {primitive}}}};
    file.root["nodes"] = {{{"name", "a"}, {"mesh", 0}}};
    return file.read().skin->mesh;
  };
  for (const auto& [mode, order] : std::vector<std::pair<int, std::vector<std::uint16_t>>>{
           {4, {0, 1, 2, 0, 2, 3, 0, 3, 4}},
           {5, {0, 1, 4, 2, 3}},
           {5, {0, 1, 4, 2, 2, 2, 2, 3, 4}},  // joined by triangles without area
           {6, {0, 1, 2, 3, 4}},
           {6, {}}}) {
    const Mesh mesh = read(mode, order);
    double sum = 0.0;
    for (const auto& [a, b, c] : mesh.triangles) {
      const double z =
          (mesh.positions[b] - mesh.positions[a]).cross(mesh.positions[c] - mesh.positions[a]).z();
      EXPECT_GT(z, 0.0) << "mode " << mode;
      sum += 0.5 * z;
    }
    EXPECT_NEAR(sum, area, 1e-6) << "mode " << mode << ", " << order.size() << " indices";
  }
}

TEST(GltfBody, VerticesWithoutWeightsAreHeldByTheFirstJointAndTold) {
  const GltfModel model = readGltf(inputs + "zero_weight.gltf");
  ASSERT_TRUE(model.skin);
  EXPECT_EQ(model.skin->influences[0].weights[0], 1.0);
  ASSERT_EQ(model.notes.size(), 1u);
  EXPECT_EQ(model.notes[0].kind, "weightless-vertices");
}

const std::vector<float> corner{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};

Builder scaledPart(const json& scale, const json& childRotation) {
  Builder file;
  const int positions = file.vectors(corner), faces = file.indices({0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3});
  file.root["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", positions}}}, {"indices", faces}}}}}};
  file.root["nodes"] = {
      {{"name", "a"}, {"scale", scale}, {"rotation", {0, 0, 0.6, 0.8}}, {"children", {1}}},
      {{"name", "b"}, {"translation", {1, 2, 3}}, {"rotation", childRotation}, {"mesh", 0}}};
  return file;
}

TEST(GltfBody, UnequalScalesAndMirrorsOfRigidPartsAreKept) {
  for (const Vector3d& scale :
       {Vector3d(1, 2, 3), Vector3d(-1, 1, 1), Vector3d(2, -0.5, 1), Vector3d(1, 1, 0)}) {
    const Quaterniond turn = Quaterniond(0.5, 0.5, 0.5, 0.5), own(0.8, 0, 0, 0.6);
    const GltfModel model =
        scaledPart({scale.x(), scale.y(), scale.z()}, {turn.x(), turn.y(), turn.z(), turn.w()}).read();
    ASSERT_TRUE(model.skin);
    const Mesh& mesh = model.skin->mesh;
    for (int v = 0; v < 4; ++v) {
      const Vector3d p(corner[3 * v], corner[3 * v + 1], corner[3 * v + 2]);
      const Vector3d expected = own * scale.cwiseProduct(turn * p + Vector3d(1, 2, 3));
      EXPECT_LT((mesh.positions[v] - expected).norm(), 1e-6) << scale.transpose() << ", vertex " << v;
    }
    if (scale.prod() != 0.0) {
      EXPECT_NEAR(enclosedVolume(mesh), std::abs(scale.prod()) / 6.0, 1e-6);
    }
  }
  Builder moving = scaledPart({1, 2, 3}, {0, 0, 0, 1});
  const int input = moving.scalars({0, 1}), output = moving.quaternions({0, 0, 0, 1, 0, 0, 1, 0});
  moving.root["animations"] = {
      {{"samplers", {{{"input", input}, {"output", output}}}},
       {"channels", {{{"sampler", 0}, {"target", {{"node", 1}, {"path", "rotation"}}}}}}}};
  EXPECT_THROW(moving.read(), ParseError);  // would shear
}

TEST(GltfBody, SparseAccessorsReplaceSingleElements) {
  Builder file;
  const int positions = file.vectors(corner), at = file.indices({1}), to = file.vectors({5, 6, 7});
  file.root["accessors"][positions]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", file.root["accessors"][at]["bufferView"]}, {"componentType", 5123}}},
      {"values", {{"bufferView", file.root["accessors"][to]["bufferView"]}}}};
  file.root["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", positions}}}, {"mode", 6}}}}}};
  file.root["nodes"] = {{{"name", "a"}, {"mesh", 0}}};
  const GltfModel model = file.read();
  EXPECT_EQ(model.skin->mesh.positions[1], Vector3d(5, 6, 7));
  EXPECT_EQ(model.skin->mesh.positions[2], Vector3d(0, 1, 0));
}

}  // namespace
}  // namespace gelenk
