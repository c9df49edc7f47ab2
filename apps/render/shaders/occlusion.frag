// How open the surface is at each pixel, from the depths around it: 1 where nothing stands near, darker in folds and where
// parts touch. A pattern of 4 x 4 pixels, which blur.frag averages.
#include "frame.glsl"
in vec2 ndc;
out vec2 light;
uniform sampler2D depth;

const int pairs = 8;

vec3 positionAt(vec2 at) {
  vec4 p = worldFromClip * vec4(at, 2.0 * textureLod(depth, 0.5 + 0.5 * at, 0.0).r - 1.0, 1.0);
  return p.xyz / p.w;
}

// How far what is seen at `at` rises over the plane at the position, less the nearer the edge of the reach. A triangle tilts
// its plane a little against the surface's: what that adds on one side it takes away on the other, and no triangle shows.
float rise(vec2 at, vec3 position, vec3 n, float reach) {
  vec3 v = positionAt(at) - position;
  float squared = dot(v, v), rises = dot(v, n) * inversesqrt(squared + 1e-12);
  return (max(rises, -0.4) - 0.1) * max(1.0 - squared / (reach * reach), 0.0);
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
  float turn = 3.14159265 / 16.0 * (mod(gl_FragCoord.x, 4.0) + 4.0 * mod(gl_FragCoord.y, 4.0));
  float closed = 0.0;
  for (int i = 0; i < pairs; ++i) {
    float angle = 2.39996323 * float(i) + turn;
    vec2 away = radius * sqrt((float(i) + 0.5) / float(pairs)) * vec2(cos(angle), sin(angle));
    closed += max(rise(ndc + away, position, n, reach) + rise(ndc - away, position, n, reach), 0.0);
  }
  light = vec2(clamp(1.0 - 6.0 * closed / float(2 * pairs), 0.0, 1.0));
}
