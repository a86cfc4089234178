#pragma once

namespace dapple::judge {

/// A rectangle of pixels.
struct Box {
    int x = 0, y = 0, width = 0, height = 0;
};

}  // namespace dapple::judge
