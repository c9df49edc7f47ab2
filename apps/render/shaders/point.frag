// The shapes of Overlay::Shape; discs and squares with an outline in a darker shade of their own colour.
#include "frame.glsl"
in vec4 overlayColour;
in vec2 pixelOffset;
flat in vec2 radiusAndShape;
out vec4 colour;

void main() {
  float radius = radiusAndShape.x, pixel = towardsViewer.w;
  vec2 a = abs(pixelOffset);
  int shape = int(radiusAndShape.y + 0.5);  // Overlay::Shape
  float distance = shape == 2 || shape == 4 ? max(a.x, a.y) / 0.86 : shape == 5 ? (a.x + a.y) * 0.75 : length(a);
  float cover = clamp(radius - distance + 0.5, 0.0, 1.0);
  float inner = radius - 1.4 * pixel;
  float outline = shape == 0 || shape == 2 ? clamp(distance - inner + 0.5, 0.0, 1.0) : 0.0;
  vec3 rgb = mix(overlayColour.rgb, 0.30 * overlayColour.rgb, 0.8 * outline);
  if (shape == 1) cover *= clamp(distance - (radius - 1.8 * pixel) + 0.5, 0.0, 1.0);
  if (cover <= 0.0) discard;
  colour = vec4(rgb, overlayColour.a * cover);
}
