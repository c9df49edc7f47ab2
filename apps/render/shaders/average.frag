// The mean of the n x n pixels that make one of the picture, in linear light (supersampling), encoded as sRGB.
in vec2 ndc;
out vec4 colour;
uniform sampler2D large;
uniform int factor;

vec3 srgbFromLinear(vec3 c) { return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c)); }

void main() {
  vec3 sum = vec3(0.0);
  ivec2 corner = factor * ivec2(gl_FragCoord.xy);
  for (int y = 0; y < factor; ++y)
    for (int x = 0; x < factor; ++x) sum += texelFetch(large, corner + ivec2(x, y), 0).rgb;
  colour = vec4(srgbFromLinear(sum / float(factor * factor)), 1.0);
}
