#include "skinning.glsl"
#include "frame.glsl"
layout(location = 4) in vec3 vertexColour;
out vec3 worldPosition;
out vec3 worldNormal;
out vec3 surfaceColour;
layout(location = 12) in vec2 coordinateIn;
out vec2 textureCoordinate;

void main() {
  skinVertex(worldPosition, worldNormal);
  surfaceColour = vertexColour;
  textureCoordinate = coordinateIn;
  gl_Position = clipFromWorld * vec4(worldPosition, 1.0);
}
