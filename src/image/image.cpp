#include "image/image.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace dapple::image {

const Channel* Image::find(const std::string& name) const {
    const auto found = std::ranges::find(channels, name, &Channel::name);
    return found == channels.end() ? nullptr : &*found;
}

Channel* Image::find(const std::string& name) {
    return const_cast<Channel*>(std::as_const(*this).find(name));
}

Channel& Image::add(const std::string& name, PixelType type) {
    assert(find(name) == nullptr);
    return channels.emplace_back(Channel{name, type, std::vector<float>(pixels())});
}

}  // namespace dapple::image
