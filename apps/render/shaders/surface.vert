#include "skinning.glsl"
#include "frame.glsl"
layout(location = 4) in vec3 vertexColour;
out vec3 worldPosition;
out vec3 worldNormal;
out vec3 surfaceColour;
#ifdef WIREFRAME
uniform int vertexCount;
out vec3 corner;  // 1 at this corner of the triangle, 0 along the edge that faces it
#endif

void main() {
  skinVertex(worldPosition, worldNormal);
  surfaceColour = vertexColour;
#ifdef WIREFRAME
  int k = gl_VertexID / vertexCount;
  corner = vec3(k == 0, k == 1, k == 2);
#endif
  gl_Position = clipFromWorld * vec4(worldPosition, 1.0);
}
