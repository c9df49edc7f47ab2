// Light on the ground patch, once a texel: r the key light's visibility, softer the farther the occluder is from the ground,
// g the openness near what stands on it.
#include "frame.glsl"
in vec2 ndc;
out vec2 light;
uniform sampler2DShadow shadowMap;
uniform sampler2D shadowDepth;   // the same map, without comparison
uniform sampler2D contact;
uniform float depthRange;        // world length of the shadow map's depth
uniform int taps;

const float lightSize = 0.075;   // tangent of the light's half angle

// A sunflower of points in the unit disc.
vec2 spiral(int i, int n, float turn) {
  float angle = 2.39996323 * float(i) + turn;
  return sqrt((float(i) + 0.5) / float(n)) * vec2(cos(angle), sin(angle));
}

void main() {
  vec2 ground = groundPatch.xy + groundPatch.z * ndc;
  vec3 position = ground.x * groundX.xyz + ground.y * groundY.xyz + up.w * up.xyz;
  vec4 at = shadowFromWorld * vec4(position, 1.0);
  at.z = min(at.z, 1.0);  // maps of some renderers do not clamp what is compared with them
  float texelWorld = keyDirection.w;
  float texel = 1.0 / float(textureSize(shadowMap, 0).x);
  // Each texel turns the pattern by another angle (interleaved gradient noise); the blur afterwards averages over 4 x 4 of them.
  float turn = 6.2831853 * fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));

  float searchTexels = clamp(0.35 * fillDirection.w * lightSize / texelWorld, 3.0, 48.0);
  float sum = 0.0, count = 0.0;
  for (int i = 0; i < taps / 2; ++i) {
    float depth = texture(shadowDepth, at.xy + texel * searchTexels * spiral(i, taps / 2, turn)).r;
    float blocks = step(depth, at.z);
    sum += blocks * (at.z - depth);
    count += blocks;
  }
  float visible = 1.0;
  if (count > 0.0) {
    float radius = clamp(sum / count * depthRange * lightSize / texelWorld, 1.5, 64.0);
    visible = 0.0;
    for (int i = 0; i < taps; ++i) visible += texture(shadowMap, vec3(at.xy + texel * radius * spiral(i, taps, turn), at.z));
    visible /= float(taps);
  }

  float near = 0.0;
  float spread = 0.5 * 0.02 * fillDirection.w / groundPatch.z;
  for (int i = 0; i < taps; ++i) near += texture(contact, 0.5 + 0.5 * ndc + spread * spiral(i, taps, turn)).r;
  light = vec2(visible, 1.0 - near / float(taps));
}
