// Multiplied into the picture.
in vec2 ndc;
out vec4 colour;
uniform sampler2D source;

void main() { colour = vec4(vec3(texture(source, 0.5 + 0.5 * ndc).r), 1.0); }
