// A body's depth alone, seen from the light.
#include "skinning.glsl"
uniform mat4 clipFromWorldOfLight;

void main() {
  vec3 position, normal;
  skinVertex(position, normal);
  gl_Position = clipFromWorldOfLight * vec4(position, 1.0);
}
