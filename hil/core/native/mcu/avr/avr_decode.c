#include "avr_decode.h"

enum { LAST = AVR_FLASH_WORDS - 1 };

static int is_two_words(unsigned w)
{
    return (w & 0xfe0e) == 0x940e || (w & 0xfe0e) == 0x940c || (w & 0xfc0f) == 0x9000; /* CALL, JMP, LDS and STS */
}

/* 0000 to 0fff, 1000 to 2fff: what has two registers. */
static avr_op two_registers(unsigned w, int next_words)
{
    static const uint8_t kinds[12] = {[1] = OP_CPC, OP_SBC, OP_ADD, OP_CPSE, OP_CP, OP_SUB, OP_ADC, OP_AND, OP_EOR, OP_OR, OP_MOV};
    unsigned d = w >> 4 & 31, r = (w & 15) | (w >> 5 & 16);
    if (w >> 10) {
        int kind = kinds[w >> 10];
        return avr_op_of(kind, d, kind == OP_CPSE ? r | (unsigned)next_words << 8 : r);
    }
    if (w >> 8 == 0) return avr_op_of(w ? OP_ILLEGAL : OP_NOP, 0, 0);
    if (w >> 8 == 1) return avr_op_of(OP_MOVW, (w >> 3) & 30, (w & 15) * 2);
    if (w >> 8 == 2) return avr_op_of(OP_MULS, 16 + (w >> 4 & 15), 16 + (w & 15));
    static const uint8_t muls[4] = {OP_MULSU, OP_FMUL, OP_FMULS, OP_FMULSU};
    return avr_op_of(muls[(w >> 6 & 2) | (w >> 3 & 1)], 16 + (w >> 4 & 7), 16 + (w & 7));
}

/* 9000 to 93ff: loads and stores, each by the low four bits; 0: none. LDS and STS have a word more. */
static avr_op load_or_store(unsigned w, unsigned next)
{
    static const uint8_t loads[16] = {OP_LDS, OP_LD_Z_INC, OP_LD_Z_DEC, 0, OP_LPM, OP_LPM_INC, 0, 0, 0, OP_LD_Y_INC, OP_LD_Y_DEC, 0,
                                      OP_LD_X, OP_LD_X_INC, OP_LD_X_DEC, OP_POP};
    static const uint8_t stores[16] = {OP_STS, OP_ST_Z_INC, OP_ST_Z_DEC, 0, 0, 0, 0, 0, 0, OP_ST_Y_INC, OP_ST_Y_DEC, 0,
                                       OP_ST_X, OP_ST_X_INC, OP_ST_X_DEC, OP_PUSH};
    return avr_op_of((w & 0x200 ? stores : loads)[w & 15], w >> 4 & 31, next);
}

/* 9400 to 95ff: one register, or none. */
static avr_op one_register(unsigned w, unsigned next)
{
    static const uint8_t ones[16] = {OP_COM, OP_NEG, OP_SWAP, OP_INC, 0, OP_ASR, OP_LSR, OP_ROR, [10] = OP_DEC};
    unsigned low = w & 15;
    if (low <= 7 || low == 10) return avr_op_of(ones[low], w >> 4 & 31, 0);
    if (low >= 12) return avr_op_of(low >= 14 ? OP_CALL : OP_JMP, 0, next & LAST); /* 14 bits of address are there */
    if (low == 8 && w < 0x9500) {
        if ((w & 0x7f) == 0x78) return avr_op_of(w & 0x80 ? OP_CLI : OP_SEI, 0, 0);
        return avr_op_of(w & 0x80 ? OP_BCLR : OP_BSET, 0, 1u << (w >> 4 & 7));
    }
    switch (w) {
    case 0x9409: return avr_op_of(OP_IJMP, 0, 0);
    case 0x9508: return avr_op_of(OP_RET, 0, 0);
    case 0x9509: return avr_op_of(OP_ICALL, 0, 0);
    case 0x9518: return avr_op_of(OP_RETI, 0, 0);
    case 0x9588: return avr_op_of(OP_SLEEP, 0, 0);
    case 0x9598: return avr_op_of(OP_NOP, 0, 0); /* BREAK, without debugWIRE */
    case 0x95a8: return avr_op_of(OP_WDR, 0, 0);
    case 0x95c8: return avr_op_of(OP_LPM, 0, 0);
    case 0x95e8: return avr_op_of(OP_SPM, 0, 0);
    case 0x95f8: return avr_op_of(OP_SPM_INC, 0, 0);
    default: return avr_op_of(OP_ILLEGAL, 0, 0);
    }
}

/* 9600 to 9fff: words, bits of I/O, MUL. */
static avr_op word_or_bit(unsigned w, int next_words)
{
    static const uint8_t bits[4] = {OP_CBI, OP_SBIC, OP_SBI, OP_SBIS};
    if (w < 0x9800) return avr_op_of(w & 0x100 ? OP_SBIW : OP_ADIW, 24 + (w >> 3 & 6), (w & 15) | (w >> 2 & 48));
    if (w >= 0x9c00) return avr_op_of(OP_MUL, w >> 4 & 31, (w & 15) | (w >> 5 & 16));
    return avr_op_of(bits[w >> 8 & 3], 32 + (w >> 3 & 31), 1u << (w & 7) | (unsigned)next_words << 8);
}

/* f000 to ffff: branches, and what goes by a bit of a register. */
static avr_op branch_or_bit(unsigned at, unsigned w, int next_words)
{
    unsigned d = w >> 4 & 31, mask = 1u << (w & 7);
    if (w < 0xf800) {
        unsigned away = (w >> 3 & 127) - (w & 0x200 ? 128 : 0);
        return avr_op_of((w & 0x400 ? OP_BRCC : OP_BRCS) + (int)(w & 7), 0, (at + 1 + away) & LAST);
    }
    if (w & 8) return avr_op_of(OP_ILLEGAL, 0, 0); /* FFFFh of an empty flash too */
    switch (w >> 9 & 3) {
    case 0: return avr_op_of(OP_BLD, d, mask);
    case 1: return avr_op_of(OP_BST, d, mask);
    case 2: return avr_op_of(OP_SBRC, d, mask | (unsigned)next_words << 8);
    default: return avr_op_of(OP_SBRS, d, mask | (unsigned)next_words << 8);
    }
}

static avr_op decoded(unsigned at, unsigned w, unsigned next)
{
    int next_words = is_two_words(next) ? 2 : 1;
    unsigned d = 16 + (w >> 4 & 15), k = (w >> 4 & 0xf0) | (w & 15);
    switch (w >> 12) {
    case 0: case 1: case 2: return two_registers(w, next_words);
    case 3: return avr_op_of(OP_CPI, d, k);
    case 4: return avr_op_of(OP_SBCI, d, k);
    case 5: return avr_op_of(OP_SUBI, d, k);
    case 6: return avr_op_of(OP_ORI, d, k);
    case 7: return avr_op_of(OP_ANDI, d, k);
    case 8: case 10: {
        int kind = w & 8 ? (w & 0x200 ? OP_STD_Y : OP_LDD_Y) : (w & 0x200 ? OP_STD_Z : OP_LDD_Z);
        return avr_op_of(kind, w >> 4 & 31, (w & 7) | (w >> 7 & 24) | (w >> 8 & 32));
    }
    case 9: return w < 0x9400 ? load_or_store(w, next) : w < 0x9600 ? one_register(w, next) : word_or_bit(w, next_words);
    case 11: {
        unsigned io = 32 + ((w & 15) | (w >> 5 & 48)), is_sreg = io == 0x5f;
        return avr_op_of(w & 0x800 ? (is_sreg ? OP_OUT_SREG : OP_OUT) : (is_sreg ? OP_IN_SREG : OP_IN), w >> 4 & 31, io);
    }
    case 12: case 13: {
        unsigned away = (w & 0x7ff) - (w & 0x800);
        return avr_op_of(w < 0xd000 ? OP_RJMP : OP_RCALL, 0, (at + 1 + away) & LAST);
    }
    case 14: return avr_op_of(OP_LDI, d, k);
    default: return branch_or_bit(at, w, next_words);
    }
}

avr_op avr_op_at(const avr *m, unsigned at)
{
    avr_op o = m->ops[at];
    return avr_kind_of(o) == OP_BREAK ? decoded(at, m->flash[at], m->flash[(at + 1) & LAST]) : o;
}

void avr_decode(avr *m, uint32_t first, uint32_t n)
{
    for (uint32_t i = 0; i <= n && i <= AVR_FLASH_WORDS; i++) {
        unsigned at = (first + i - 1) & LAST; /* the one before takes it for its second word, or skips it */
        int is_break = m->breaks[at / 8] >> at % 8 & 1;
        m->ops[at] = is_break ? (avr_op)OP_BREAK : decoded(at, m->flash[at], m->flash[(at + 1) & LAST]);
    }
    for (int i = 0; i < AVR_WRAPS; i++) m->ops[AVR_FLASH_WORDS + i] = OP_WRAP;
}
