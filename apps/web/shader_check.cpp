// What the skinning shader makes of the present pose, read back by transform feedback, against the reference
// in double precision: for the page's test.
#include <emscripten.h>

#include <algorithm>

#include "apps/document/json_entry.h"
#include "apps/document/model.h"
#include "apps/sandbox/sandbox.h"
#include "apps/web/page.h"
#include "skinning/blend/skin_choice.h"
#include "skinning/gpu/skinned_mesh_gl.h"

using namespace gelenk;

/// choice: a skinning method (skin_choice.h). {"position": largest distance / size of the body, "normal"}.
extern "C" EMSCRIPTEN_KEEPALIVE const char* page_shader_error(const char* choice) {
  static std::string text;
  Json result;
  try {
    const Session& session = pageSandbox().session();
    const Model& model = session.model();
    const PreparedSkin prepared =
        prepareSkin(*model.skin, parseSkinChoice(choice), model.skeleton, bindFrames(model));
    const Eigen::VectorXd q = session.q();
    const PosedBones bones = poseBones(prepared, session.frames(), &q);
    SkinPose pose;
    poseSkin(prepared, bones, pose);
    const SkinnedMeshGl mesh(prepared);
    const ReadBackVertices onGpu = skinOnGpu(mesh, pose);
    SkinnedVertices reference{.positions = prepared.skin.mesh.positions,
                              .normals = prepared.skin.mesh.normals};
    blendSkin(prepared, bones, reference);
    Eigen::AlignedBox3d box;
    double position = 0.0, normal = 0.0;
    for (std::size_t v = 0; v < reference.positions.size(); ++v) {
      box.extend(reference.positions[v]);
      const Eigen::Map<const Eigen::Vector3f> p(onGpu.positions[v].data()), n(onGpu.normals[v].data());
      position = std::max(position, (p.cast<double>() - reference.positions[v]).norm());
      normal = std::max(normal, (n.cast<double>() - reference.normals[v]).norm());
    }
    result = {{"position", position / box.diagonal().norm()},
              {"normal", normal},
              {"vertices", reference.positions.size()}};
  } catch (const std::exception& error) {
    result = {{"error", error.what()}};
  }
  text = result.dump();
  return text.c_str();
}
