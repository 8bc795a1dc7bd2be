/* Opcodes of AVRe+, taken apart once: kinds of instructions, and their operands. */
#ifndef HIL_AVR_DECODE_H
#define HIL_AVR_DECODE_H

#include "avr_state.h"

enum avr_kind {
#define KIND(name) OP_##name,
#include "avr_kinds.def"
#undef KIND
    OP_KINDS
};

/* An instruction as it is run: its kind and its operands. */
static inline avr_op avr_op_of(int kind, unsigned a, unsigned b) { return (avr_op)kind | a << 8 | b << 16; }
static inline int avr_kind_of(avr_op o) { return o & 0xff; }
static inline unsigned avr_a_of(avr_op o) { return o >> 8 & 0xff; }
static inline unsigned avr_b_of(avr_op o) { return o >> 16; }
/* Takes apart flash words from `first` on; those before it too whose meaning hangs on them. */
void avr_decode(avr *m, uint32_t first, uint32_t n);

/* The instruction at a word, whether a breakpoint stands there or not. */
avr_op avr_op_at(const avr *m, unsigned at);

/* Whether what it does to data space happens at its end, after all that happens at that clock; else it is before. */
static inline int avr_is_writing(int kind) { return kind > OP_RETI && kind <= OP_WDR; }

#endif
