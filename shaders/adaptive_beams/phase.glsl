// The phase function of the medium that beams are in.
#include "optics/language.h"
#include "optics/phase.h"

// p [1/sr] evenly over sqrt(sin(angle / 2)), of functions given by a table.
layout(scalar, binding = 3) readonly buffer PhaseTable { float phase_table[]; };

float phase(float cosine) {
    switch (push.phase_type) {
        case 0u:
            return isotropic_phase();
        case 1u:
            return henyey_greenstein_phase(cosine, push.phase.x);
        case 2u:
            return two_lobe_phase(cosine, push.phase.x, push.phase.y, push.phase.z);
        case 3u:
            return fournier_forand_phase(cosine, push.phase.x, push.phase.y);
    }
    int last = phase_table.length() - 1;
    float place = sqrt(sqrt(max(0.0, 0.5 - 0.5 * cosine))) * float(last);
    int before = min(int(place), last - 1);
    return mix(phase_table[before], phase_table[before + 1], place - float(before));
}
