// A spot light's intensity relative to its axis. Cosines of the angle to the axis: of the direction, of the
// edge where the light has fallen to nothing, and of the inner cone where it is full. Smooth (C1) between
// them.
FN real spot_light_falloff(real cosine, real cos_outer, real cos_inner) {
    if (cosine <= cos_outer) return real(0.0);
    if (cosine >= cos_inner) return real(1.0);
    real x = (cosine - cos_outer) / (cos_inner - cos_outer);
    return x * x * (real(3.0) - real(2.0) * x);
}
