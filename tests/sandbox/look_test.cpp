// Models as their makers made them: colours of URDF, glTF and OBJ, from the file to the picture.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>

#include "apps/commands/image.h"
#include "apps/document/model_files.h"
#include "apps/document/scene_file.h"
#include "apps/render/renderer.h"
#include "apps/render/scene_view.h"
#include "kinematics/io/text_file.h"
#include "skinning/bodies/robot_body.h"
#include "skinning/gpu/offscreen_context.h"
#include "skinning/gpu/render_target.h"
#include "skinning/io/collada.h"
#include "skinning/io/obj.h"
#include "tests/places.h"

namespace gelenk {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3f;

struct Folder {
  fs::path path = fs::temp_directory_path() / ("gelenk_look_" + std::to_string(getpid()));
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
  std::string write(const std::string& name, const std::string& text) const {
    writeFile((path / name).string(), text);
    return (path / name).string();
  }
};

std::string base64(const std::vector<std::uint8_t>& bytes) {
  static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned v = 0;
    for (std::size_t k = 0; k < 3; ++k) v = v << 8 | (i + k < bytes.size() ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k) out += i + k > bytes.size() ? '=' : digits[v >> (18 - 6 * k) & 63];
  }
  return out;
}

/// Mean colour of the pixels that differ from an empty picture, and how many they are.
struct Seen {
  Vector3f mean = Vector3f::Zero();
  int pixels = 0;
};
Seen seen(const Model& model, std::set<std::string> hidden = {}) {
  const OffscreenContext context;
  auto shared = std::make_shared<const Model>(model);
  Session session(shared, ModelReference{.nameOrFile = model.name});
  session.view().show.ground = session.view().show.shadow = session.view().show.handles = false;
  session.view().hidden = std::move(hidden);
  SceneView view(session);
  view.follow(session, session.frames(), true);
  const Viewport viewport{120, 90};
  session.view().camera = view.wholeView(session, viewport, view.bounds());
  Renderer renderer;
  RenderTarget target(viewport.width, viewport.height);
  const auto draw = [&] {
    renderer.draw(view.compose(session), session.view().camera, viewport, target.framebuffer());
    return target.readPixels();
  };
  const auto with = draw();
  session.view().show.skin = false;
  session.view().show.skeleton = false;
  const auto without = draw();
  Seen result;
  for (std::size_t p = 0; p < with.size(); p += 4)
    if (std::memcmp(&with[p], &without[p], 3) != 0) {
      ++result.pixels;
      for (int k = 0; k < 3; ++k) result.mean[k] += with[p + k] / 255.0f;
    }
  if (result.pixels > 0) result.mean /= static_cast<float>(result.pixels);
  return result;
}

const char* paintedRobot = R"(<robot name="two boxes">
  <material name="blue"><color rgba="0.1 0.2 0.9 1"/></material>
  <link name="base"><visual><geometry><box size="0.4 0.4 0.4"/></geometry>
    <material name="red"><color rgba="0.9 0.1 0.1 1"/></material></visual></link>
  <link name="arm"><visual><origin xyz="0 0 0.5"/><geometry><box size="0.2 0.2 0.6"/></geometry>
    <material name="blue"/></visual></link>
  <link name="plain"><visual><origin xyz="0 0 0.5"/><geometry><box size="0.1 0.1 0.2"/></geometry></visual></link>
  <joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0 0.2"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="end" type="fixed"><parent link="arm"/><child link="plain"/><origin xyz="0 0 0.8"/></joint>
</robot>)";

TEST(Looks, AUrdfsColoursAndItsNameAreItsOwn) {
  const Folder folder;
  const Model model = openModelFile(folder.write("file_name.urdf", paintedRobot));
  EXPECT_EQ(model.name, "two boxes");
  ASSERT_TRUE(model.look);
  ASSERT_EQ(model.look->parts.size(), 3u);
  const auto colourOf = [&](int part) {
    return Vector3f(model.look->materials[model.look->parts[part].material].colour.head<3>());
  };
  EXPECT_LT((colourOf(0) - linearFromSrgb(Vector3f(0.9f, 0.1f, 0.1f))).norm(), 1e-6f);
  EXPECT_LT((colourOf(1) - linearFromSrgb(Vector3f(0.1f, 0.2f, 0.9f))).norm(), 1e-6f);
  const Vector3f plain = colourOf(2);  // a grey, no skin
  EXPECT_LT(plain.maxCoeff() - plain.minCoeff(), 0.06f);

  const Seen all = seen(model), redOnly = seen(model, {"turn", "end"}),
             blueOnly = seen(model, {"base", "end"});
  EXPECT_GT(redOnly.mean.x(), 1.6f * redOnly.mean.z());
  EXPECT_GT(blueOnly.mean.z(), 1.6f * blueOnly.mean.x());
  EXPECT_GT(redOnly.pixels, 100);
  EXPECT_LT(redOnly.pixels, all.pixels);
}

TEST(Looks, AColourThatIsNoneIsToldAndPassedOver) {
  const Folder folder;
  std::string text = paintedRobot;
  text.replace(text.find("0.9 0.1 0.1 1"), 13, "red, please");
  const Model model = openModelFile(folder.write("robot.urdf", text));
  EXPECT_TRUE(
      std::ranges::any_of(model.notes, [](const Note& note) { return note.kind == "material-colour"; }));
}

TEST(Looks, MissingMeshesAreOneLine) {
  const Folder folder;
  std::string links, joints;
  for (int i = 0; i < 9; ++i) {
    links += "<link name=\"l" + std::to_string(i) + "\"><visual><geometry><mesh filename=\"none" +
             std::to_string(i) + ".dae\"/></geometry></visual></link>";
    if (i > 0)
      joints += "<joint name=\"j" + std::to_string(i) + "\" type=\"continuous\"><parent link=\"l" +
                std::to_string(i - 1) + "\"/><child link=\"l" + std::to_string(i) +
                "\"/><origin xyz=\"0 0 0.1\"/><axis xyz=\"0 1 0\"/></joint>";
  }
  const Model model =
      openModelFile(folder.write("r.urdf", "<robot name=\"r\">" + links + joints + "</robot>"));
  int notes = 0;
  for (const Note& note : model.notes)
    if (note.kind == "mesh-missing") {
      ++notes;
      EXPECT_EQ(note.count, 9);
      EXPECT_NE(note.line().find("none0.dae"), std::string::npos) << note.line();
    }
  EXPECT_EQ(notes, 1);
}

/// Two squares, one with coordinates of a texture and an alpha cut-out, one with a factor and vertex colours.
std::string paintedGltf() {
  std::vector<std::uint8_t> bytes;
  const auto put = [&](std::initializer_list<float> values) {
    const std::size_t at = bytes.size();
    bytes.resize(at + 4 * values.size());
    std::memcpy(&bytes[at], values.begin(), 4 * values.size());
    return at;
  };
  put({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});                              // 0: positions, 48 bytes
  put({0, 1, 1, 1, 1, 0, 0, 0});                                          // 48: texture coordinates, 32
  put({1, 0.5f, 0.25f, 1, 0.5f, 0.25f, 1, 0.5f, 0.25f, 1, 0.5f, 0.25f});  // 80: colours, 48
  for (const unsigned short index : {0, 1, 2, 0, 2, 3}) {                 // 128: 12
    bytes.push_back(index & 255);
    bytes.push_back(index >> 8);
  }
  return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
    "nodes": [{"mesh": 0, "name": "cloth"}, {"mesh": 1, "name": "shield", "translation": [2, 0, 0]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 3, "material": 0}]},
               {"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 2}, "indices": 3, "material": 1}]}],
    "materials": [
      {"name": "cloth", "alphaMode": "MASK", "alphaCutoff": 0.5, "doubleSided": true,
       "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1]}},
      {"name": "shield", "pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.4, 0.2, 1], "roughnessFactor": 0.5}}],
    "buffers": [{"byteLength": 140, "uri": "data:application/octet-stream;base64,)" +
         base64(bytes) + R"("}],
    "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 32},
                    {"buffer": 0, "byteOffset": 80, "byteLength": 48}, {"buffer": 0, "byteOffset": 128, "byteLength": 12}],
    "accessors": [
      {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
      {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
      {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC3"},
      {"bufferView": 3, "componentType": 5123, "count": 6, "type": "SCALAR"}]})";
}

TEST(Looks, AGltfsFactorsVertexColoursAndSidesAreRead) {
  const Folder folder;
  const Model model = openModelFile(folder.write("two.gltf", paintedGltf()));
  ASSERT_TRUE(model.look);
  const MeshLook& look = *model.look;
  ASSERT_EQ(look.parts.size(), 2u);
  EXPECT_EQ(look.parts[0].name, "cloth");
  EXPECT_EQ(look.parts[1].name, "shield");
  const Material &cloth = look.materials[look.parts[0].material],
                 &shield = look.materials[look.parts[1].material];
  EXPECT_EQ(cloth.cutOff, 0.5f);
  EXPECT_TRUE(cloth.doubleSided);
  EXPECT_FALSE(shield.doubleSided);
  EXPECT_EQ(shield.cutOff, 0.0f);
  EXPECT_FLOAT_EQ(shield.colour.x(), 0.8f);
  EXPECT_FLOAT_EQ(shield.colour.z(), 0.2f);
  ASSERT_EQ(look.colours.size(), 8u);
  EXPECT_EQ(look.colours[0], Vector3f::Ones());
  EXPECT_EQ(look.colours[4], Vector3f(1.0f, 0.5f, 0.25f));
  ASSERT_EQ(look.coordinates.size(), 8u);
  EXPECT_EQ(look.coordinates[2], Eigen::Vector2f(1.0f, 0.0f));
}

/// A texture covers the surface as its coordinates say, and where it is clear nothing is drawn.
TEST(Looks, ATextureIsSeenAndItsClearPartIsNot) {
  Mesh mesh{.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
            .triangles = {{0, 1, 2}, {0, 2, 3}},
            .normals = {}};
  Model model{.name = "square", .skeleton = Skeleton({Joint{.name = "root", .parent = -1}})};
  model.skin = bindSkin(mesh, restFrames(model.skeleton), std::vector<Influences>(4));
  Texture texture{.width = 2, .height = 1, .rgba = {0, 200, 0, 255, 0, 0, 200, 0}};
  MeshLook look{.materials = {{.texture = 0, .cutOff = 0.5f}},
                .textures = {std::make_shared<const Texture>(texture)},
                .parts = {{.triangleCount = 2}},
                .coordinates = {{0, 1}, {1, 1}, {1, 0}, {0, 0}}};
  model.look = std::make_shared<const MeshLook>(look);
  const Seen cut = seen(model);
  look.materials[0].cutOff = 0.0f;
  model.look = std::make_shared<const MeshLook>(look);
  const Seen whole = seen(model);
  look.materials[0].texture = -1;
  model.look = std::make_shared<const MeshLook>(look);
  const Seen white = seen(model);
  EXPECT_GT(cut.mean.y(), 1.5f * cut.mean.z());
  EXPECT_NEAR(cut.pixels, 0.5 * whole.pixels, 0.12 * whole.pixels);
  EXPECT_EQ(white.pixels, whole.pixels);
  EXPECT_GT(whole.mean.z(), 0.6f * whole.mean.y());
  EXPECT_LT(white.mean.maxCoeff() - white.mean.minCoeff(), 0.25f);
}

TEST(Looks, PartsThatDoNotCoverTheMeshAreRefused) {
  MeshLook look{.materials = {{}}, .parts = {{.triangleCount = 2}}};
  EXPECT_NO_THROW(validate(look, 4, 2));
  EXPECT_THROW(validate(look, 4, 3), std::invalid_argument);
  look.parts[0].material = 1;
  EXPECT_THROW(validate(look, 4, 2), std::invalid_argument);
  look.parts[0].material = 0;
  look.colours.resize(3);
  EXPECT_THROW(validate(look, 4, 2), std::invalid_argument);
}

TEST(Looks, AnObjTakesTheColoursOfItsMtl) {
  const Folder folder;
  folder.write("a.mtl", "newmtl skin\nKd 0.8 0.5 0.4\nnewmtl cloth\nKd 0.1 0.1 0.6\n");
  const std::string obj = folder.write("a.obj",
                                       "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 2 0\n"
                                       "usemtl skin\nf 1 2 3 4\nusemtl cloth\nf 4 3 5\n");
  const Mesh mesh = readMesh(obj);
  const auto look = readObjLook(obj, mesh);
  ASSERT_TRUE(look);
  EXPECT_NO_THROW(validate(look->look, 5, 3));
  ASSERT_EQ(look->look.parts.size(), 2u);
  EXPECT_EQ(look->look.parts[0].triangleCount, 2);
  EXPECT_NEAR(look->look.materials[look->look.parts[1].material].colour.z(), linearFromSrgb(0.6f), 1e-6);
  EXPECT_TRUE(look->copyOf.empty());
  EXPECT_FALSE(readObjLook(folder.write("b.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n"), mesh));
}

/// Two squares that share an edge; one shows the picture's left half, which is red, the other its right,
/// blue.
TEST(Looks, AnObjIsCutWhereItsTextureIsAndKeepsItsVerticesNumbers) {
  const Folder folder;
  writePng((folder.path / "two colours.png").string(), {2, 1, {255, 0, 0, 255, 0, 0, 255, 255}});
  folder.write("a.mtl", "newmtl paint\nKd 0 0 0\nmap_Kd -s 1 1 1 -clamp on textures\\two colours.png\n");
  const std::string obj =
      folder.write("a.obj",
                   "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\n"
                   "vt 0.25 0.5\nvt 0.75 0.5\nusemtl paint\nf 1/1 2/1 3/1 4/1\nf 2/-1 5/2 6/2 3/-1\n");
  Mesh mesh = readMesh(obj);
  const auto look = readObjLook(obj, mesh);
  ASSERT_TRUE(look);
  EXPECT_EQ(look->copyOf, (std::vector<int>{1, 2}));  // the shared edge
  const auto before = mesh.positions;
  cutSurface(*look, mesh);
  EXPECT_NO_THROW(validate(look->look, 8, 4));
  EXPECT_TRUE(std::equal(before.begin(), before.end(), mesh.positions.begin()));
  for (std::size_t t = 0; t < 4; ++t)
    for (const int v : mesh.triangles[t]) EXPECT_EQ(look->look.coordinates[v].x(), t < 2 ? 0.25f : 0.75f);
  for (const auto& normal : mesh.normals) EXPECT_EQ(normal, Eigen::Vector3d::UnitZ());

  Model model{.name = "squares", .skeleton = Skeleton({Joint{.name = "root"}})};
  model.skin = bindSkin(mesh, restFrames(model.skeleton), std::vector<Influences>(8));
  model.look = std::make_shared<const MeshLook>(look->look);
  const Vector3f mean = seen(model).mean;  // half of each: red and blue, hardly any green
  EXPECT_GT(std::min(mean.x(), mean.z()), 0.25f);
  EXPECT_LT(mean.y(), 0.6f * mean.x());

  fs::remove(folder.path / "two colours.png");
  std::vector<Note> notes;
  readObjLook(obj, readMesh(obj), &notes);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes[0].kind, "texture-missing");
}

const char* texturedSquare =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\nf 1/1 4/4 3/3 "
    "2/2\n";

/// Its mesh has texture coordinates but no .mtl; the box has none.
TEST(Looks, AUrdfsOwnTextureLiesOnAMeshWithCoordinates) {
  const Folder folder;
  fs::create_directories(folder.path / "robot/textures");
  writePng((folder.path / "robot/textures/red.png").string(), {1, 1, {255, 0, 0, 255}});
  folder.write("robot/square.obj", texturedSquare);
  const std::string urdf = folder.write("robot/r.urdf", R"(<robot name="r">
  <material name="paint"><texture filename="package://robot/textures/red.png"/></material>
  <link name="a"><visual><geometry><mesh filename="square.obj"/></geometry><material name="paint"/></visual></link>
  <link name="b"><visual><geometry><box size="0.1 0.1 0.1"/></geometry><material name="paint"/></visual></link>
  <link name="c"><visual><geometry><mesh filename="square.obj"/></geometry>
    <material name="none"><color rgba="0 0 1 1"/><texture filename="gone.png"/></material></visual></link>
  <joint name="b" type="fixed"><parent link="a"/><child link="b"/></joint>
  <joint name="c" type="fixed"><parent link="a"/><child link="c"/></joint></robot>)");
  const Model model = openModelFile(urdf);
  ASSERT_TRUE(model.look);
  EXPECT_NO_THROW(validate(*model.look, static_cast<int>(model.skin->mesh.positions.size()),
                           static_cast<int>(model.skin->mesh.triangles.size())));
  ASSERT_EQ(model.look->textures.size(), 1u);
  const auto materialOf = [&](int part) { return model.look->materials[model.look->parts[part].material]; };
  EXPECT_EQ(materialOf(0).texture, 0);
  EXPECT_EQ(materialOf(1).texture, -1);
  EXPECT_EQ(materialOf(2).texture, -1);
  EXPECT_EQ(materialOf(2).colour.z(), 1.0f);
  const auto notes = [&](const std::string& kind) {
    return std::ranges::count(model.notes, kind, &Note::kind);
  };
  EXPECT_EQ(notes("texture-unmapped"), 1);
  EXPECT_EQ(notes("texture-missing"), 1);
  const Seen red = seen(model, {"b", "c"});
  EXPECT_GT(red.pixels, 100);
  EXPECT_GT(red.mean.x(), 2.0f * red.mean.y());
}

/// A square whose halves have other texture coordinates on their common edge, without normals of its own: the
/// light knows no seam there.
TEST(Looks, ACutForATextureIsNoCrease) {
  const Folder folder;
  writePng((folder.path / "a.png").string(), {1, 1, {9, 9, 9, 255}});
  folder.write("a.obj",
               "v 0 0 0\nv 1 0 0.1\nv 1 1 0.1\nv 0 1 0\nv 2 0 0\nv 2 1 0\nvt 0.2 0.5\nvt 0.8 0.5\n"
               "f 1/1 2/1 3/1 4/1\nf 2/2 5/2 6/2 3/2\n");
  const Model model = openModelFile(folder.write(
      "r.urdf",
      "<robot name=\"r\"><link name=\"a\"><visual><geometry><mesh filename=\"a.obj\"/></geometry>"
      "<material name=\"m\"><texture filename=\"a.png\"/></material></visual></link></robot>"));
  const Mesh& mesh = model.skin->mesh;
  ASSERT_EQ(mesh.positions.size(), 8u);
  for (std::size_t a = 0; a < 8; ++a)
    for (std::size_t b = 0; b < a; ++b)
      if (mesh.positions[a] == mesh.positions[b]) {
        EXPECT_NE(model.look->coordinates[a], model.look->coordinates[b]);
        EXPECT_EQ(mesh.normals[a], mesh.normals[b]);
      }
}

/// Written, moved to another folder, read again: the same colours, the same picture's file or its pixels.
TEST(Looks, AnObjIsWrittenWithItsMaterials) {
  const Folder folder;
  fs::create_directories(folder.path / "other");
  writePng((folder.path / "red green.png").string(), {2, 1, {255, 0, 0, 255, 0, 255, 0, 255}});
  folder.write("a.mtl", "newmtl a\nKd 0.25 0.5 0.75\nnewmtl b\nmap_Kd red green.png\n");
  const std::string obj = folder.write(
      "a.obj", std::string("mtllib a.mtl\nusemtl b\n") + texturedSquare + "v 0 0 1\nusemtl a\nf 1 2 5\n");
  Mesh mesh = readMesh(obj);
  auto look = readObjLook(obj, mesh);
  ASSERT_TRUE(look);
  cutSurface(*look, mesh);
  const Texture clear{.width = 1, .height = 1, .rgba = {1, 2, 3, 4}};
  look->look.textures.push_back(std::make_shared<const Texture>(clear));
  look->look.materials.push_back({.name = "a", .texture = 1});  // a name that is taken
  look->look.parts.push_back({.firstTriangle = 5, .triangleCount = 1, .material = 3});
  mesh.triangles.push_back({0, 1, 4});
  const std::string out = (folder.path / "other/b.obj").string();
  writeObjWithLook(out, mesh, look->look);

  const Mesh again = readMesh(out);
  EXPECT_EQ(again.positions, mesh.positions);
  EXPECT_EQ(again.triangles, mesh.triangles);
  const auto read = readObjLook(out, again);
  ASSERT_TRUE(read);
  EXPECT_TRUE(read->copyOf.empty());
  EXPECT_EQ(read->normals, mesh.normals);
  EXPECT_EQ(read->look.coordinates, look->look.coordinates);
  ASSERT_EQ(read->look.parts.size(), 3u);
  const auto textureOf = [&](int part) {
    return read->look.textures[read->look.materials[read->look.parts[part].material].texture];
  };
  EXPECT_EQ(fs::canonical(textureOf(0)->file), fs::canonical(folder.path / "red green.png"));
  const Eigen::Vector4f colour = read->look.materials[read->look.parts[1].material].colour;
  EXPECT_NEAR(colour.y(), linearFromSrgb(0.5f), 1e-6);
  EXPECT_EQ(textureOf(2)->rgba, clear.rgba);
  EXPECT_EQ(textureOf(2)->file, (folder.path / "other/b_2.png").string());
}

/// The same picture on a Collada mesh, which comes with its own normals.
TEST(Looks, AColladaMeshTakesItsTextureAndItsNormals) {
  if (!readsCollada()) GTEST_SKIP() << "built without Assimp";
  const Folder folder;
  writePng((folder.path / "red.png").string(), {1, 1, {255, 0, 0, 255}});
  const auto source = [](const std::string& id, const std::string& numbers, int stride) {
    std::string text = "<source id=\"" + id + "\"><float_array id=\"" + id + "-a\" count=\"" +
                       std::to_string(3 * stride) + "\">" + numbers +
                       "</float_array><technique_common><accessor source=\"#" + id +
                       "-a\" count=\"3\" stride=\"" + std::to_string(stride) + "\">";
    for (int k = 0; k < stride; ++k)
      text += std::string("<param name=\"") + (stride == 2 ? "ST" : "XYZ")[k] + "\" type=\"float\"/>";
    return text + "</accessor></technique_common></source>";
  };
  const std::string dae = folder.write(
      "a.dae",
      R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><unit meter="1"/><up_axis>Z_UP</up_axis></asset>
<library_images><image id="i"><init_from>red.png</init_from></image></library_images>
<library_effects><effect id="e"><profile_COMMON><newparam sid="s"><surface type="2D"><init_from>i</init_from></surface></newparam>
<newparam sid="t"><sampler2D><source>s</source></sampler2D></newparam><technique sid="c"><lambert><diffuse><texture texture="t" texcoord="uv"/></diffuse></lambert></technique></profile_COMMON></effect></library_effects>
<library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh>)" +
          source("p", "0 0 0 1 0 0 0 1 0", 3) + source("n", "0 0.6 0.8 0 0.6 0.8 0 0.6 0.8", 3) +
          source("u", "0 0 1 0 0 1", 2) +
          R"(<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles material="x" count="1"><input semantic="VERTEX" source="#v" offset="0"/>
<input semantic="NORMAL" source="#n" offset="0"/><input semantic="TEXCOORD" source="#u" offset="0" set="0"/><p>0 1 2</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="w"><node><instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="x" target="#m"/></technique_common></bind_material></instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#w"/></scene></COLLADA>)");
  MeshLook look;
  const Mesh mesh = readCollada(dae, &look);
  ASSERT_EQ(mesh.normals.size(), 3u);
  EXPECT_NEAR((mesh.normals[0] - Eigen::Vector3d(0, 0.6, 0.8)).norm(), 0.0, 1e-6);
  ASSERT_EQ(look.textures.size(), 1u);
  EXPECT_EQ(look.textures[0]->rgba, (std::vector<std::uint8_t>{255, 0, 0, 255}));
  EXPECT_EQ(look.materials[look.parts[0].material].texture, 0);
  ASSERT_EQ(look.coordinates.size(), 3u);
}

/// Every built-in robot: closed shells of three paints, rigid on its joints, none the colour of skin.
TEST(RobotBodies, AreRigidClosedAndPainted) {
  for (const std::string& name : builtInModels()) {
    if (name == "figure" || name == "planar") continue;
    const Model model = openModel(name);
    ASSERT_TRUE(model.skin && model.look) << name;
    EXPECT_NO_THROW(validate(*model.look, static_cast<int>(model.skin->mesh.positions.size()),
                             static_cast<int>(model.skin->mesh.triangles.size())));
    std::set<int> joints;
    for (const Influences& influences : model.skin->influences) {
      EXPECT_EQ(influences.weights[0], 1.0);
      joints.insert(influences.joints[0]);
    }
    EXPECT_GE(joints.size(), 4u) << name;
    EXPECT_EQ(model.look->materials.size(), 3u);
    for (const Material& material : model.look->materials) EXPECT_GT(material.gloss, 0.0f);
    // Triangles face outwards: the volume that they enclose is that of its parts, above 0.
    EXPECT_GT(enclosedVolume(model.skin->mesh), 1e-3) << name;
    const Seen picture = seen(model);
    EXPECT_GT(picture.pixels, 300) << name;
    EXPECT_LT(picture.mean.x() - picture.mean.z(), 0.16f) << name;  // grey, not skin
  }
}

TEST(Looks, HiddenPartsAreSavedWithTheScene) {
  const Folder folder;
  const std::string file = folder.write("robot.urdf", paintedRobot);
  auto model = std::make_shared<const Model>(openModelFile(file));
  Session session(model, ModelReference{.nameOrFile = file});
  session.view().hidden = {"turn"};
  const Document read = parseScene(formatScene(session.saved(), *model), "scene.json", *model);
  EXPECT_EQ(read.view.hidden, std::set<std::string>{"turn"});
}

TEST(Looks, TheTrialDatasKnightHasItsTextureItsPropsAndItsClips) {
  const std::string path = testing::dataFolder() + "/characters/kaykit/Knight.glb";
  if (!fs::exists(path)) GTEST_SKIP() << path;
  const Model model = openModelFile(path);
  ASSERT_TRUE(model.look);
  EXPECT_FALSE(model.look->textures.empty());
  EXPECT_GT(model.look->parts.size(), 5u);
  EXPECT_GT(model.clipNames.size(), 50u);
}

}  // namespace
}  // namespace gelenk
