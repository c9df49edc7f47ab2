#include "skinning.glsl"
#include "frame.glsl"
layout(location = 4) in vec3 vertexColour;
out vec3 worldPosition;
out vec3 worldNormal;
out vec3 surfaceColour;

void main() {
  skinVertex(worldPosition, worldNormal);
  surfaceColour = vertexColour;
  gl_Position = clipFromWorld * vec4(worldPosition, 1.0);
}
