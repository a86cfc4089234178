// The phase function of the medium that beams are in, p [1/sr].
#ifdef TABLE
// p evenly over sqrt(sin(angle / 2)), so that forward peaks are as finely resolved as they are narrow.
layout(scalar, binding = 3) readonly buffer PhaseTable { float phase_table[]; };

float phase(float cosine) {
    int last = phase_table.length() - 1;
    float place = sqrt(sqrt(max(0.0, 0.5 - 0.5 * cosine))) * float(last);
    int before = clamp(int(place), 0, last - 1);
    return mix(phase_table[before], phase_table[before + 1], place - float(before));
}
#else
#include "optics/language.h"
#include "optics/phase.h"

float phase(float cosine) { return two_lobe_phase(cosine, push.phase.x, push.phase.y, push.phase.z); }
#endif
