#include "skinning.glsl"
#include "frame.glsl"
layout(location = 4) in float scalar;
out vec3 worldPosition;
out vec3 worldNormal;
out float surfaceScalar;

void main() {
  skinVertex(worldPosition, worldNormal);
  surfaceScalar = scalar;
  gl_Position = clipFromWorld * vec4(worldPosition, 1.0);
}
