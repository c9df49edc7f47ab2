in vec4 overlayColour;
in vec2 inCapsule;
flat in vec2 lengthAndRadius;
out vec4 colour;

void main() {
  vec2 at = inCapsule * gl_FragCoord.w;
  float beyond = max(max(-at.x, at.x - lengthAndRadius.x), 0.0);
  float distance = length(vec2(beyond, at.y));
  float cover = clamp(lengthAndRadius.y - distance + 0.5, 0.0, 1.0);
  if (cover <= 0.0) discard;
  colour = vec4(overlayColour.rgb, overlayColour.a * cover);
}
