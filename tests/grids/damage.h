#pragma once

namespace dapple::grids {

/// Damages a file of Blender's in `count` ways (bits flipped, cut, overwritten), which follow from `seed`,
/// and expects each to end in a grid or in an Error of at most 1 KiB and one line.
void expect_damage_is_survived(unsigned seed, int count);

}  // namespace dapple::grids
