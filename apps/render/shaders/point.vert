#include "frame.glsl"
layout(location = 0) in vec3 position;
layout(location = 1) in vec4 colourIn;
layout(location = 2) in float diameter;
layout(location = 3) in float shapeIn;
out vec4 overlayColour;
out vec2 pixelOffset;
flat out vec2 radiusAndShape;
uniform float depthBias;

void main() {
  vec2 corner = vec2((gl_VertexID & 1) == 0 ? -1.0 : 1.0, gl_VertexID < 2 ? -1.0 : 1.0);
  float radius = 0.5 * diameter * towardsViewer.w;
  vec4 centre = clipFromWorld * vec4(position, 1.0);
  pixelOffset = corner * (radius + 1.0);
  radiusAndShape = vec2(radius, shapeIn);
  overlayColour = vec4(linearFromSrgb(colourIn.rgb), colourIn.a);
  gl_Position = vec4(centre.xy + pixelOffset / (0.5 * pictureSize.xy) * centre.w, centre.z - depthBias * centre.w, centre.w);
}
