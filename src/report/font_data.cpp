#include "report/font.h"

// The assembler copies the file as it stands: an array of three quarters of a million numbers would take the
// compiler seconds.
asm(R"(
    .section .rodata
    .balign 16
dapple_font_begin:
    .incbin ")" DAPPLE_FONT R"("
dapple_font_end:
    .byte 0
    .text
)");

extern "C" {
// Local to this file's assembly.
extern const unsigned char dapple_font_begin[];
extern const unsigned char dapple_font_end[];
}

namespace dapple::report {

std::span<const unsigned char> font_data() {
    return {dapple_font_begin, dapple_font_end};
}

}  // namespace dapple::report
