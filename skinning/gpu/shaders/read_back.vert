// The skinning alone: its outputs are captured by transform feedback.
#include "skinning.glsl"
out vec3 posedPosition;
out vec3 posedNormal;

void main() {
  skinVertex(posedPosition, posedNormal);
  gl_Position = vec4(posedPosition, 1.0);
}
