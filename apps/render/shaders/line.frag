in vec4 overlayColour;
in vec2 inCapsule;
flat in vec4 lengthRadiusAndFlat;
out vec4 colour;

void main() {
  vec2 at = inCapsule * gl_FragCoord.w;
  vec2 beyond = vec2(-at.x, at.x - lengthRadiusAndFlat.x);  // of the start and of the end
  vec2 isRound = 1.0 - lengthRadiusAndFlat.zw;
  float distance = length(vec2(max(max(beyond.x * isRound.x, beyond.y * isRound.y), 0.0), at.y));
  vec2 within = max(clamp(0.5 - beyond, 0.0, 1.0), isRound);
  float cover = clamp(lengthRadiusAndFlat.y - distance + 0.5, 0.0, 1.0) * within.x * within.y;
  if (cover <= 0.0) discard;
  colour = vec4(overlayColour.rgb, overlayColour.a * cover);
}
