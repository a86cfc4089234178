#pragma once

namespace dapple::reference {

/// Where the light of some rays has gone, W (mean of the channels): what was emitted into the chains that
/// are asked for is the sum of all the others, but for the noise of media.
struct EnergyAccount {
    double emitted = 0;   ///< went on from a first event
    double arrived = 0;   ///< on diffuse surfaces
    double escaped = 0;   ///< met nothing any more
    double absorbed = 0;  ///< by media (scattered light counts), glass and mirrors
    /// Branches too weak to follow, chains too long or of a kind that is left out, and rays that lost their
    /// way between the surfaces of a body of glass by rounding.
    double weak = 0, long_chains = 0, left_out = 0, astray = 0;

    void add(const EnergyAccount& other) {
        emitted += other.emitted;
        arrived += other.arrived;
        escaped += other.escaped;
        absorbed += other.absorbed;
        weak += other.weak;
        long_chains += other.long_chains;
        left_out += other.left_out;
        astray += other.astray;
    }
};

}  // namespace dapple::reference
