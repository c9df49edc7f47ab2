// Clay: a warm key light with a soft shadow, a cool hemisphere, a fill that follows the viewer, a faint sheen and rim. With LOOK
// colours of a material and gloss too, with PICTURE its texture and cut-outs; without, nothing is discarded, so that depth is tested
// before all this is computed.
#include "frame.glsl"
in vec3 worldPosition;
in vec3 worldNormal;
in vec3 surfaceColour;
#ifdef WIREFRAME
in vec3 corner;
#endif
out vec4 colour;

uniform vec4 tint;           // linear, straight alpha
uniform float vertexColourShare;   // 1: the vertex colour instead of the tint
#ifdef LOOK
uniform vec4 materialColour;       // linear, times picture and vertex colour
uniform float gloss;
#endif
#ifdef PICTURE
in vec2 textureCoordinate;
uniform sampler2D picture;         // of the part that is drawn
uniform vec2 pictureUse;           // x: share of the picture, y: nothing is drawn below this alpha
#endif
uniform float seeThrough;    // 1: x-ray or ghost, more opaque towards the outline
uniform sampler2DShadow shadowMap;
uniform int taps;                  // of the shadow's edge: 4, or more for one that is soft

float keyVisibility(vec3 position, vec3 normal) {
  if (groundPatch.w < 0.5) return 1.0;
  bool soft = taps > 4;
  vec4 at = shadowFromWorld * vec4(position + (soft ? 4.0 : 1.5) * keyDirection.w * normal, 1.0);
  at.z = min(at.z, 1.0);  // maps of some renderers do not clamp what is compared with them
  float texel = 1.0 / float(textureSize(shadowMap, 0).x);
  if (soft) {
    float turn = 6.2831853 * fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))), visible = 0.0;
    for (int i = 0; i < taps; ++i) {
      float angle = 2.39996323 * float(i) + turn;
      vec2 off = 6.0 * texel * sqrt((float(i) + 0.5) / float(taps)) * vec2(cos(angle), sin(angle));
      visible += texture(shadowMap, at.xyz + vec3(off, 0.0));
    }
    return visible / float(taps);
  }
  vec2 wide = vec2(1.4, 0.6) * texel;
  return 0.25 * (texture(shadowMap, at.xyz + vec3(wide, 0.0)) + texture(shadowMap, at.xyz - vec3(wide, 0.0)) +
                 texture(shadowMap, at.xyz + vec3(-wide.y, wide.x, 0.0)) +
                 texture(shadowMap, at.xyz - vec3(-wide.y, wide.x, 0.0)));
}

void main() {
  vec3 v = directionToEye(worldPosition);
  vec3 n = normalize(worldNormal);
  float facing = dot(n, v);
  if (facing < 0.0 && !gl_FrontFacing) { n = -n; facing = -facing; }  // the inside of an open surface
  facing = clamp(facing, 0.0, 1.0);

  vec3 albedo = mix(tint.rgb, surfaceColour, vertexColourShare);
#ifdef PICTURE
  vec4 texel = mix(vec4(1.0), texture(picture, textureCoordinate), pictureUse.x);
  if (materialColour.a * texel.a < pictureUse.y) discard;
  albedo *= texel.rgb;
#endif
#ifdef LOOK
  albedo *= materialColour.rgb;
#endif
#ifdef WIREFRAME
  float width = 0.6 * towardsViewer.w;
  vec3 dx = dFdx(corner), dy = dFdy(corner);
  vec3 edgeDistance = corner / max(sqrt(dx * dx + dy * dy), vec3(1e-6));  // in pixels
  float nearest = min(edgeDistance.x, min(edgeDistance.y, edgeDistance.z));
  float onEdge = 1.0 - smoothstep(width - 0.6, width + 0.6, nearest);
  albedo = mix(albedo, 0.16 * albedo, 0.75 * onEdge);
#endif

  float towardsKey = dot(n, keyDirection.xyz);
  float key = clamp((towardsKey + 0.18) / 1.18, 0.0, 1.0);
  key *= key * 0.35 + 0.65;
  if (key > 0.0) key *= mix(0.12, 1.0, keyVisibility(worldPosition, n));
  float sky = 0.5 + 0.5 * dot(n, up.xyz);
  float fill = 0.5 + 0.5 * dot(n, fillDirection.xyz);
  float nearGround = exp(-max(heightOverGround(worldPosition), 0.0) / (0.06 * fillDirection.w));
  float open = 1.0 - 0.55 * nearGround * (1.0 - sky) * step(0.5, pictureSize.z);

  vec3 light = key * keyLight.rgb + open * (mix(bounceLight.rgb, skyLight.rgb, sky) + fill * fill * fillLight.rgb);
  vec3 halfway = normalize(keyDirection.xyz + v);
  float sheen = pow(max(dot(n, halfway), 0.0), 22.0) * key;
  float away = 1.0 - facing;
  float rim = away * away * away * (0.35 + 0.65 * sky);
  vec3 shaded = albedo * light + 0.055 * sheen * keyLight.rgb + rim * rimLight.rgb;

#ifdef LOOK
  vec3 mirrored = reflect(-v, n);
  vec3 around = mix(bounceLight.rgb, skyLight.rgb, 0.5 + 0.5 * dot(mirrored, up.xyz));
  float grazing = pow(1.0 - facing, 5.0);
  shaded += gloss * (0.7 * pow(max(dot(n, halfway), 0.0), 70.0) * key * keyLight.rgb + (0.10 + 0.45 * grazing) * around);
#endif

  float below = step(heightOverGround(worldPosition), 0.0) * step(0.0, heightOverGround(eye.xyz)) * step(0.5, pictureSize.z);
  shaded = mix(shaded, groundColour.rgb, 0.7 * below);
  float alpha = mix(tint.a, tint.a * mix(0.55, 1.0, away * away), seeThrough);
  colour = vec4(shaded, alpha);
}
