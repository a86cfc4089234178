#ifndef DAPPLE_QUOTIENT_GLSL
#define DAPPLE_QUOTIENT_GLSL
// The first 12 bits of a number; the rest of it has 12 too, so that products of such parts are exact.
float head_of(float x) { return intBitsToFloat(floatBitsToInt(x) & 0xfffff000); }

// Rounded as the CPU's division is: a device's own may be 2.5 units in the last place off, which where a long edge
// passes the square becomes far more by cancellation. What is left of a is found without fma, which not every device
// fuses.
float quotient(float a, float b) {
    precise float first = a / b;
    float head = head_of(first), divisor_head = head_of(b);
    precise float tail = first - head, divisor_tail = b - divisor_head;
    precise float left =
        (((a - head * divisor_head) - head * divisor_tail) - tail * divisor_head) - tail * divisor_tail;
    precise float better = first + left / b;
    return abs(better) <= 3.4e38 ? better : first;  // not where the first one overflows
}
#endif
