// One triangle over the whole target. Where a pixel's ray meets the ground is a ratio of numbers that are linear over the picture:
// the corners have them, the pixels divide.
#include "frame.glsl"
out vec2 ndc;
out vec4 onGround;  // xy / z: ground coordinates; z: how fast the ray goes down, w: height of its beginning
flat out vec3 ambientShare, keyShare;  // of the light on the ground

void main() {
  ndc = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  vec4 nearEnd = worldFromClip * vec4(ndc, -1.0, 1.0), farEnd = worldFromClip * vec4(ndc, 1.0, 1.0);
  // From the eye itself: where it is low, the near plane's lower part lies under the ground already.
  vec3 from = eye.w > 0.5 ? nearEnd.xyz / nearEnd.w : eye.xyz;
  vec3 along = eye.w > 0.5 ? farEnd.xyz / farEnd.w - from : farEnd.xyz - farEnd.w * from;  // homogeneous from the eye: linear
  float height = heightOverGround(from), down = -dot(along, up.xyz);
  onGround = vec4(down * groundCoordinates(from) + height * groundCoordinates(along), down, height);
  vec3 ambient = 1.35 * skyLight.rgb + 0.5 * fillLight.rgb, key = keyLight.rgb * max(dot(keyDirection.xyz, up.xyz), 0.0);
  ambientShare = ambient / (ambient + key);
  keyShare = key / (ambient + key);
  gl_Position = vec4(ndc, 1.0, 1.0);
}
