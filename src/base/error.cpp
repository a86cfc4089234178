#include "base/error.h"

namespace dapple {

std::string clipped(const std::string& library_message) {
    constexpr std::size_t longest = 1023;
    const bool fits = library_message.size() <= longest;
    std::string text = library_message.substr(0, fits ? longest : longest - 4);
    for (char& c : text) {
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
    }
    return fits ? text : text + " ...";
}

}  // namespace dapple
