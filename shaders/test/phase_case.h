// Input and output of test/phase.comp, also read by C++ (float, scalar layout).
struct PhaseInput {
    float cosine;
    float g;      // mean cosine
    float index;  // of particles
    float slope;  // of their sizes
};
struct PhaseOutput {
    float isotropic;  // all 1/sr but `within`, a share
    float henyey_greenstein;
    float two_lobe;
    float fournier_forand;
    float within;
};
