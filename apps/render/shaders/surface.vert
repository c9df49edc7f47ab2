#include "skinning.glsl"
#include "frame.glsl"
layout(location = 4) in vec3 vertexColour;
out vec3 worldPosition;
out vec3 worldNormal;
out vec3 surfaceColour;
#ifdef PICTURE
out vec2 textureCoordinate;
#endif
#if defined(LOOK) || defined(WIREFRAME)
uniform float packedColours;  // 1: vertexColour is (r + 256 g + 65536 b in 0 ... 255 each, u, v)
#endif
#ifdef WIREFRAME
uniform int vertexCount;
out vec3 corner;  // 1 at this corner of the triangle, 0 along the edge that faces it
#endif

void main() {
  skinVertex(worldPosition, worldNormal);
  surfaceColour = vertexColour;
#ifdef PICTURE
  textureCoordinate = vertexColour.yz;
#endif
#if defined(LOOK) || defined(WIREFRAME)
  if (packedColours > 0.5) {
    float c = vertexColour.x;
    surfaceColour = mod(floor(vec3(c, c / 256.0, c / 65536.0)), 256.0) / 255.0;
  }
#endif
#ifdef WIREFRAME
  int k = gl_VertexID / vertexCount;
  corner = vec3(k == 0, k == 1, k == 2);
#endif
  gl_Position = clipFromWorld * vec4(worldPosition, 1.0);
}
