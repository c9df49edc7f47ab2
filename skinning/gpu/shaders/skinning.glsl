// Linear blend skinning (exercise sheet): x' = sum_i w_i T_skin,i x with T_skin,i = T_anim,i T_rest,i^-1, for every vertex.
// T_skin arrives as three rows of four numbers a joint: x'_r = dot(row_r, (x, 1)).
layout(location = 0) in vec3 restPosition;
layout(location = 1) in vec3 restNormal;
layout(location = 2) in uvec4 joints;
layout(location = 3) in vec4 weights;

#ifdef POSE_IN_TEXTURE
uniform samplerBuffer poseRows;
vec4 poseRow(int index) { return texelFetch(poseRows, index); }
#else
layout(std140) uniform Pose { vec4 poseRows[3 * 341]; };
vec4 poseRow(int index) { return poseRows[index]; }
#endif

// A layer that moves inside the sum (weights then sum to 1 - W) adds W F(x) to the position and W n' to the normal before the
// normal is normalised.
//
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
  normal = normalize(normal);
}
