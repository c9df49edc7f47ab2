in vec4 overlayColour;
out vec4 colour;

void main() { colour = overlayColour; }
