// Gradient background and, where the ray of the pixel meets it, the ground with grid, shadow and contact shade.
#include "frame.glsl"
in vec2 ndc;
in vec4 nearEnd, farEnd;  // of the pixel's ray, homogeneous
out vec4 colour;
uniform sampler2D groundLight;

float gridLines(vec2 cells, float width) {
  vec2 perPixel = max(fwidth(cells), vec2(1e-6));
  vec2 nearest = abs(fract(cells - 0.5) - 0.5) / perPixel;
  vec2 line = (1.0 - smoothstep(width - 0.5, width + 0.5, nearest)) * (1.0 - smoothstep(0.12, 0.4, perPixel));
  return max(line.x, line.y);
}

void main() {
  float t = 0.5 + 0.5 * ndc.y;
  vec3 background = mix(backgroundBottom.rgb, backgroundTop.rgb, t * t * (3.0 - 2.0 * t));
  colour = vec4(background, 1.0);
#ifdef GROUND
  // From the eye itself: where it is low, the near plane's lower part lies under the ground already.
  vec3 a = eye.w > 0.5 ? nearEnd.xyz / nearEnd.w : eye.xyz, b = farEnd.xyz / farEnd.w;
  float ha = heightOverGround(a), hb = heightOverGround(b);
  float s = ha / (ha - hb);
  vec3 position = a + s * (b - a);
  vec2 ground = groundCoordinates(position);
  // It reaches to below the eye, however far that is.
  float reach = eye.w > 0.5 ? 0.0 : length(groundCoordinates(eye.xyz) - groundPatch.xy);
  float distance = length(ground - groundPatch.xy) / max(groundY.w, 1.5 * reach);
  float fade = clamp(1.0 - distance, 0.0, 1.0);
  fade = fade * fade * (3.0 - 2.0 * fade) * step(0.0, s);  // from below it is seen too

  vec3 shade = mix(background, groundColour.rgb, groundColour.a * fade);
  vec2 inPatch = (ground - groundPatch.xy) / groundPatch.z;
  vec2 light = texture(groundLight, 0.5 + 0.5 * inPatch).rg;
  vec2 edge = 1.0 - smoothstep(vec2(0.85), vec2(1.0), abs(inPatch));
  light = mix(vec2(1.0), light, edge.x * edge.y * step(0.0, s));
  if (pictureSize.z > 1.5) {
    vec2 cells = ground / groundX.w;
    float width = 0.5 * towardsViewer.w;
    float lines = max(0.45 * gridLines(cells, width), gridLines(0.1 * cells, 1.2 * width));
    shade = mix(shade, gridColour.rgb, gridColour.a * lines * fade);
  }
  vec3 ambient = 1.35 * skyLight.rgb + 0.5 * fillLight.rgb;
  vec3 lit = keyLight.rgb * max(dot(keyDirection.xyz, up.xyz), 0.0);
  vec3 darkening = (ambient * mix(0.35, 1.0, light.g) + lit * light.r * mix(0.8, 1.0, light.g)) / (ambient + lit);
  colour.rgb = shade * mix(vec3(1.0), darkening, step(0.0, ha));
#endif
}
