// A segment as a quad around its capsule in pixels; one instance a segment.
#include "frame.glsl"
layout(location = 0) in vec3 startPosition;
layout(location = 1) in vec4 startColour;
layout(location = 2) in vec3 endPosition;
layout(location = 3) in vec4 endColour;
layout(location = 4) in float width;
layout(location = 5) in float flatEnds;  // 1: at the start, 2: at the end, 3: both
out vec4 overlayColour;
out vec2 inCapsule;                    // pixels along and across, from the start; times w, to be linear on the screen
flat out vec4 lengthRadiusAndFlat;
uniform float depthBias;

void main() {
  vec4 a = clipFromWorld * vec4(startPosition, 1.0), b = clipFromWorld * vec4(endPosition, 1.0);
  // Clip against the near plane, where pixels would turn over.
  float da = a.z + a.w, db = b.z + b.w, near = 1e-4 * (abs(a.w) + abs(b.w));
  if (da < near && db > near) a = mix(a, b, (near - da) / (db - da));
  else if (db < near && da > near) b = mix(b, a, (near - db) / (da - db));
  vec2 halfSize = 0.5 * pictureSize.xy;
  vec2 pa = halfSize * a.xy / a.w, pb = halfSize * b.xy / b.w;
  float span = length(pb - pa);
  vec2 along = span > 1e-6 ? (pb - pa) / span : vec2(1.0, 0.0);
  vec2 across = vec2(-along.y, along.x);
  float radius = 0.5 * width * towardsViewer.w;
  float reach = radius + 1.0;

  bool atEnd = gl_VertexID >= 2;
  float side = (gl_VertexID & 1) == 0 ? -1.0 : 1.0;
  vec4 base = atEnd ? b : a;
  vec2 pixel = (atEnd ? pb + reach * along : pa - reach * along) + side * reach * across;
  inCapsule = base.w * vec2(atEnd ? span + reach : -reach, side * reach);
  lengthRadiusAndFlat = vec4(span, radius, mod(flatEnds, 2.0), floor(0.5 * flatEnds));
  vec4 c = atEnd ? endColour : startColour;
  overlayColour = vec4(linearFromSrgb(c.rgb), c.a);
  gl_Position = vec4(pixel / halfSize * base.w, base.z - depthBias * base.w, base.w);
  if (da < near && db < near) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
}
