in vec2 ndc;
out vec4 colour;
uniform sampler2D source;

void main() { colour = vec4(texture(source, 0.5 + 0.5 * ndc).rgb, 1.0); }
