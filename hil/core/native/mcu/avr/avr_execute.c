#pragma GCC optimize("no-tree-slp-vectorize") /* it would gather flags in vectors, from one instruction to the next */

#include "avr_execute.h"

#include "avr_decode.h"
#include "avr_io.h"
#include "avr_registers.h"
#include "avr_time.h"

enum { LAST = AVR_FLASH_WORDS - 1, X = 26, Y = 28, Z = 30 };

/* The status register in pieces, as instructions leave them: most are never looked at.

   With d and k the operands, R = d + k or d - k in 32 bits, d ^ k ^ R has the carry into bit i in its bit i. So H is its bit 4, V
   bits 7 and 8 being unlike. Bits 9 and 10 are alike but where a program wrote an S that is not N ^ V: then they tell so. */
typedef struct flags {
    unsigned c; /* 0 or 1 */
    unsigned z; /* 0: Z is set */
    unsigned n; /* bit 7 */
    unsigned h; /* bit 4 */
    unsigned v; /* bits 7 to 10 */
    unsigned t_i; /* T and I, as in SREG */
} flags;

static inline unsigned v_of(flags f) { return (f.v ^ f.v >> 1) >> 7 & 1; }
static inline unsigned s_of(flags f) { return ((f.n ^ f.v ^ f.v >> 1) >> 7 ^ (f.v ^ f.v >> 1) >> 9) & 1; }

static inline uint8_t packed(flags f)
{
    return (uint8_t)((f.t_i & (FLAG_T | FLAG_I)) | (f.h << 1 & FLAG_H) | s_of(f) << 4 | v_of(f) << 3 | (f.n >> 5 & FLAG_N) |
                     (f.z ? 0 : FLAG_Z) | f.c);
}

static inline flags unpacked(unsigned sreg)
{
    unsigned is_odd = (sreg >> 4 ^ sreg >> 3 ^ sreg >> 2) & 1;
    return (flags){.c = sreg & FLAG_C, .z = ~sreg & FLAG_Z, .n = sreg << 5 & 0x80, .h = sreg >> 1 & 0x10,
                   .v = (sreg << 4 & 0x80) | is_odd << 9, .t_i = sreg};
}

static inline unsigned word(const uint8_t *r, int n) { return r[n] | (unsigned)r[n + 1] << 8; }

static inline void set_word(uint8_t *r, int n, unsigned value)
{
    r[n] = (uint8_t)value;
    r[n + 1] = (uint8_t)(value >> 8);
}

static inline int is_sram(unsigned address) { return address - 0x100 < AVR_DATA_BYTES - 0x100; }

static inline void push(avr *m, unsigned value, uint64_t at)
{
    unsigned sp = m->sp--;
    if (__builtin_expect(sp < m->stack_lowest, 0)) {
        m->stack_lowest = (uint16_t)sp;
        if (sp < m->stack_floor) avr_note_once(m, AVR_NOTE_STACK, (uint16_t)sp);
    }
    if (is_sram(sp)) m->data[sp] = (uint8_t)value;
    else avr_store(m, sp, (uint8_t)value, at);
}

static inline unsigned pop(avr *m, uint64_t at)
{
    unsigned sp = ++m->sp;
    return is_sram(sp) ? m->data[sp] : avr_load(m, sp, at);
}

static inline void push_pc(avr *m, unsigned pc, uint64_t at)
{
    push(m, pc, at);
    push(m, pc >> 8, at);
}

static inline unsigned pop_pc(avr *m, uint64_t at)
{
    unsigned high = pop(m, at);
    return (high << 8 | pop(m, at)) & LAST;
}

int avr_length(avr *m)
{
    const avr_op o = avr_op_at(m, m->pc);
    const int kind = avr_kind_of(o);
    const unsigned a = avr_a_of(o), b = avr_b_of(o), bit = b & 0xff, over = 1 + (b >> 8);
    const uint8_t *r = m->data;
    switch (kind) {
    case OP_ADIW: case OP_SBIW: case OP_MUL: case OP_MULS: case OP_MULSU: case OP_FMUL: case OP_FMULS: case OP_FMULSU:
    case OP_SBI: case OP_CBI: case OP_RJMP: case OP_IJMP: return 2;
    case OP_LPM: case OP_LPM_INC: case OP_JMP: case OP_RCALL: case OP_ICALL: return 3;
    case OP_CALL: case OP_RET: case OP_RETI: return 4;
    case OP_CPSE: return r[a] == r[b & 31] ? (int)over : 1;
    case OP_SBRC: return r[a] & bit ? 1 : (int)over;
    case OP_SBRS: return r[a] & bit ? (int)over : 1;
    case OP_SBIC: return avr_load(m, a, m->t) & bit ? 1 : (int)over;
    case OP_SBIS: return avr_load(m, a, m->t) & bit ? (int)over : 1;
    default: break;
    }
    if (kind >= OP_BRCS && kind <= OP_BRID) return (m->sreg >> ((kind - OP_BRCS) & 7) & 1) == (kind < OP_BRCC) ? 2 : 1;
    return (kind >= OP_LD_X && kind <= OP_POP) || (kind >= OP_ST_X && kind <= OP_PUSH) ? 2 : 1;
}

void avr_enter(avr *m, int vector)
{
    uint64_t end = m->t + 4;
    push_pc(m, m->pc, end);
    m->sreg &= (uint8_t)~FLAG_I;
    m->pc = (uint16_t)(vector * 2 + (m->data[MCUCR] & IVSEL ? avr_boot_start(m) : 0));
    m->t = end;
}

/* What follows reads as a table: NAME: what it does, and its clocks. `left` are clocks until `end`; t is end - left, where
   the instruction began, until NEXT. */
#define A avr_a_of(o)
#define B avr_b_of(o)
#define BIT (B & 0xff)
#define BEGAN (end - (uint64_t)left)
#define NEXT(clocks)                                                                                      \
    do {                                                                                                  \
        left -= (clocks);                                                                                 \
        if (__builtin_expect(left <= 0, 0)) goto done;                                                    \
        o = ops[pc++];                                                                                    \
        goto *labels[o & 0xff];                                                                           \
    } while (0)
/* What may have changed when the next thing happens. */
#define LOOK_AFTER(clocks)                                                                                \
    do {                                                                                                  \
        if (m->attention) NEXT(clocks);                                                                   \
        left -= (clocks);                                                                                 \
        goto done;                                                                                        \
    } while (0)
#define LOGIC(result) do { unsigned R = (result); r[A] = (uint8_t)R; f.z = f.n = R; f.v = 0; NEXT(1); } while (0)
#define ADDED(k, carry)                                                                                   \
    do {                                                                                                  \
        unsigned d_ = r[A], k_ = (k), R = d_ + k_ + (carry);                                              \
        f.z = f.n = r[A] = (uint8_t)R, f.c = R >> 8, f.h = f.v = d_ ^ k_ ^ R;                             \
        NEXT(1);                                                                                          \
    } while (0)
/* R = d - k - c: kept or not, Z of it alone or of what was before, too. */
#define SUBTRACTED(k, carry, kept, zero)                                                                  \
    do {                                                                                                  \
        unsigned d_ = r[A], k_ = (k), R = d_ - k_ - (carry);                                              \
        f.n = (uint8_t)R, f.c = R >> 31, f.h = f.v = d_ ^ k_ ^ R;                                         \
        f.z = (zero) | f.n;                                                                               \
        if (kept) r[A] = (uint8_t)R;                                                                      \
        NEXT(1);                                                                                          \
    } while (0)
#define SHIFTED(result, carry)                                                                            \
    do {                                                                                                  \
        unsigned c_ = (carry);                                                                            \
        f.z = f.n = r[A] = (uint8_t)(result), f.c = c_, f.v = (f.n & 0x80) | c_ << 8;                     \
        NEXT(1);                                                                                          \
    } while (0)
#define PRODUCT(left_, right_) do { unsigned R = (unsigned)((left_) * (right_)); set_word(r, 0, R); f.c = R >> 15 & 1; f.z = R & 0xffff; NEXT(2); } while (0)
#define FRACTION(left_, right_) do { unsigned R = (unsigned)((left_) * (right_)); f.c = R >> 15 & 1; R = R << 1 & 0xffff; set_word(r, 0, R); f.z = R; NEXT(2); } while (0)
#define ADDED_WORD(result, overflow)                                                                      \
    do {                                                                                                  \
        unsigned d = word(r, (int)A), R = (result);                                                       \
        set_word(r, (int)A, R);                                                                           \
        f.n = R >> 8, f.z = R & 0xffff, f.c = R >> 16 & 1, f.v = (overflow) >> 8 & 0x80;                  \
        NEXT(2);                                                                                          \
    } while (0)
#define LOAD(address, then)                                                                               \
    do {                                                                                                  \
        unsigned at_ = (address) & 0xffff;                                                                \
        if (__builtin_expect(is_sram(at_), 1)) {                                                          \
            unsigned got_ = r[at_];                                                                       \
            then;                                                                                         \
            r[A] = (uint8_t)got_;                                                                         \
            NEXT(2);                                                                                      \
        }                                                                                                 \
        m->sreg = packed(f);                                                                              \
        uint8_t got_ = avr_load(m, at_, BEGAN + 1);                                                       \
        then;                                                                                             \
        r[A] = got_;                                                                                      \
        LOOK_AFTER(2);                                                                                    \
    } while (0)
#define STORE(address, then)                                                                              \
    do {                                                                                                  \
        unsigned at_ = (address) & 0xffff, put_ = r[A];                                                   \
        then;                                                                                             \
        if (__builtin_expect(is_sram(at_), 1)) {                                                          \
            r[at_] = (uint8_t)put_;                                                                       \
            NEXT(2);                                                                                      \
        }                                                                                                 \
        m->sreg = packed(f);                                                                              \
        avr_store(m, at_, (uint8_t)put_, BEGAN + 2);                                                      \
        f = unpacked(m->sreg);                                                                            \
        LOOK_AFTER(2);                                                                                    \
    } while (0)
#define INCREMENTED(way, pointer) do { unsigned p_ = word(r, pointer); way(p_, set_word(r, pointer, p_ + 1)); } while (0)
#define DECREMENTED(way, pointer) do { unsigned p_ = word(r, pointer) - 1; way(p_, set_word(r, pointer, p_)); } while (0)
/* Where the stack is beyond SRAM, it may be in SREG. */
#define STACKED(action, clocks)                                                                           \
    do {                                                                                                  \
        if (__builtin_expect(m->sp > 0x102 && m->sp < AVR_DATA_BYTES - 3, 1)) { action; }                 \
        else { m->sreg = packed(f); action; f = unpacked(m->sreg); }                                      \
        LOOK_AFTER(clocks);                                                                               \
    } while (0)
#define SKIP(condition) do { if (condition) { pc += B >> 8; left -= (int64_t)(B >> 8); } NEXT(1); } while (0)
#define BRANCH(condition) do { if (condition) { pc = B; NEXT(2); } NEXT(1); } while (0)

/* I has been set: one instruction more before an interrupt. Nothing can ask for one before that where nothing does now and
   instructions alone run until then. */
#define HOLD(clocks) do { if (m->asking || is_single) m->is_held = 1, m->attention = 0; LOOK_AFTER(clocks); } while (0)

void avr_execute(avr *m)
{
    static const void *const labels[OP_KINDS] = {
#define KIND(name) &&name,
#include "avr_kinds.def"
#undef KIND
    };
    uint8_t *const r = m->data;
    const avr_op *const ops = m->ops;
    const int is_single = m->t >= m->attention;
    int64_t left = is_single ? 1 : (int64_t)(m->attention - m->t);
    const uint64_t end = m->t + (uint64_t)left;
    flags f = unpacked(m->sreg);
    unsigned pc = m->pc;
    avr_op o;
    m->attention = end;
    if (__builtin_expect(m->is_passing, 0)) {
        m->is_passing = 0;
        o = avr_op_at(m, pc++);
        goto *labels[o & 0xff];
    }
    NEXT(0);

NOP: NEXT(1);
MOV: r[A] = r[B]; NEXT(1);
MOVW: set_word(r, (int)A, word(r, (int)B)); NEXT(1);
LDI: r[A] = (uint8_t)B; NEXT(1);
SWAP: r[A] = (uint8_t)(r[A] << 4 | r[A] >> 4); NEXT(1);
ADD: ADDED(r[B], 0);
ADC: ADDED(r[B], f.c);
CP: SUBTRACTED(r[B], 0, 0, 0);
CPI: SUBTRACTED(B, 0, 0, 0);
CPC: SUBTRACTED(r[B], f.c, 0, f.z);
SUB: SUBTRACTED(r[B], 0, 1, 0);
SUBI: SUBTRACTED(B, 0, 1, 0);
SBC: SUBTRACTED(r[B], f.c, 1, f.z);
SBCI: SUBTRACTED(B, f.c, 1, f.z);
AND: LOGIC(r[A] & r[B]);
ANDI: LOGIC(r[A] & B);
OR: LOGIC(r[A] | r[B]);
ORI: LOGIC(r[A] | B);
EOR: LOGIC(r[A] ^ r[B]);
COM: f.c = 1; LOGIC(r[A] ^ 0xffu);
NEG: {
    unsigned d = r[A], R = 0 - d;
    f.z = f.n = r[A] = (uint8_t)R, f.c = R >> 31, f.h = f.v = d ^ R;
    NEXT(1);
}
INC: {
    unsigned d = r[A], R = d + 1;
    f.z = f.n = r[A] = (uint8_t)R, f.v = d ^ 1 ^ R;
    NEXT(1);
}
DEC: {
    unsigned d = r[A], R = d - 1;
    f.z = f.n = r[A] = (uint8_t)R, f.v = d ^ 1 ^ R;
    NEXT(1);
}
LSR: SHIFTED(r[A] >> 1, r[A] & 1u);
ROR: SHIFTED(r[A] >> 1 | f.c << 7, r[A] & 1u);
ASR: SHIFTED((int8_t)r[A] >> 1, r[A] & 1u);
ADIW: ADDED_WORD(d + B, ~d & R);
SBIW: ADDED_WORD(d - B, d & ~R);
MUL: PRODUCT(r[A], r[B]);
MULS: PRODUCT((int8_t)r[A], (int8_t)r[B]);
MULSU: PRODUCT((int8_t)r[A], r[B]);
FMUL: FRACTION(r[A], r[B]);
FMULS: FRACTION((int8_t)r[A], (int8_t)r[B]);
FMULSU: FRACTION((int8_t)r[A], r[B]);
BSET: f = unpacked(packed(f) | B); NEXT(1);
BCLR: f = unpacked(packed(f) & ~B); NEXT(1);
BST: f.t_i = (f.t_i & ~(unsigned)FLAG_T) | (r[A] & B ? FLAG_T : 0); NEXT(1);
BLD: r[A] = (uint8_t)(f.t_i & FLAG_T ? r[A] | B : r[A] & ~B); NEXT(1);
CLI: f.t_i &= ~(unsigned)FLAG_I; NEXT(1);
SEI:
    if (f.t_i & FLAG_I) NEXT(1);
    f.t_i |= FLAG_I;
    HOLD(1);

LD_X: LOAD(word(r, X), (void)0);
LD_X_INC: INCREMENTED(LOAD, X);
LD_X_DEC: DECREMENTED(LOAD, X);
LD_Y_INC: INCREMENTED(LOAD, Y);
LD_Y_DEC: DECREMENTED(LOAD, Y);
LD_Z_INC: INCREMENTED(LOAD, Z);
LD_Z_DEC: DECREMENTED(LOAD, Z);
LDD_Y: LOAD(word(r, Y) + B, (void)0);
LDD_Z: LOAD(word(r, Z) + B, (void)0);
LDS: pc++; LOAD(B, (void)0);
ST_X: STORE(word(r, X), (void)0);
ST_X_INC: INCREMENTED(STORE, X);
ST_X_DEC: DECREMENTED(STORE, X);
ST_Y_INC: INCREMENTED(STORE, Y);
ST_Y_DEC: DECREMENTED(STORE, Y);
ST_Z_INC: INCREMENTED(STORE, Z);
ST_Z_DEC: DECREMENTED(STORE, Z);
STD_Y: STORE(word(r, Y) + B, (void)0);
STD_Z: STORE(word(r, Z) + B, (void)0);
STS: pc++; STORE(B, (void)0);
PUSH: STACKED(push(m, r[A], BEGAN + 2), 2);
POP: STACKED(unsigned got_ = pop(m, BEGAN + 1); r[A] = (uint8_t)got_, 2);
LPM: r[A] = avr_flash_byte(m, word(r, Z), BEGAN + 2); NEXT(3);
LPM_INC: {
    unsigned z = word(r, Z);
    uint8_t got = avr_flash_byte(m, z, BEGAN + 2);
    set_word(r, Z, z + 1);
    r[A] = got;
    NEXT(3);
}
SPM: avr_spm(m, (pc - 1) & LAST, BEGAN + 1); LOOK_AFTER(1);
SPM_INC: avr_spm(m, (pc - 1) & LAST, BEGAN + 1); set_word(r, Z, word(r, Z) + 2); LOOK_AFTER(1);

IN: r[A] = B < 0x40 ? avr_load_low(m, B, BEGAN) : avr_load(m, B, BEGAN); LOOK_AFTER(1);
IN_SREG: r[A] = packed(f); NEXT(1);
OUT: avr_store(m, B, r[A], BEGAN + 1); LOOK_AFTER(1);
OUT_SREG: {
    unsigned rises = ~f.t_i & r[A] & FLAG_I;
    f = unpacked(r[A]);
    if (!rises) NEXT(1);
    HOLD(1);
}
SBI: avr_set_bit(m, A, (uint8_t)B, BEGAN + 2); LOOK_AFTER(2);
CBI: avr_clear_bit(m, A, (uint8_t)B, BEGAN + 2); LOOK_AFTER(2);
SBIC: SKIP(!(avr_load_low(m, A, BEGAN) & BIT));
SBIS: SKIP(avr_load_low(m, A, BEGAN) & BIT);
SBRC: SKIP(!(r[A] & BIT));
SBRS: SKIP(r[A] & BIT);
CPSE: SKIP(r[A] == r[B & 31]);
SLEEP: m->sreg = packed(f); m->pc = pc & LAST; avr_sleep(m, BEGAN + 1); LOOK_AFTER(1);
WDR: avr_watchdog_restart(m, BEGAN + 1); LOOK_AFTER(1);

RJMP: pc = B; NEXT(2);
JMP: pc = B; NEXT(3);
IJMP: pc = word(r, Z) & LAST; NEXT(2);
RCALL: STACKED(push_pc(m, pc & LAST, BEGAN + 3); pc = B, 3);
ICALL: STACKED(push_pc(m, pc & LAST, BEGAN + 3); pc = word(r, Z) & LAST, 3);
CALL: STACKED(push_pc(m, (pc + 1) & LAST, BEGAN + 4); pc = B, 4);
RET: STACKED(pc = pop_pc(m, BEGAN + 3), 4);
RETI:
    m->sreg = packed(f);
    pc = pop_pc(m, BEGAN + 3);
    f.t_i |= FLAG_I;
    HOLD(4);
BRCS: BRANCH(f.c);
BRCC: BRANCH(!f.c);
BREQ: BRANCH(!f.z);
BRNE: BRANCH(f.z);
BRMI: BRANCH(f.n & 0x80);
BRPL: BRANCH(!(f.n & 0x80));
BRVS: BRANCH(v_of(f));
BRVC: BRANCH(!v_of(f));
BRLT: BRANCH(s_of(f));
BRGE: BRANCH(!s_of(f));
BRHS: BRANCH(f.h & 0x10);
BRHC: BRANCH(!(f.h & 0x10));
BRTS: BRANCH(f.t_i & FLAG_T);
BRTC: BRANCH(!(f.t_i & FLAG_T));
BRIE: BRANCH(f.t_i & FLAG_I);
BRID: BRANCH(!(f.t_i & FLAG_I));
ILLEGAL: avr_note_once(m, AVR_NOTE_ILLEGAL, (uint16_t)(((pc - 1) & LAST) * 2)); LOOK_AFTER(1);
WRAP: pc = (pc - 1) & LAST; NEXT(0);
BREAK: pc--; m->is_at_break = m->is_stopped = 1; goto done;

done:
    m->sreg = packed(f);
    m->pc = pc & LAST;
    m->t = BEGAN + m->halted;
    m->halted = 0;
}
