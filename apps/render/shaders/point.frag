// Disc, ring or square with an outline in a darker shade of its own colour.
#include "frame.glsl"
in vec4 overlayColour;
in vec2 pixelOffset;
flat in vec2 radiusAndShape;
out vec4 colour;

void main() {
  float radius = radiusAndShape.x, pixel = towardsViewer.w;
  vec2 a = abs(pixelOffset);
  float distance = radiusAndShape.y > 1.5 ? max(a.x, a.y) / 0.86 : length(a);
  float cover = clamp(radius - distance + 0.5, 0.0, 1.0);
  float inner = radius - 1.4 * pixel;
  float outline = clamp(distance - inner + 0.5, 0.0, 1.0);
  vec3 rgb = mix(overlayColour.rgb, 0.30 * overlayColour.rgb, 0.8 * outline);
  if (radiusAndShape.y > 0.5 && radiusAndShape.y < 1.5) {
    cover *= clamp(distance - (radius - 3.0 * pixel) + 0.5, 0.0, 1.0);
    rgb = overlayColour.rgb;
  }
  if (cover <= 0.0) discard;
  colour = vec4(rgb, overlayColour.a * cover);
}
