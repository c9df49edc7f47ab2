// Gradient background and, where the ray of the pixel meets it, the ground with grid, shadow and contact shade.
#include "frame.glsl"
in vec2 ndc;
in vec4 onGround;
flat in vec3 ambientShare, keyShare;
out vec4 colour;
uniform sampler2D groundLight;

/// How much of a pixel lines of a width in pixels cover; how far away they are and how large a pixel is, in cells.
float covered(vec2 away, vec2 perPixel, float width) {
  vec2 line = (1.0 - smoothstep(width - 0.5, width + 0.5, away / perPixel)) * (1.0 - smoothstep(0.12, 0.4, perPixel));
  return max(line.x, line.y);
}

void main() {
  float t = 0.5 + 0.5 * ndc.y;
  vec3 background = mix(backgroundBottom.rgb, backgroundTop.rgb, t * t * (3.0 - 2.0 * t));
  colour = vec4(background, 1.0);
#ifdef GROUND
  float s = onGround.w * onGround.z;  // from below it is seen too
  vec2 ground = onGround.xy / onGround.z;
  float distance = length(ground - groundPatch.xy) / groundY.w;
  float fade = clamp(1.0 - distance, 0.0, 1.0);
  fade = fade * fade * (3.0 - 2.0 * fade) * step(0.0, s);

  vec3 shade = mix(background, groundColour.rgb, groundColour.a * fade);
  vec2 inPatch = (ground - groundPatch.xy) / groundPatch.z;
  vec2 light = texture(groundLight, 0.5 + 0.5 * inPatch).rg;
  vec2 edge = 1.0 - smoothstep(vec2(0.85), vec2(1.0), abs(inPatch));
  light = mix(vec2(1.0), light, edge.x * edge.y * step(0.0, s));
  if (pictureSize.z > 1.5) {
    vec2 cells = ground / groundX.w;
    float width = 0.5 * towardsViewer.w;
    vec2 perPixel = max(fwidth(cells), vec2(1e-6)), away = abs(fract(cells - 0.5) - 0.5), tens = abs(fract(0.1 * cells - 0.5) - 0.5);
    float lines = max(0.45 * covered(away, perPixel, width), covered(tens, 0.1 * perPixel, 1.2 * width));
    shade = mix(shade, gridColour.rgb, gridColour.a * lines * fade);
  }
  vec3 darkening = ambientShare * mix(0.35, 1.0, light.g) + keyShare * (light.r * mix(0.8, 1.0, light.g));
  colour.rgb = shade * mix(vec3(1.0), darkening, step(0.0, onGround.w));
#endif
}
