// Phase functions, p [1/sr]: of the water that beams are in, and with BOUNDED of the other media.
#if defined(TABLE) || defined(BOUNDED)
// p evenly over sqrt(sin(angle / 2)), so that forward peaks are as finely resolved as they are narrow; the water's
// first, then of other media.
layout(scalar, binding = 3) readonly buffer PhaseTable { float phase_table[]; };

float tabulated_phase(float cosine, int first) {
    const int last = int(kPhaseValues) - 1;
    float place = sqrt(sqrt(max(0.0, 0.5 - 0.5 * cosine))) * float(last);
    int before = clamp(int(place), 0, last - 1);
    return mix(phase_table[first + before], phase_table[first + before + 1], place - float(before));
}
#endif
#ifndef TABLE
#include "optics/language.h"
#include "optics/phase.h"
#endif

#ifdef BOUNDED
float lobes_or_table(float cosine, vec3 lobes, int table) {
    return table < 0 ? two_lobe_phase(cosine, lobes.x, lobes.y, lobes.z) : tabulated_phase(cosine, table);
}

// Of a sum of lobes the share is never negative.
float phase(float cosine) { return lobes_or_table(cosine, push.phase, push.phase.z < 0.0 ? 0 : -1); }

float phase_of(float cosine, uint medium) {
    return lobes_or_table(cosine, media[medium].lobes, media[medium].phase_table);
}
#elif defined(TABLE)
float phase(float cosine) { return tabulated_phase(cosine, 0); }
#else
float phase(float cosine) { return two_lobe_phase(cosine, push.phase.x, push.phase.y, push.phase.z); }
#endif
