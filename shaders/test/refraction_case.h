// Input and output of test/refraction.comp, also read by C++ (float, scalar layout).
struct RefractionInput {
    vec3 incident;  // unit, along the travel of light
    vec3 normal;    // unit, dot(incident, normal) <= 0
    float eta;      // index left over index entered
};
struct RefractionOutput {
    vec3 refracted;
    vec3 reflected;
    float cos_t;          // -1: total reflection
    float reflectance;    // by fresnel_reflectance
    float transmittance;  // by fresnel_transmittance
    uint transmitted;     // 0: total reflection
};
