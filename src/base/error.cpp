#include "base/error.h"

namespace dapple {

std::string clipped(const std::string& library_message) {
    constexpr std::size_t longest = 1024;
    std::string text = library_message.substr(0, longest);
    for (char& c : text) {
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
    }
    if (library_message.size() > longest) text += " ...";
    return text;
}

}  // namespace dapple
