// What all programs of one picture share. Lengths in the scene's unit, directions of unit length, colours linear.
// Mirrored by FrameBlock in renderer.cpp.
layout(std140) uniform Frame {
  mat4 clipFromWorld;
  mat4 worldFromClip;
  mat4 shadowFromWorld;   // onto the shadow map's [0, 1] cube
  vec4 eye;               // w 1: orthographic
  vec4 towardsViewer;     // w: pixels of the picture for one pixel of a width
  vec4 up;                // w: height of the ground along up
  vec4 groundX;           // axes of ground coordinates; w: spacing of the fine grid
  vec4 groundY;           // w: radius at which the ground has faded
  vec4 groundPatch;       // x, y centre in ground coordinates, z half size, w 1: shadows are drawn
  vec4 keyDirection;      // towards the light; w: world size of a shadow texel
  vec4 fillDirection;     // w: scene size
  vec4 keyLight, fillLight, skyLight, bounceLight, rimLight;
  vec4 backgroundTop, backgroundBottom, groundColour, gridColour;  // groundColour.a: how much of it covers the background
  vec4 pictureSize;       // width, height in pixels; z: ground 0 hidden, 1 plain, 2 with grid
};

vec3 directionToEye(vec3 position) { return eye.w > 0.5 ? towardsViewer.xyz : normalize(eye.xyz - position); }
float heightOverGround(vec3 position) { return dot(position, up.xyz) - up.w; }
vec2 groundCoordinates(vec3 position) { return vec2(dot(position, groundX.xyz), dot(position, groundY.xyz)); }
vec3 linearFromSrgb(vec3 c) { return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c)); }
