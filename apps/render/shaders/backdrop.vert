// One triangle over the whole target, with the ends of each pixel's ray: homogeneous points are linear over the picture.
#include "frame.glsl"
out vec2 ndc;
out vec4 nearEnd, farEnd;

void main() {
  ndc = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  nearEnd = worldFromClip * vec4(ndc, -1.0, 1.0);
  farEnd = worldFromClip * vec4(ndc, 1.0, 1.0);
  gl_Position = vec4(ndc, 1.0, 1.0);
}
