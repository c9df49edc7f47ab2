// The mean of the n x n pixels that make one of the smaller picture: supersampling, in linear light.
in vec2 ndc;
out vec4 colour;
uniform sampler2D large;
uniform int factor;

void main() {
  vec3 sum = vec3(0.0);
  ivec2 corner = factor * ivec2(gl_FragCoord.xy);
  for (int y = 0; y < factor; ++y)
    for (int x = 0; x < factor; ++x) sum += texelFetch(large, corner + ivec2(x, y), 0).rgb;
  colour = vec4(sum / float(factor * factor), 1.0);
}
