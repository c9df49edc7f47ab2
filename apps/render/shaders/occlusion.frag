// How open the surface is at each pixel, from the depths around it: 1 where nothing stands near, darker in folds and where
// parts touch. A pattern of 4 x 4 pixels, which blur.frag averages.
#include "frame.glsl"
in vec2 ndc;
out vec2 light;
uniform sampler2D depth;

const int taps = 16;

vec3 positionAt(vec2 at) {
  vec4 p = worldFromClip * vec4(at, 2.0 * textureLod(depth, 0.5 + 0.5 * at, 0.0).r - 1.0, 1.0);
  return p.xyz / p.w;
}

void main() {
  light = vec2(1.0);
  vec2 step = vec2(dFdx(ndc.x), dFdy(ndc.y));  // a pixel
  if (textureLod(depth, 0.5 + 0.5 * ndc, 0.0).r >= 1.0) return;  // ground and background
  vec3 position = positionAt(ndc);
  // The normal from the nearer neighbour on each side: none across an outline.
  vec3 right = positionAt(ndc + vec2(step.x, 0.0)) - position, left = position - positionAt(ndc - vec2(step.x, 0.0));
  vec3 above = positionAt(ndc + vec2(0.0, step.y)) - position, below = position - positionAt(ndc - vec2(0.0, step.y));
  vec3 n = normalize(cross(dot(right, right) < dot(left, left) ? right : left, dot(above, above) < dot(below, below) ? above : below));

  float reach = 0.06 * fillDirection.w;
  float w = dot(vec4(clipFromWorld[0].w, clipFromWorld[1].w, clipFromWorld[2].w, clipFromWorld[3].w), vec4(position, 1.0));
  vec2 radius = reach / w * vec2(length(vec3(clipFromWorld[0].x, clipFromWorld[1].x, clipFromWorld[2].x)),
                                 length(vec3(clipFromWorld[0].y, clipFromWorld[1].y, clipFromWorld[2].y)));
  float turn = 6.2831853 / 16.0 * (mod(gl_FragCoord.x, 4.0) + 4.0 * mod(gl_FragCoord.y, 4.0));
  float closed = 0.0;
  for (int i = 0; i < taps; ++i) {
    float angle = 2.39996323 * float(i) + turn;
    vec2 at = ndc + radius * sqrt((float(i) + 0.5) / float(taps)) * vec2(cos(angle), sin(angle));
    vec3 v = positionAt(at) - position;
    float squared = dot(v, v);
    float rises = dot(v, n) * inversesqrt(squared + 1e-12) - 0.1;
    closed += max(rises, 0.0) * max(1.0 - squared / (reach * reach), 0.0);
  }
  light = vec2(clamp(1.0 - 4.5 * closed / float(taps), 0.0, 1.0));
}
