#pragma once

#include <openvdb/openvdb.h>

/// OpenVDB's own library holds the code of these grids; a source that includes this header links with that
/// code. One that instantiates them anew takes a minute and a half to compile, and three under the
/// sanitizers.
#define DAPPLE_OPENVDB_HOLDS(Held)                      \
    extern template class openvdb::Grid<openvdb::Held>; \
    extern template class openvdb::tree::Tree<openvdb::Held::RootNodeType>;
DAPPLE_OPENVDB_HOLDS(FloatTree)
DAPPLE_OPENVDB_HOLDS(DoubleTree)
DAPPLE_OPENVDB_HOLDS(Vec3STree)
DAPPLE_OPENVDB_HOLDS(BoolTree)
DAPPLE_OPENVDB_HOLDS(Int32Tree)
#undef DAPPLE_OPENVDB_HOLDS
