// The mean of 4 x 4 texels, by four linear fetches.
in vec2 ndc;
out vec2 light;
uniform sampler2D source;

void main() {
  vec2 texel = 1.0 / vec2(textureSize(source, 0)), at = 0.5 + 0.5 * ndc;
  light = 0.25 * (texture(source, at + texel * vec2(-1.0, -1.0)).rg + texture(source, at + texel * vec2(1.0, -1.0)).rg +
                  texture(source, at + texel * vec2(-1.0, 1.0)).rg + texture(source, at + texel * vec2(1.0, 1.0)).rg);
}
