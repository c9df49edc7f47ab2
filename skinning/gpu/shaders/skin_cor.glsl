#ifdef SKIN_COR
// Centres of rotation (Le and Hodgins 2016): x' = sum w_k T_k c + R (x - c), R of sum s_k w_k q_k.
layout(location = 14) in vec4 centreU;  // derivative of the centre along the first tangent; w: centre.z
layout(location = 15) in vec3 centreV;  // along the second

void blendSkin(out vec3 position, out vec3 normal) {
  vec3 u, v, alongU = vec3(0.0), alongV = vec3(0.0), centre = vec3(slopesU.w, slopesV.w, centreU.w);
  surfaceTangents(restNormal, u, v);
  vec4 slopeU = fourSlopes(slopesU), slopeV = fourSlopes(slopesV);
  vec4 q = vec4(0.0), qu = vec4(0.0), qv = vec4(0.0), first = vec4(0.0);
  position = vec3(0.0);
  for (int k = 0; k < 4 && weights[k] > 0.0; ++k) {
    int joint = int(joints[k]);
    vec4 turn = jointRow(joint, 3);
    vec3 c = centre, cu = centreU.xyz, cv = centreV;
#ifdef TWIST
    Turn t = turnOf(joint, u, v);
    turnAll(t, c, cu, cv);
    turn = turned(t, turn);
    vec4 turnSlope = 0.5 * product(turn, vec4(t.axis, 0.0));
#endif
    if (k == 0) first = turn;
    float side = dot(turn, first) < 0.0 ? -1.0 : 1.0, w = side * weights[k];
    q += w * turn;
    qu += side * slopeU[k] * turn;
    qv += side * slopeV[k] * turn;
#ifdef TWIST
    qu += w * t.slopeU * turnSlope;
    qv += w * t.slopeV * turnSlope;
#endif
    Motion m = motionOf(joint);
    vec3 at = moved(m, c);
    position += weights[k] * at;
    alongU += weights[k] * rotated(m, cu) + slopeU[k] * at;
    alongV += weights[k] * rotated(m, cv) + slopeV[k] * at;
  }
  float bySquare = 1.0 / dot(q, q);
  vec4 unitQ = sqrt(bySquare) * q;
  vec3 arm = rotate(unitQ, restPosition - centre);
  position += arm;
  alongU += rotate(unitQ, u - centreU.xyz) + 2.0 * bySquare * cross(vecTimesConjugate(qu, q), arm);
  alongV += rotate(unitQ, v - centreV) + 2.0 * bySquare * cross(vecTimesConjugate(qv, q), arm);
  normal = cross(alongU, alongV);
}
#endif
