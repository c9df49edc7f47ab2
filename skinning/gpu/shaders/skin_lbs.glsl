#ifdef SKIN_LBS
// Linear blending: x' = sum w_k T_k x; tangents t' = sum w_k R_k t + sum w_k,t T_k x.
void blendSkin(out vec3 position, out vec3 normal) {
  vec3 u, v, alongU = vec3(0.0), alongV = vec3(0.0);
  surfaceTangents(restNormal, u, v);
  vec4 slopeU = fourSlopes(slopesU), slopeV = fourSlopes(slopesV);
  position = vec3(0.0);
  for (int k = 0; k < 4 && weights[k] > 0.0; ++k) {
    int joint = int(joints[k]);
    vec3 x = restPosition, xu = u, xv = v;
#ifdef TWIST
    turnAll(turnOf(joint, u, v), x, xu, xv);
#endif
    Motion m = motionOf(joint);
    vec3 at = moved(m, x);
    position += weights[k] * at;
    alongU += weights[k] * rotated(m, xu) + slopeU[k] * at;
    alongV += weights[k] * rotated(m, xv) + slopeV[k] * at;
  }
  normal = cross(alongU, alongV);
}
#endif
