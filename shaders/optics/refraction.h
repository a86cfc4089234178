// Snell's law and Fresnel's equations at a smooth dielectric surface, in vector form (no inverse
// trigonometry). Directions are unit and point along the travel of light. `normal` is unit and points against
// the incoming ray: dot(incident, normal) <= 0. `eta` is the index of the medium that is left over that of
// the one entered. Born & Wolf, Principles of Optics, 1.5.1 and 1.5.2.

/// Cosine of the transmitted angle, or -1 on total internal reflection. cos_i in [0, 1].
/// 1 - eta^2 (1 - cos_i^2), arranged so that the indices are compared before the cosine joins: a sum of
/// positive terms from air, and at eta = 1 the very cosine that came in.
FN real transmitted_cosine(real cos_i, real eta) {
    real scaled = eta * cos_i;
    real square = (real(1.0) - eta) * (real(1.0) + eta) + scaled * scaled;
    return square < real(0.0) ? real(-1.0) : sqrt(square);
}

/// Unit direction of the refracted ray; false, and no direction, on total internal reflection.
FN bool refracted_direction(real3 incident, real3 normal, real eta, OUT(real3) refracted) {
    real cos_i = min(real(1.0), max(real(0.0), -dot(incident, normal)));
    real cos_t = transmitted_cosine(cos_i, eta);
    refracted = eta * incident + (eta * cos_i - cos_t) * normal;
    return cos_t >= real(0.0);
}

/// Unit direction of the mirrored ray.
FN real3 reflected_direction(real3 incident, real3 normal) {
    return incident - (real(2.0) * dot(incident, normal)) * normal;
}

/// Share of the power of unpolarised light that is reflected. cos_t as from transmitted_cosine. The fused
/// products leave one rounding in each difference, where eta * cos_i - cos_t would lose digits for indices
/// near 1.
FN real fresnel_reflectance(real cos_i, real cos_t, real eta) {
    if (cos_t < real(0.0)) return real(1.0);
    if (eta == real(1.0)) return real(0.0);
    real s = fma(eta, cos_i, -cos_t) / fma(eta, cos_i, cos_t);
    real p = fma(-eta, cos_t, cos_i) / fma(eta, cos_t, cos_i);
    return real(0.5) * (s * s + p * p);
}

/// Share that is transmitted, as a product: 1 - reflectance loses all its digits at grazing incidence.
FN real fresnel_transmittance(real cos_i, real cos_t, real eta) {
    if (cos_t < real(0.0)) return real(0.0);
    if (eta == real(1.0)) return real(1.0);
    real s = eta * cos_i + cos_t;
    real p = cos_i + eta * cos_t;
    return min(real(1.0), real(2.0) * eta * cos_i * cos_t * (real(1.0) / (s * s) + real(1.0) / (p * p)));
}
