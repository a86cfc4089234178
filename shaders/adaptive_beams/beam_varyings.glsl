// A beam on its way from vertices to fragments, the same for all of its fragments: WAY is out or in. Fields are
// those of DrawnBeam.
layout(location = 0) flat WAY vec4 ray_0;
layout(location = 1) flat WAY vec4 ray_1;
layout(location = 2) flat WAY vec4 ray_2;
layout(location = 3) flat WAY vec4 area_0;
layout(location = 4) flat WAY vec4 area_1;
layout(location = 5) flat WAY vec4 area_2;
layout(location = 6) flat WAY vec4 flux_start_0;
layout(location = 7) flat WAY vec4 flux_start_1;
layout(location = 8) flat WAY vec4 flux_start_2;
layout(location = 9) flat WAY vec4 end_bias;
layout(location = 10) flat WAY ivec3 listed_ends_on;
layout(location = 11) flat WAY vec4 flux_start_bias;
#ifdef BOUNDED
layout(location = 12) flat WAY int beam_index;
#endif
