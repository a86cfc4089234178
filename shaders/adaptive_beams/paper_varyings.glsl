// A beam on its way from vertices to fragments: WAY is out or in. Fields are those of PaperBeam.
layout(location = 0) flat WAY vec4 base_end_0;
layout(location = 1) flat WAY vec4 base_end_1;
layout(location = 2) flat WAY vec4 base_end_2;
layout(location = 3) flat WAY vec4 along_bias_0;
layout(location = 4) flat WAY vec3 along_1;
layout(location = 5) flat WAY vec3 along_2;
layout(location = 6) flat WAY vec3 beam_normal;
layout(location = 7) flat WAY vec3 area;
layout(location = 8) flat WAY vec3 flux;
#ifdef BOUNDED
layout(location = 9) flat WAY int beam_index;
#endif
