// Hands each fragment its distance to the three edges of its triangle, in pixels, for the wireframe.
#include "frame.glsl"
layout(triangles) in;
layout(triangle_strip, max_vertices = 3) out;
in vec3 worldPosition[];
in vec3 worldNormal[];
in vec3 surfaceColour[];
out vec3 edgePosition;
out vec3 edgeNormal;
out vec3 edgeColour;
noperspective out vec3 edgeDistance;

vec2 pixel(int i) { return 0.5 * pictureSize.xy * gl_in[i].gl_Position.xy / gl_in[i].gl_Position.w; }

void main() {
  vec2 a = pixel(0), b = pixel(1), c = pixel(2);
  float area = abs((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
  vec3 heights = area / max(vec3(length(c - b), length(c - a), length(b - a)), vec3(1e-6));
  for (int i = 0; i < 3; ++i) {
    edgePosition = worldPosition[i];
    edgeNormal = worldNormal[i];
    edgeColour = surfaceColour[i];
    edgeDistance = vec3(0.0);
    edgeDistance[i] = heights[i];
    gl_Position = gl_in[i].gl_Position;
    EmitVertex();
  }
  EndPrimitive();
}
