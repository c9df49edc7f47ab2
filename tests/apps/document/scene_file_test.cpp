#include "apps/document/scene_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "apps/document/json_entry.h"
#include "apps/document/session.h"
#include "kinematics/configuration.h"
#include "kinematics/io/text_file.h"
#include "kinematics/notation/mannequin.h"
#include "tests/kinematics/io/bad_input.h"
#include "tests/places.h"
#include "tests/skinning/muscles/resting_arm.h"

namespace gelenk {
namespace {

std::string temporary(const std::string& name) {
  return (std::filesystem::temp_directory_path() / ("gelenk_scene_" + std::to_string(getpid()) + "_" + name))
      .string();
}

Model figure() {
  Model model{.name = "figure", .skeleton = mannequin()};
  model.handles = mannequinHandles();
  model.pins = {"foot_l", "foot_r"};
  return model;
}

/// The tube around a resting arm, under the names of a limb that muscles know, with a motion.
Model armModel() {
  const Skeleton plain = testing::arm(0.8);
  std::vector<Joint> joints;
  const char* names[] = {"chest", "upperarm_l", "lowerarm_l", "hand_l"};
  for (int j = 0; j < plain.jointCount(); ++j) {
    joints.push_back(plain.joint(j));
    joints.back().name = names[j];
  }
  Model model{.name = "arm", .skeleton = Skeleton(joints, plain.rest())};
  model.skin = testing::tube(plain);
  model.clip = MotionClip{.framesPerSecond = 30.0, .q = plain.rest().replicate(1, 40)};
  return model;
}

/// Every part is something that is no default and has no short decimal form.
Document armDocument(const Model& model) {
  std::mt19937_64 random(7);
  Document document = newDocument(model, {.nameOrFile = "arm", .files = {.skeleton = "s", .mapping = "m"}});
  Edits& edits = document.edits;
  edits.q = randomWithinLimits(model.skeleton, random);
  SceneGoal goal{.goal = {.kind = GoalKind::Pose, .name = "hand_l", .joint = 3},
                 .state = GoalState::Pinned,
                 .handle = true,
                 .id = GoalId{4}};
  goal.goal.target = {0.1, 1.0 / 3.0, -1e-17};
  goal.goal.orientation = Eigen::Quaterniond(0.1, 0.2, 0.3, 0.4).normalized();
  SceneGoal skin{.goal = {.name = "skin", .joint = 1},
                 .state = GoalState::Held,
                 .surface = {.triangle = 11, .barycentric = {0.1, 0.2, 0.7}},
                 .id = GoalId{9}};
  edits.goals = {goal, skin};
  for (int v = 0; v < 200; v += 3) {
    std::vector<std::pair<int, double>> row;
    for (int k = 0; k <= v % 4; ++k) row.emplace_back(k, 0.1 + 1.0 / (v + k + 3));
    edits.weights.set(v, exactInfluences(row));
  }
  edits.weights.set(201, Influences{{2, 1, 0, 0}, {2.0 / 3.0, 1.0 / 3.0, 0, 0}});
  MuscleSettings muscles = *edits.muscles;
  muscles = {.enabled = true,
             .lattice = false,
             .split = true,
             .alone = true,
             .shownLimb = "",
             .limbs = muscles.limbs};
  LimbSettings& arm = muscles.limbs[0].second;
  arm.jointGap = 0.1 + 1.0 / 30.0;
  arm.wedge = 1.0 / 7.0;
  arm.control.activation = 1.0 / 3.0;
  arm.control.keepVolume = false;
  arm.control.curves[1] = {
      .flexor = 0.1 / 3, .extensor = -0.1 / 7, .nearJoint = 1.0 / 9, .tendon = 0.3 / 7, .fullBend = 7.0 / 3};
  arm.control.sculpted.resize(2);
  arm.control.sculpted[0].plane4.stretch << 1.0 / 0.9, 0.1 / 3, 0.1 / 7, 0.7;
  arm.control.sculpted[0].plane4.offset << 0.001 / 3, -0.002 / 7;
  for (int c = 0; c < 16; ++c)
    arm.control.sculpted[1].plane2.displacement.emplace_back(0.001 * c / 7, -0.01 / (c + 1), 1e-17 * c);
  edits.muscles = std::make_shared<MuscleSettings>(muscles);
  MotionClip base = *model.clip;
  base.q(4, 7) = 1.0 / 3.0;
  ClipEdits clip{.base = std::make_shared<MotionClip>(base), .framesPerSecond = 24.0 / 1.001, .falloff = 0.1};
  Eigen::VectorXd pose = model.skeleton.rest();
  pose[4] = 1.1 / 7;
  clip.keys[2] = {{.frame = 3, .q = pose}, {.frame = 9, .q = pose}};
  clip.keys[3] = {{.frame = 3, .q = pose}};
  edits.clip = std::make_shared<ClipEdits>(clip);
  edits.seconds = 0.1 + 0.2;  // a double that has no short decimal
  document.solver = {.name = "dls",
                     .parameters = {{"dls", {{"lambda", 0.1 / 3}}}, {"sdls", {{"gamma-max", 0.1 / 0.3}}}}};
  document.view.camera.azimuth = 0.1 + 0.2;
  document.view.camera.orthographic = true;
  document.view.show.skeleton = true;
  document.view.show.handles = false;
  document.view.selectedJoint = "hand_l";
  document.theme = Theme::Dark;
  document.playback = {.speed = -0.1 / 3, .loop = false, .goalsOnTop = true, .contacts = false};
  document.skin = parseSkinChoice("dqs+twist+smooth=12.5");
  document.lab = {.compare = true,
                  .sideBySide = true,
                  .skins = {SkinChoice{}, parseSkinChoice("cor")},
                  .solvers = {"dls", "qp"}};
  document.lecture = {.topic = "newton-1d", .state = "0.1 \"2\"\n"};
  return document;
}

TEST(SceneFile, EveryPartReadsBackExactlyAsItWasWritten) {
  const Model model = armModel();
  const Document document = armDocument(model);
  const std::string path = temporary("round.json");
  writeScene(path, document, model);
  EXPECT_EQ(readModelReference(path), document.model);
  const Document back = readScene(path, model);
  EXPECT_EQ(readFile(path), formatScene(back, model));
  std::filesystem::remove(path);

  const Edits &a = document.edits, &b = back.edits;
  EXPECT_EQ(back.model, document.model);
  EXPECT_EQ(back.skin, document.skin);
  EXPECT_EQ(back.lab.skins, document.lab.skins);
  EXPECT_EQ(b.q, a.q);
  ASSERT_EQ(b.goals.size(), 2u);
  EXPECT_EQ(b.goals[0].id, GoalId{4});
  EXPECT_EQ(b.goals[0].goal.target, a.goals[0].goal.target);
  EXPECT_EQ(b.goals[0].goal.orientation.coeffs(), a.goals[0].goal.orientation.coeffs());
  EXPECT_EQ(b.goals[0].state, GoalState::Pinned);
  EXPECT_EQ(b.goals[1].surface.triangle, 11);
  EXPECT_EQ(b.goals[1].surface.barycentric, a.goals[1].surface.barycentric);
  ASSERT_EQ(b.weights.size(), a.weights.size());
  for (int v = 0; v < a.weights.size(); ++v) ASSERT_EQ(b.weights[v], a.weights[v]) << v;
  const LimbSettings &read = b.muscles->limbs[0].second, &wrote = a.muscles->limbs[0].second;
  EXPECT_EQ(b.muscles->shownLimb, "");
  EXPECT_EQ(read.jointGap, wrote.jointGap);
  EXPECT_EQ(read.control.curves[1].fullBend, wrote.control.curves[1].fullBend);
  EXPECT_EQ(read.control.sculpted[0].plane4.stretch, wrote.control.sculpted[0].plane4.stretch);
  EXPECT_EQ(read.control.sculpted[1].plane2.displacement, wrote.control.sculpted[1].plane2.displacement);
  EXPECT_EQ(b.clip->base->q, a.clip->base->q);
  EXPECT_EQ(b.clip->framesPerSecond, a.clip->framesPerSecond);
  EXPECT_EQ(b.clip->keys.at(2)[1].frame, 9);
  EXPECT_EQ(b.clip->keys.at(2)[1].q[4], 1.1 / 7);
  EXPECT_EQ(b.seconds, a.seconds);
  EXPECT_EQ(back.solver.name, "dls");
  EXPECT_EQ(back.solver.parameters, document.solver.parameters);
  EXPECT_EQ(back.view.camera.azimuth, document.view.camera.azimuth);
  EXPECT_EQ(back.view.show, document.view.show);
  EXPECT_EQ(back.view.selectedJoint, "hand_l");
  EXPECT_EQ(back.theme, Theme::Dark);
  EXPECT_EQ(back.playback.speed, document.playback.speed);
  EXPECT_FALSE(back.playback.loop);
  EXPECT_TRUE(back.playback.goalsOnTop);
  EXPECT_EQ(back.lab.solvers, document.lab.solvers);
  EXPECT_EQ(back.lecture.state, document.lecture.state);
}

TEST(SceneFile, ASessionGoesOnFromItsFileAsIfNothingHadHappened) {
  const auto model = std::make_shared<const Model>(figure());
  Session session(model, ModelReference{});
  const GoalId hand = *session.findGoal("hand_r");
  session.setTarget(hand, session.reached(hand) + Eigen::Vector3d(0.0, 0.2, 0.1));
  for (int i = 0; i < 20; ++i) session.step();
  Session other(model, parseScene(formatScene(session.saved(), *model), "session.json", *model));
  EXPECT_EQ(other.q(), session.q());
  EXPECT_EQ(other.error(hand), session.error(hand));
  EXPECT_EQ(other.goals().size(), session.goals().size());
  EXPECT_FALSE(other.canUndo());
  const GoalId added = other.addJointGoal(model->skeleton.jointIndex("lowerarm_l"));
  EXPECT_FALSE(session.hasGoal(added));  // an id of its own
}

/// The triangle that a goal's point of the skin lies in may be another one when the body was made anew: the
/// goal then keeps its joint's point, and that is told.
TEST(SceneFile, APointOfTheSkinThatIsNowElsewhereIsToldAndItsJointsPointStays) {
  const Opened figure = openDocument({.nameOrFile = "figure"});
  Session session(figure.model, figure.document);
  const Mesh& mesh = figure.model->skin->mesh;
  const auto nearest = [&](const Eigen::Vector3d& to) {
    int best = 0;
    for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
      const auto away = [&](int k) { return (mesh.positions[mesh.triangles[k][0]] - to).norm(); };
      if (away(t) < away(best)) best = t;
    }
    return best;
  };
  const int right = nearest({0.05, 1.3, 0.13}), wrong = nearest({0.2, 0.3, 0.0});
  session.addSurfaceGoal({.triangle = right, .barycentric = {0.2, 0.3, 0.5}});
  const std::string text = formatScene(session.saved(), *figure.model);
  const std::string path = temporary("skin_point.json");
  for (const int triangle : {right, wrong}) {
    std::string changed = text;
    const std::string before = "\"triangle\": " + std::to_string(right);
    ASSERT_NE(changed.find(before), std::string::npos);
    changed.replace(changed.find(before), before.size(), "\"triangle\": " + std::to_string(triangle));
    writeFile(path, changed);
    const Opened opened = openDocument({.nameOrFile = path});
    const auto isTold =
        std::ranges::any_of(opened.model->notes, [](const Note& note) { return note.kind == "skin-point"; });
    EXPECT_EQ(isTold, triangle == wrong);
    EXPECT_EQ(opened.document.edits.goals.back().surface.triangle, triangle == wrong ? -1 : right);
  }
  std::filesystem::remove(path);
}

/// With painted weights the skin's point lies elsewhere than with the model's own: the scene has both.
TEST(SceneFile, APointOfPaintedSkinIsStillThere) {
  const Opened figure = openDocument({.nameOrFile = "figure"});
  Session session(figure.model, figure.document);
  const int triangle = 11, hand = session.skeleton().jointIndex("hand_l");
  WeightChange painted;
  for (const int v : figure.model->skin->mesh.triangles[triangle])
    painted.emplace_back(v, Influences{.joints = {hand, 0, 0, 0}, .weights = {1.0, 0.0, 0.0, 0.0}});
  session.changeWeights(painted);
  Eigen::VectorXd q = session.q();
  q[session.skeleton().qIndex(session.skeleton().jointIndex("lowerarm_l"))] = 1.5;
  session.setPose(q);
  session.setPainting(true);
  session.addSurfaceGoal({.triangle = triangle});
  const std::string path = temporary("painted.json");
  writeFile(path, formatScene(session.saved(), *figure.model));
  const Opened opened = openDocument({.nameOrFile = path});
  EXPECT_TRUE(opened.model->notes.empty());
  EXPECT_EQ(opened.document.edits.goals.back().surface.triangle, triangle);
  std::filesystem::remove(path);
}

TEST(SceneFile, AFileOfVersion1IsReadWithItsPanels) {
  const Model model = armModel();
  const Document document = armDocument(model);
  const Json now = parseJson(formatScene(document, model), "now.json");
  Json old{{"format", "gelenk-scene"}, {"version", 1},   {"model", now["model"]}, {"q", now["q"]},
           {"goals", now["goals"]},    {"solver", "dls"}};
  for (auto& goal : old["goals"]) goal.erase("id");
  for (const char* part : {"camera", "show", "theme", "selected"}) old[part] = now["view"][part];
  old["panels"] = {{"Binding", now["weights"]},
                   {"Muscles", now["muscles"]},
                   {"Motion", {{"seconds", 1.25}, {"loop", false}, {"speed", 0.5}, {"trails", false}}},
                   {"Lab", now["lab"]},
                   {"Lecture", {{"topic", "newton-1d"}, {"scene", "0.1 2"}}},
                   {"Some tab of old", 7}};
  const std::string text = old.dump();
  EXPECT_EQ(parseModelReference(text, "old.json"), document.model);
  const Document back = parseScene(text, "old.json", model);
  EXPECT_EQ(back.edits.q, document.edits.q);
  ASSERT_EQ(back.edits.goals.size(), 2u);
  EXPECT_EQ(back.edits.goals[0].id, GoalId{1});
  EXPECT_EQ(back.edits.goals[1].id, GoalId{2});
  EXPECT_EQ(back.edits.goals[1].surface.triangle, 11);
  for (int v = 0; v < back.edits.weights.size(); ++v)
    ASSERT_EQ(back.edits.weights[v], document.edits.weights[v]);
  EXPECT_EQ(back.edits.muscles->limbs[0].second.wedge, 1.0 / 7.0);
  EXPECT_EQ(back.edits.seconds, 1.25);
  EXPECT_FALSE(back.playback.loop);
  EXPECT_FALSE(back.playback.trails);
  EXPECT_TRUE(back.playback.contacts);
  EXPECT_EQ(back.lab.solvers, document.lab.solvers);
  EXPECT_EQ(back.lecture.topic, "newton-1d");
  EXPECT_EQ(back.lecture.state, "0.1 2");
  EXPECT_EQ(back.solver.name, "dls");
  EXPECT_EQ(back.view.camera.azimuth, document.view.camera.azimuth);
  EXPECT_EQ(back.theme, Theme::Dark);
}

TEST(SceneFile, TheSceneThatCameWithVersion1StillOpens) {
  const std::string path = testing::assetFolder() + "/scenes/reach.json";
  EXPECT_EQ(readModelReference(path).nameOrFile, "figure");
  const auto [model, document] = openDocument({.nameOrFile = path});
  Session session(model, document);
  const GoalId hand = *session.findGoal("hand_l");
  EXPECT_EQ(session.goal(hand).state, GoalState::Held);
  session.step();  // stands as it was saved, until something is changed
  EXPECT_EQ(session.q(), document.edits.q);
  EXPECT_TRUE(session.lastSolve().ran);
  EXPECT_EQ(session.lastSolve().iterations, 0);
  EXPECT_NEAR(session.lastSolve().error, session.error(*session.findGoal("pelvis")), 1e-12);
  session.setTarget(hand, session.goal(hand).goal.target + Eigen::Vector3d(0.01, 0, 0));
  session.step();
  EXPECT_GT(session.lastSolve().iterations, 0);
}

TEST(SceneFile, SaysWhatIsWrongAndWhere) {
  const Model model = armModel();
  const std::string good = formatScene(armDocument(model), model);
  const auto with = [&](const std::string& old, const std::string& replacement) {
    std::string text = good;
    const std::size_t at = text.find(old);
    EXPECT_NE(at, std::string::npos) << old;
    return at == std::string::npos ? text : text.replace(at, old.size(), replacement);
  };
  const std::string head = "{\"format\": \"gelenk-scene\", \"version\": 2";
  const std::string nq = std::to_string(model.skeleton.nq());
  testing::expectRefused(
      {
          {"empty", "", 1, "expected JSON, found the end of the file"},
          {"cut off", good.substr(0, good.size() / 2),
           1 + static_cast<int>(std::count(good.begin(), good.begin() + good.size() / 2, '\n')),
           "expected JSON, found the end of the file"},
          {"syntax", with("\"solver\": ", "\"solver\" "),
           1 + static_cast<int>(std::count(good.begin(), good.begin() + good.find("\"solver\""), '\n')),
           "a character that does not belong there"},
          {"CRLF keeps line numbers", "{\r\n\"format\": x}\r\n", 2, "a character that does not belong there"},
          {"NaN", "{\n\"version\": NaN}", 2, "a character that does not belong there"},
          {"binary",
           std::string("\x7f"
                       "ELF\0\1",
                       6),
           1, "expected JSON"},
          {"a number too large", "{\"version\": 1e999}", 0, "numbers that a double can hold"},
          {"nested a million deep", std::string(1000000, '['), 0, "nested at most 200 deep"},
          {"a list", "[]", 0, "a Gelenk scene"},
          {"another format", with("gelenk-scene", "other"), 0, "\"format\": \"gelenk-scene\", found other"},
          {"no format", "{}", 0, "an entry \"format\", found none"},
          {"format a number", "{\"format\": 3}", 0, "format: a text, found 3"},
          {"another version", with("\"version\": 2", "\"version\": 3"), 0, "version 1 or 2, found 3"},
          {"version a fraction", with("\"version\": 2", "\"version\": 1.5"), 0,
           "version: an integer of 32 bits, found 1.5"},
          {"version too large", with("\"version\": 2", "\"version\": 4294967297"), 0,
           "version: an integer of 32 bits, found 4294967297"},
          {"no model", head + "}", 0, "an entry \"model\", found none"},
          {"model a text", head + ", \"model\": \"figure\"}", 0, "model: an object {...}, found \"figure\""},
          {"no name", head + ", \"model\": {}}", 0, "model: an entry \"name\""},
          {"no pose", head + ", \"model\": {\"name\": \"figure\"}}", 0, "an entry \"q\""},
          {"pose too long", with("\"q\": [", "\"q\": [1.0,"), 0,
           "q: " + nq + " numbers, found " + std::to_string(model.skeleton.nq() + 1)},
          {"quaternion of another length", with("\"q\": [", "\"q\": [9"), 0,
           "a unit quaternion for joint upperarm_l"},
          {"unknown joint", with("\"joint\": \"hand_l\"", "\"joint\": \"tail\""), 0,
           "joint: a joint of the model, found 'tail'"},
          {"joint in other case", with("\"joint\": \"hand_l\"", "\"joint\": \"Hand_L\""), 0,
           "found 'Hand_L'"},
          {"an id twice", with("\"id\": 9", "\"id\": 4"), 0, "goals[1].id: an id that no other goal has"},
          {"an id of 0", with("\"id\": 9", "\"id\": 0"), 0, "goals[1].id: an integer from 1"},
          {"unknown state", with("\"state\": \"pinned\"", "\"state\": \"glued\""), 0,
           "state: one of free, held, dragged, pinned, found 'glued'"},
          {"unknown kind", with("\"kind\": \"pose\"", "\"kind\": \"wish\""), 0, "found 'wish'"},
          {"no such triangle", with("\"triangle\": 11", "\"triangle\": 111111"), 0,
           "surface.triangle: an integer from 0 to"},
          {"handle no truth value", with("\"handle\": true", "\"handle\": \"yes\""), 0,
           "handle: true or false, found \"yes\""},
          {"unknown solver", with("\"name\": \"dls\"", "\"name\": \"magic\""), 0,
           "solver.name: one of the solvers drag"},
          {"a parameter no number", with("\"lambda\": ", "\"lambda\": \"x\", \"y\": "), 0,
           "solver.parameters.dls.lambda: a number, found \"x\""},
          {"distance negative", with("\"distance\": 4.0", "\"distance\": -4.0"), 0,
           "view.camera.distance: a distance above 0, found -4"},
          {"show no truth value", with("\"ground\": ", "\"ground\": 0, \"x\": "), 0,
           "view.show.ground: true or false, found 0"},
          {"unknown theme", with("\"theme\": \"", "\"theme\": \"very "), 0, "view.theme: one of light, dark"},
          {"unknown selection", with("\"selected\": \"", "\"selected\": \"un"), 0,
           "view.selected: a joint of the model"},
          {"weights of another body", with("\"vertices\": ", "\"vertices\": 9"), 0,
           "weights.vertices: the body's 1440 vertices"},
          {"weights on no joint", with("\"joints\": [\n   \"chest\"", "\"joints\": [\n   \"tail\""), 0,
           "weights.joints[0]: a joint of the model, found 'tail'"},
          {"a vertex out of range", with("[201,", "[2010,"), 0, "an integer from 0 to 1439, found 2010"},
          {"vertices out of order", with("[201,", "[2,"), 0, "vertices in ascending order, found 2"},
          {"no limb", with("\"name\": \"left arm\"", "\"name\": \"tail\""), 0,
           "muscles.limbs[0].name: a limb of the model: left arm, found 'tail'"},
          {"activation of 2", with("\"activation\": 0.3333333333333333", "\"activation\": 2"), 0,
           "muscles.limbs[0].activation: a number from 0 to 1, found 2"},
          {"a limb's entry misspelt", with("\"wedge\"", "\"wegde\""), 0,
           "muscles.limbs[0]: an entry \"wedge\""},
          {"a key beyond the motion", with("\"frame\": 10", "\"frame\": 41"), 0,
           "clip.keys[1].frame: an integer from 1 to 40, found 41"},
          {"keys out of order", with("\"frame\": 10", "\"frame\": 4"), 0,
           "clip.keys[1].frame: frames of a joint in ascending order"},
          {"a frame of another length",
           with("\"base\": {\n   \"frames_per_second\": 30.0,\n   \"q\": [\n    [",
                "\"base\": {\n   \"frames_per_second\": 30.0,\n   \"q\": [\n    [7,"),
           0, "clip.base.q[0]: " + nq + " numbers"},
          {"an unknown solver in the lab", with("\"qp\"", "\"qpp\""), 0,
           "lab.solvers[1]: one of the solvers"},
          {"unknown example", with("\"topic\": \"newton-1d\"", "\"topic\": \"magic\""), 0,
           "lecture.topic: one of planar-fk"},
      },
      [&](const std::string& text, const std::string& file) { parseScene(text, file, model); });
  EXPECT_THROW(readScene("/no/such/scene.json", model), std::runtime_error);
}

TEST(SceneFile, NoTruncatedTextIsAccepted) {
  const Model model = armModel();
  const std::string good = formatScene(armDocument(model), model);
  for (std::size_t length = 0; length + 2 < good.size(); length += 997)
    EXPECT_THROW(parseScene(good.substr(0, length), "cut.json", model), std::runtime_error) << length;
}

}  // namespace
}  // namespace gelenk
