// The mean of 4 x 4 texels, by four linear fetches where four of them meet.
in vec2 ndc;
out vec2 light;
uniform sampler2D source;

void main() {
  vec2 texel = 1.0 / vec2(textureSize(source, 0)), low = 0.5 + 0.5 * ndc - 1.5 * texel, high = low + 2.0 * texel;
  light = 0.25 * (texture(source, low).rg + texture(source, vec2(high.x, low.y)).rg +
                  texture(source, vec2(low.x, high.y)).rg + texture(source, high).rg);
}
