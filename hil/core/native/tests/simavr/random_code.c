#include "random_code.h"

/* An opcode: its fixed bits, which bits are drawn, and what of it is left out. */
enum rule { ANY, IO_BITS, IO_BYTE, POINTER_X, POINTER_Y, POINTER_Z, FLASH_POINTER, ADDRESS, TARGET };
static const struct shape {
    uint16_t fixed, drawn;
    uint8_t rule;
} SHAPES[] = {
    {0x0000, 0x0000, ANY},       {0x0100, 0x00ff, ANY},       {0x0200, 0x00ff, ANY},       {0x0300, 0x0077, ANY}, /* MULSU */
    {0x0308, 0x0077, ANY},       {0x0380, 0x0077, ANY},       {0x0388, 0x0077, ANY}, /* FMUL* */
    {0x0400, 0x03ff, ANY},       {0x0800, 0x03ff, ANY},       {0x0c00, 0x03ff, ANY},       {0x1000, 0x03ff, ANY}, /* CPC to CPSE */
    {0x1400, 0x03ff, ANY},       {0x1800, 0x03ff, ANY},       {0x1c00, 0x03ff, ANY},       {0x2000, 0x03ff, ANY}, /* CP to AND */
    {0x2400, 0x03ff, ANY},       {0x2800, 0x03ff, ANY},       {0x2c00, 0x03ff, ANY}, /* EOR OR MOV */
    {0x3000, 0x0fff, ANY},       {0x4000, 0x0fff, ANY},       {0x5000, 0x0fff, ANY},       {0x6000, 0x0fff, ANY}, /* CPI to ORI */
    {0x7000, 0x0fff, ANY},       {0xe000, 0x0fff, ANY},       {0xe000, 0x0fff, ANY}, /* ANDI LDI */
    {0x8000, 0x2df7, ANY},       {0x8008, 0x2df7, ANY},       {0x8200, 0x2df7, ANY},       {0x8208, 0x2df7, ANY}, /* LDD STD */
    {0x9000, 0x01f0, ADDRESS},   {0x9200, 0x01f0, ADDRESS}, /* LDS STS */
    {0x9001, 0x01f0, POINTER_Z}, {0x9002, 0x01f0, POINTER_Z}, {0x9201, 0x01f0, POINTER_Z}, {0x9202, 0x01f0, POINTER_Z},
    {0x9009, 0x01f0, POINTER_Y}, {0x900a, 0x01f0, POINTER_Y}, {0x9209, 0x01f0, POINTER_Y}, {0x920a, 0x01f0, POINTER_Y},
    {0x900d, 0x01f0, POINTER_X}, {0x900e, 0x01f0, POINTER_X}, {0x920d, 0x01f0, POINTER_X}, {0x920e, 0x01f0, POINTER_X},
    {0x900c, 0x01f0, ANY},       {0x920c, 0x01f0, ANY},       {0x900f, 0x01f0, ANY},       {0x920f, 0x01f0, ANY}, /* X, POP PUSH */
    {0x9004, 0x01f0, ANY},       {0x9005, 0x01f0, FLASH_POINTER}, {0x95c8, 0x0000, ANY}, /* LPM */
    {0x9400, 0x01f0, ANY},       {0x9401, 0x01f0, ANY},       {0x9402, 0x01f0, ANY},       {0x9403, 0x01f0, ANY}, /* COM to INC */
    {0x9405, 0x01f0, ANY},       {0x9406, 0x01f0, ANY},       {0x9407, 0x01f0, ANY},       {0x940a, 0x01f0, ANY}, /* ASR to DEC */
    {0x9408, 0x00f0, ANY},       {0x9478, 0x0000, ANY},       {0x9478, 0x0000, ANY}, /* BSET, BCLR; SEI */
    {0x940c, 0x0000, TARGET},    {0x940e, 0x0000, TARGET},    {0x9409, 0x0000, ANY},       {0x9509, 0x0000, ANY}, /* JMP to ICALL */
    {0x9508, 0x0000, ANY},       {0x9518, 0x0000, ANY}, /* RET RETI */
    {0x9588, 0x0000, ANY},       {0x9598, 0x0000, ANY},       {0x95a8, 0x0000, ANY},       {0x95e8, 0x0000, ANY}, /* SLEEP to SPM */
    {0x9600, 0x00ff, ANY},       {0x9700, 0x00ff, ANY}, /* ADIW SBIW */
    {0x9800, 0x0007, IO_BITS},   {0x9900, 0x0007, IO_BITS},   {0x9a00, 0x0007, IO_BITS},   {0x9b00, 0x0007, IO_BITS},
    {0x9c00, 0x03ff, ANY},       {0xb000, 0x01f0, IO_BYTE},   {0xb800, 0x01f0, IO_BYTE}, /* MUL IN OUT */
    {0xc000, 0x0fff, ANY},       {0xd000, 0x0fff, ANY}, /* RJMP RCALL */
    {0xf000, 0x03ff, ANY},       {0xf000, 0x03ff, ANY},       {0xf400, 0x03ff, ANY},       {0xf400, 0x03ff, ANY}, /* branches */
    {0xf800, 0x01f7, ANY},       {0xfa00, 0x01f7, ANY},       {0xfc00, 0x01f7, ANY},       {0xfe00, 0x01f7, ANY}, /* BLD to SBRS */
};
enum { SHAPE_COUNT = sizeof(SHAPES) / sizeof(*SHAPES), FIRST_TARGET = 0x100, WORDS = 0x4000, RAM = 0x100, RAM_BYTES = 0x800 };

/* GPIOR0 to 2, SPL, SPH, SREG: what has nothing behind it. */
static const uint8_t IO[6] = {0x1e, 0x2a, 0x2b, 0x3d, 0x3e, 0x3f};
static const uint8_t FLAGS[3] = {0x15, 0x16, 0x17}; /* TIFR0 to 2 */
enum { TCNT0 = 0x26, TCNT2 = 0xb2 };

/* Whether an opcode's register is one of a pair's: loads and stores that change their pointer with it are undefined. */
static int is_of_pair(unsigned word, unsigned pair) { return (word >> 4 & 0x1e) == pair; }

static unsigned second_word(chance *c, enum rule rule, int is_load)
{
    if (rule == TARGET) return FIRST_TARGET + draw_below(c, WORDS - FIRST_TARGET);
    if (is_load && !draw_below(c, 16)) return TCNT2;
    return draw_below(c, 16) ? RAM + draw_below(c, RAM_BYTES) : 0x20u + IO[draw_below(c, 6)];
}

void random_code(chance *c, uint16_t *words, unsigned n)
{
    for (unsigned i = 0; i < n; i++) {
        const struct shape *s = &SHAPES[draw_below(c, SHAPE_COUNT)];
        unsigned word = s->fixed | (draw(c) & s->drawn), io = IO[draw_below(c, 6)];
        if (s->rule == IO_BYTE && !draw_below(c, 4)) io = FLAGS[draw_below(c, 3)];
        if (s->fixed == 0xb000 && !draw_below(c, 8)) io = TCNT0;
        int is_long = s->rule == ADDRESS || s->rule == TARGET;
        if (is_long && i + 1 == n) word = 0;
        if (s->rule == IO_BITS) word |= (draw_below(c, 4) ? 0x1eu : FLAGS[draw_below(c, 3)]) << 3;
        if (s->rule == IO_BYTE) word |= (io & 15) | (io & 0x30) << 5;
        if ((s->rule == POINTER_X && is_of_pair(word, 26)) || (s->rule == POINTER_Y && is_of_pair(word, 28)) ||
            ((s->rule == POINTER_Z || s->rule == FLASH_POINTER) && is_of_pair(word, 30)))
            word ^= 0x80; /* another register */
        words[i] = (uint16_t)word;
        if (is_long && i + 1 < n) words[++i] = (uint16_t)second_word(c, (enum rule)s->rule, s->fixed == 0x9000);
    }
}
