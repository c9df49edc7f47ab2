// A body seen straight down on the ground patch, carrying how close it comes to the ground.
#include "skinning.glsl"
#include "frame.glsl"
out float closeness;

void main() {
  vec3 position, normal;
  skinVertex(position, normal);
  float reach = 0.022 * fillDirection.w;
  closeness = exp(-max(heightOverGround(position), 0.0) / reach);
  gl_Position = vec4((groundCoordinates(position) - groundPatch.xy) / groundPatch.z, 0.0, 1.0);
}
