// Light on the ground patch, once a texel: r the key light's visibility, softer the farther the occluder is from the ground,
// g the openness near what stands on it.
#include "frame.glsl"
in vec2 ndc;
out vec2 light;
uniform sampler2DShadow shadowMap;
uniform sampler2D shadowDepth;   // the same map, without comparison
uniform sampler2D contact;
uniform float depthRange;        // world length of the shadow map's depth

// A sunflower of points in the unit disc, turned by a hash of the texel.
vec2 spiral(int i, int n, float turn) {
  float angle = 2.39996323 * float(i) + turn;
  return sqrt((float(i) + 0.5) / float(n)) * vec2(cos(angle), sin(angle));
}

void main() {
  vec2 ground = groundPatch.xy + groundPatch.z * ndc;
  vec3 position = ground.x * groundX.xyz + ground.y * groundY.xyz + up.w * up.xyz;
  vec4 at = shadowFromWorld * vec4(position, 1.0);
  float texelWorld = keyDirection.w;
  float texel = 1.0 / float(textureSize(shadowMap, 0).x);

  const float lightSize = 0.085;   // tangent of the light's half angle
  float searchTexels = clamp(0.12 * fillDirection.w * lightSize / texelWorld * 2.5, 2.0, 40.0);
  float sum = 0.0, count = 0.0;
  for (int i = 0; i < 8; ++i) {
    float depth = texture(shadowDepth, at.xy + texel * searchTexels * spiral(i, 8, 0.0)).r;
    float blocks = step(depth, at.z);
    sum += blocks * (at.z - depth);
    count += blocks;
  }
  float visible = 1.0;
  if (count > 0.0) {
    float radius = clamp(sum / count * depthRange * lightSize / texelWorld, 1.5, 48.0);
    visible = 0.0;
    for (int i = 0; i < 16; ++i) visible += texture(shadowMap, vec3(at.xy + texel * radius * spiral(i, 16, 0.0), at.z));
    visible *= 0.0625;
  }

  float near = 0.0;
  float spread = 0.018 * fillDirection.w / groundPatch.z * 0.5;
  for (int i = 0; i < 12; ++i) near += texture(contact, 0.5 + 0.5 * ndc + spread * spiral(i, 12, 0.5)).r;
  light = vec2(visible, 1.0 - near / 12.0);
}
