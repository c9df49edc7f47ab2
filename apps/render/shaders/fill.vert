#include "frame.glsl"
layout(location = 0) in vec3 position;
layout(location = 1) in vec4 colourIn;
out vec4 overlayColour;

void main() {
  overlayColour = vec4(linearFromSrgb(colourIn.rgb), colourIn.a);
  gl_Position = clipFromWorld * vec4(position, 1.0);
}
