// Phase functions p [1/sr]: how scattered light is shared among directions, normalised to 1 over the sphere.
// `cosine` is that of the angle between the ways before and after scattering: 1 is straight on.

FN real isotropic_phase() {
    return real(0.0795774715459476679);  // 1 / (4 pi)
}

/// Henyey & Greenstein 1941. g in (-1, 1) is the mean cosine. 1 + g^2 - 2 g cosine is written as a sum of
/// terms that are not negative, so that narrow lobes keep their digits.
FN real henyey_greenstein_phase(real cosine, real g) {
    real size = g < real(0.0) ? -g : g;
    real off_axis = max(real(0.0), g < real(0.0) ? real(1.0) + cosine : real(1.0) - cosine);
    real d = (real(1.0) - size) * (real(1.0) - size) + real(2.0) * size * off_axis;
    return isotropic_phase() * (real(1.0) - g) * (real(1.0) + g) / (d * sqrt(d));
}

/// Two lobes of Henyey and Greenstein; the first takes `share`.
FN real two_lobe_phase(real cosine, real g, real back_g, real share) {
    return share * henyey_greenstein_phase(cosine, g) +
           (real(1.0) - share) * henyey_greenstein_phase(cosine, back_g);
}

// Fournier & Forand 1994 in the form of Fournier & Jonasz 1999 (Jonasz & Fournier, Light Scattering by
// Particles in Water, 2007): particles of refractive index n against the water whose sizes follow a power law
// of exponent `slope`, in the anomalous diffraction approximation, with a term for the backward directions.
// n in (1, 2], slope in (3, 5). With s = sin^2(angle / 2), nu = (3 - slope) / 2 in (-1, 0) and
// delta = 4 s / (3 (n - 1)^2).

/// delta at s = 1.
FN real fournier_forand_scale(real n) {
    return real(4.0) / (real(3.0) * (n - real(1.0)) * (n - real(1.0)));
}

/// The factor of 3 cosine^2 - 1 in the backward term, times 4 pi.
FN real fournier_forand_back(real scale, real nu) {
    return real(0.25) * (pow(scale, -nu) - real(1.0)) / (scale - real(1.0));
}

/// Share of the light that is scattered by less than the angle of s, in [0, 1].
FN real fournier_forand_within(real s, real n, real slope) {
    real nu = real(0.5) * (real(3.0) - slope);
    real scale = fournier_forand_scale(n);
    real cosine = real(1.0) - real(2.0) * s;
    real back = real(2.0) * fournier_forand_back(scale, nu) * cosine * s * (real(1.0) - s);
    real delta = scale * s;
    real power = pow(delta, -nu);
    real e = real(1.0) - delta;
    if (e > real(-1e-3) && e < real(1e-3)) {
        // To second order in e: (delta^-nu - delta - (delta^-nu - 1) s) / e.
        real slope_of_power = nu + real(0.5) * nu * (nu + real(1.0)) * e;
        return real(1.0) + slope_of_power * (real(1.0) - s) + back;
    }
    return (power - delta - (power - real(1.0)) * s) / e + back;
}

/// p grows without bound towards 0 as s^(-1 - nu), which can be integrated. Nearer than 2.4e-4 rad to
/// straight on, s < 2^-26, directions that the cosine in float does not tell apart, p is its mean over that
/// cone in closed form: no light is lost and nothing is infinite.
FN real fournier_forand_phase(real cosine, real n, real slope) {
    real least = real(1.4901161193847656e-8);
    real s = real(0.5) * (real(1.0) - cosine);
    if (s < least) return isotropic_phase() * fournier_forand_within(least, n, slope) / least;
    s = min(s, real(1.0));
    real nu = real(0.5) * (real(3.0) - slope);
    real scale = fournier_forand_scale(n);
    real delta = scale * s;
    real e = real(1.0) - delta;
    real power = pow(delta, -nu);
    // q = (1 - delta^nu - nu e) / e^2, r = delta q - nu; the forward term is delta^-nu (r / s - q) / (4 pi).
    real q, r;
    if (e > real(-0.25) && e < real(0.25)) {
        // Where numerator and denominator of q vanish together: 1 - (1 - e)^nu as a series in e.
        q = real(0.0);
        for (int k = 24; k >= 3; --k) q = (q + real(1.0)) * e * (real(k - 1) - nu) / real(k);
        q = real(0.5) * nu * (real(1.0) - nu) * (q + real(1.0));
        r = delta * q - nu;
    } else {
        real rest = real(1.0) - real(1.0) / power;
        q = (rest - nu * e) / (e * e);
        r = (delta * rest - nu * e) / (e * e);
    }
    return isotropic_phase() * (power * (r / s - q) +
                                fournier_forand_back(scale, nu) * (real(3.0) * cosine * cosine - real(1.0)));
}
