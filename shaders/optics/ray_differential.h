// How the differential of a ray (its derivatives by a parameter such as a pixel coordinate) goes along a
// path. A ray is a point and a unit direction; `dp` and `dd` are their derivatives. Normals point against the
// ray, as in refraction.h, and `dn` is the derivative of the normal at the point that the differential ray
// meets. Igehy, Tracing Ray Differentials, SIGGRAPH 1999, equations 10 to 17 (with our signs).

/// Derivative of v / length(v), where dv is that of v.
FN real3 normalized_differential(real3 v, real3 dv) {
    real inverse = real(1.0) / length(v);
    real3 unit = inverse * v;
    return inverse * (dv - dot(unit, dv) * unit);
}

/// Derivative of the point where the ray meets a surface after `distance`. `normal` is the geometric one
/// (either side); infinite where the surface is seen edge on.
FN real3 transferred_differential(real3 dp, real3 dd, real3 direction, real distance, real3 normal) {
    real3 beside = dp + distance * dd;
    return beside - (dot(beside, normal) / dot(direction, normal)) * direction;
}

/// Derivative of reflected_direction(incident, normal).
FN real3 reflected_differential(real3 incident, real3 normal, real3 dd, real3 dn) {
    real cosine = dot(incident, normal);
    real dcosine = dot(dd, normal) + dot(incident, dn);
    return dd - real(2.0) * (cosine * dn + dcosine * normal);
}

/// Derivative of refracted_direction(incident, normal, eta). Grows without bound towards the critical angle
/// (cos_t = 0), where it is infinite; not defined on total internal reflection.
FN real3 refracted_differential(real3 incident, real3 normal, real eta, real3 dd, real3 dn) {
    real cos_i = min(real(1.0), max(real(0.0), -dot(incident, normal)));
    real cos_t = transmitted_cosine(cos_i, eta);
    real dcos_i = -(dot(dd, normal) + dot(incident, dn));
    real dcos_t = eta * eta * cos_i * dcos_i / cos_t;
    return eta * dd + (eta * cos_i - cos_t) * dn + (eta * dcos_i - dcos_t) * normal;
}
