// Linear blend skinning (exercise sheet): x' = sum_i w_i T_skin,i x with T_skin,i = T_anim,i T_rest,i^-1, for every vertex.
// T_skin arrives as three rows of four numbers a joint: x'_r = dot(row_r, (x, 1)).
layout(location = 0) in vec3 restPosition;
layout(location = 1) in vec3 restNormal;
layout(location = 2) in uvec4 joints;
layout(location = 3) in vec4 weights;

#ifdef POSE_IN_TEXTURE
uniform sampler2D poseRows;  // rows after each other, 341 joints in a line of the texture
vec4 poseRow(int index) { return texelFetch(poseRows, ivec2(index % 1023, index / 1023), 0); }
#else
layout(std140) uniform Pose { vec4 poseRows[3 * 341]; };
vec4 poseRow(int index) { return poseRows[index]; }
#endif

#ifdef LAYERS
// Chadwick's muscle layer: F(x, y, w), tri-cubic over four control planes, moves inside the skinning sum with the weight W.
// The weights of the bones outside the limb then sum to 1 - W. A plane: (origin, turn), axis x, axis y.
layout(location = 5) in vec4 limbParameters;  // x, y in the section (metres), w and W
layout(location = 6) in vec3 limbNormal;      // m = J_rest^T n_rest
layout(location = 7) in uvec3 limbRows;       // of the first of its four planes, of its link's matrix; joint of its end frame E
layout(std140) uniform Layers { vec4 layerRows[1024]; };
#ifdef SCULPTED
// Where its fixed (x, y, w) meet the freely displaced control points, in the link's own frame: displacement and d/dx, d/dy, d/dw.
layout(location = 8) in vec3 sculpture;
layout(location = 9) in vec3 sculptureU;
layout(location = 10) in vec3 sculptureV;
layout(location = 11) in vec3 sculptureW;
#endif

vec4 bernstein(float t) {
  float s = 1.0 - t;
  return vec4(s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t);
}
vec4 bernsteinSlope(float t) {
  float s = 1.0 - t;
  return vec4(-3.0 * s * s, 3.0 * s * (s - 2.0 * t), 3.0 * t * (2.0 * s - t), 3.0 * t * t);
}

// F and the deformed unit normal. The control points of a plane are an affine image of the section, so that the sum over 64 points
// is a sum over four planes; the place in the section is turned about the bone first, by the blend of the planes' turns. What is
// sculpted, a sum of its own for every vertex, changes only by the link's turn.
void deformLimb(out vec3 x, out vec3 n) {
  vec4 bw = bernstein(limbParameters.z), dw = bernsteinSlope(limbParameters.z);
  vec4 origin = vec4(0.0), originW = vec4(0.0);  // w: the turn
  vec3 axisX = vec3(0.0), axisY = vec3(0.0), axisXW = vec3(0.0), axisYW = vec3(0.0);
  int row = int(limbRows.x);
  for (int k = 0; k < 4; ++k, row += 3) {
    vec4 o = layerRows[row];
    vec3 a = layerRows[row + 1].xyz, b = layerRows[row + 2].xyz;
    origin += bw[k] * o;
    axisX += bw[k] * a;
    axisY += bw[k] * b;
    originW += dw[k] * o;
    axisXW += dw[k] * a;
    axisYW += dw[k] * b;
  }
  float c = cos(origin.w), s = sin(origin.w);
  vec2 p = mat2(c, s, -s, c) * limbParameters.xy;
  x = origin.xyz + p.x * axisX + p.y * axisY;
  vec3 xu = c * axisX + s * axisY, xv = c * axisY - s * axisX;
  vec3 xw = originW.xyz + p.x * axisXW + p.y * axisYW + originW.w * (p.x * axisY - p.y * axisX);
#ifdef SCULPTED
  int link = int(limbRows.y);
  mat3 worldFromLink = mat3(layerRows[link].xyz, layerRows[link + 1].xyz, layerRows[link + 2].xyz);
  x += worldFromLink * sculpture;
  xu += worldFromLink * sculptureU;
  xv += worldFromLink * sculptureV;
  xw += worldFromLink * sculptureW;
#endif
  n = normalize(limbNormal.x * cross(xv, xw) + limbNormal.y * cross(xw, xu) + limbNormal.z * cross(xu, xv));
}
#endif

#ifdef PREPARED
#include "skin_bones.glsl"
#include "skin_methods.glsl"

// Posed position and unit normal by the method whose part defines blendSkin(); layers in displacement form,
// x' = S(x) + W (F(x) - E x), where S knows the limb as its end frame E alone.
void skinVertex(out vec3 position, out vec3 normal) {
  blendSkin(position, normal);
  normal = normalize(normal);
#ifdef LAYERS
  float W = limbParameters.w;
  if (W > 0.0) {
    vec3 limbPosition, limbUnitNormal;
    deformLimb(limbPosition, limbUnitNormal);
    Motion end = motionOf(int(limbRows.z));
    position += W * (limbPosition - moved(end, restPosition));
    normal = normalize(normal + W * (limbUnitNormal - rotated(end, restNormal)));
  }
#endif
}
#else
// Posed position, and unit normal by the cofactors of the blended matrix: they equal det(M) M^-T, which keeps a normal
// perpendicular to its surface where the blend of rotations is no rotation any more.
void skinVertex(out vec3 position, out vec3 normal) {
  vec4 rows[3] = vec4[3](vec4(0.0), vec4(0.0), vec4(0.0));
  for (int k = 0; k < 4; ++k) {
    int first = 3 * int(joints[k]);
    rows[0] += weights[k] * poseRow(first);
    rows[1] += weights[k] * poseRow(first + 1);
    rows[2] += weights[k] * poseRow(first + 2);
  }
  vec4 x = vec4(restPosition, 1.0);
  position = vec3(dot(rows[0], x), dot(rows[1], x), dot(rows[2], x));
  normal = vec3(dot(cross(rows[1].xyz, rows[2].xyz), restNormal), dot(cross(rows[2].xyz, rows[0].xyz), restNormal),
                dot(cross(rows[0].xyz, rows[1].xyz), restNormal));
#ifdef LAYERS
  float W = limbParameters.w;
  if (W > 0.0) {
    vec3 limbPosition, limbUnitNormal;
    deformLimb(limbPosition, limbUnitNormal);
    position += W * limbPosition;
    // The cofactors of a blend with the weights' sum s = 1 - W carry s^2: back to s.
    normal = W < 1.0 ? normal / (1.0 - W) + W * limbUnitNormal : limbUnitNormal;
  }
#endif
  normal = normalize(normal);
}
#endif
