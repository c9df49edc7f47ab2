#ifdef SKIN_DQS
// Dual quaternions (Kavan et al. 2008): q + eps p = sum s_k w_k (q_k + eps p_k), s_k = sign(q_k . q_0), 0 the heaviest bone.
void blendSkin(out vec3 position, out vec3 normal) {
  vec3 u, v;
  surfaceTangents(restNormal, u, v);
  vec4 slopeU = fourSlopes(slopesU), slopeV = fourSlopes(slopesV);
  vec4 q = vec4(0.0), p = vec4(0.0), qu = vec4(0.0), qv = vec4(0.0), pu = vec4(0.0), pv = vec4(0.0), first = vec4(0.0);
  for (int k = 0; k < 4 && weights[k] > 0.0; ++k) {
    int joint = int(joints[k]);
    vec4 turn = jointRow(joint, 3);
    vec3 shift = vec3(jointRow(joint, 0).w, jointRow(joint, 1).w, jointRow(joint, 2).w);
    vec4 dual = 0.5 * product(vec4(shift, 0.0), turn);
#ifdef TWIST
    Turn t = turnOf(joint, u, v);
    vec4 axis = vec4(t.axis, 0.0), moment = vec4(cross(t.head, t.axis), 0.0);
    vec4 turnedDual = turned(t, dual), swept = product(turn, moment);
    vec4 dualSlope = 0.5 * (product(turnedDual, axis) + t.halfC * swept);
    dual = turnedDual + t.halfS * swept;
    turn = turned(t, turn);
    vec4 turnSlope = 0.5 * product(turn, axis);
#endif
    if (k == 0) first = turn;
    float side = dot(turn, first) < 0.0 ? -1.0 : 1.0, w = side * weights[k];
    q += w * turn;
    p += w * dual;
    qu += side * slopeU[k] * turn;
    qv += side * slopeV[k] * turn;
    pu += side * slopeU[k] * dual;
    pv += side * slopeV[k] * dual;
#ifdef TWIST
    qu += w * t.slopeU * turnSlope;
    qv += w * t.slopeV * turnSlope;
    pu += w * t.slopeU * dualSlope;
    pv += w * t.slopeV * dualSlope;
#endif
  }
  float bySquare = 1.0 / dot(q, q);
  vec4 unitQ = sqrt(bySquare) * q;
  vec3 arm = rotate(unitQ, restPosition), shift = 2.0 * bySquare * vecTimesConjugate(p, q);
  position = arm + shift;
  vec3 shiftU = 2.0 * bySquare * (vecTimesConjugate(pu, q) + vecTimesConjugate(p, qu) - dot(q, qu) * shift);
  vec3 shiftV = 2.0 * bySquare * (vecTimesConjugate(pv, q) + vecTimesConjugate(p, qv) - dot(q, qv) * shift);
  normal = cross(rotate(unitQ, u) + 2.0 * bySquare * cross(vecTimesConjugate(qu, q), arm) + shiftU,
                 rotate(unitQ, v) + 2.0 * bySquare * cross(vecTimesConjugate(qv, q), arm) + shiftV);
}
#endif
