// What the parts of the skinning methods share: slopes of the weights, tangents of the rest surface, a bone's turn at this
// vertex. The parts are all files skin_*.glsl beside this one; each defines blendSkin() where its own word is defined.
layout(location = 12) in vec4 slopesU;  // of the first three weights along the first tangent; the four sum to 0. w: centre.x
layout(location = 13) in vec4 slopesV;  // along the second; w: centre.y
#ifdef TWIST
const int jointRows = 7;  // motion, quaternion, twist
#else
const int jointRows = 4;
#endif

vec4 jointRow(int joint, int row) { return poseRow(jointRows * joint + row); }
vec4 fourSlopes(vec4 first) { return vec4(first.xyz, -(first.x + first.y + first.z)); }

/// A bone's motion.
struct Motion {
  vec4 x, y, z;
};
Motion motionOf(int joint) { return Motion(jointRow(joint, 0), jointRow(joint, 1), jointRow(joint, 2)); }
vec3 moved(Motion m, vec3 p) { return vec3(dot(m.x, vec4(p, 1.0)), dot(m.y, vec4(p, 1.0)), dot(m.z, vec4(p, 1.0))); }
vec3 rotated(Motion m, vec3 v) { return vec3(dot(m.x.xyz, v), dot(m.y.xyz, v), dot(m.z.xyz, v)); }

// Quaternions as (x, y, z, w).
vec4 product(vec4 a, vec4 b) { return vec4(a.w * b.xyz + b.w * a.xyz + cross(a.xyz, b.xyz), a.w * b.w - dot(a.xyz, b.xyz)); }
vec3 vecTimesConjugate(vec4 a, vec4 b) { return b.w * a.xyz - a.w * b.xyz - cross(a.xyz, b.xyz); }
vec3 rotate(vec4 unitQ, vec3 v) {
  vec3 u = 2.0 * cross(unitQ.xyz, v);
  return v + unitQ.w * u + cross(unitQ.xyz, u);
}

/// Two unit tangents, u x v = n (Duff et al. 2017).
void surfaceTangents(vec3 n, out vec3 u, out vec3 v) {
  float side = n.z >= 0.0 ? 1.0 : -1.0;
  float a = -1.0 / (side + n.z), b = n.x * n.y * a;
  u = vec3(1.0 + side * n.x * n.x * a, side * b, -side * n.x);
  v = vec3(b, side + n.y * n.y * a, -n.y);
}

#ifdef TWIST
/// Rot(axis, head; phi(s)) of a bone at this vertex, and the slopes of phi along the tangents.
struct Turn {
  vec3 axis, head;
  float c, s, halfC, halfS, slopeU, slopeV;
};
Turn turnOf(int joint, vec3 u, vec3 v) {
  vec4 axis = jointRow(joint, 4), head = jointRow(joint, 5);  // a and 1 / length; h and phi at the head
  float all = jointRow(joint, 6).x;                           // phi at the end minus that
  float s = axis.w * dot(axis.xyz, restPosition - head.xyz);
  float slope = s > 0.0 && s < 1.0 ? all * axis.w : 0.0;
  float halfPhi = 0.5 * (head.w + clamp(s, 0.0, 1.0) * all);
  float halfC = cos(halfPhi), halfS = sin(halfPhi);
  return Turn(axis.xyz, head.xyz, halfC * halfC - halfS * halfS, 2.0 * halfC * halfS, halfC, halfS, slope * dot(axis.xyz, u),
              slope * dot(axis.xyz, v));
}
vec3 turned(Turn t, vec3 d) { return t.c * d + t.s * cross(t.axis, d) + (1.0 - t.c) * dot(t.axis, d) * t.axis; }
vec4 turned(Turn t, vec4 q) { return product(q, vec4(t.halfS * t.axis, t.halfC)); }
/// A point with two directions that go with the vertex: all as the bone's twist turns them.
void turnAll(Turn t, inout vec3 p, inout vec3 u, inout vec3 v) {
  vec3 arm = turned(t, p - t.head), swept = cross(t.axis, arm);
  p = t.head + arm;
  u = turned(t, u) + t.slopeU * swept;
  v = turned(t, v) + t.slopeV * swept;
}
#endif
