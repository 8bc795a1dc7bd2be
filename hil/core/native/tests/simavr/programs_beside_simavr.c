/* Random programs at our processor and at simavr, compared after each instruction: programs_beside_simavr SEED COUNT [FIRST].

   A tool of development, and a test where simavr's library is installed; no part of hil. What simavr gets wrong is set right
   in simavr_side.c and counted; any other difference is a failure, with the program's number. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../mcu/avr/atmega328p.h"
#include "../../mcu/avr/avr_registers.h"
#include "../../mcu/avr/avr_timer.h"
#include "random_code.h"
#include "simavr_side.h"

enum {
    STEPS = 64,          /* instructions of a program */
    TIMED_STEPS = 192,   /* of one with timers */
    PROGRAMS = 1024,     /* that find the same flash */
    TIMED_EVERY = 4,     /* program has timers */
    SETUP = 0x3f00,      /* words where the code is that sets them up */
    SRAM = 0x100, RAM_END = 0x900,
    SETUP_WORDS = 96,
    LOWEST_STACK = SRAM + 16,
    MOST_FAILURES = 5
};

static avr chip;
static simavr_side *other;
static uint64_t begun, others_begun; /* clocks at which a program begins */
static unsigned ctc_timers;          /* a bit each */

/* Sections are those of DS40002061, but for instructions. */
static const char *const MENDED_WHY[MENDED] = {
    [MENDED_ENTRY] = "interrupts entered, in 4 clocks; simavr: 0 (Interrupt Response Time)",
    [MENDED_HELD] = "one instruction runs after I is set; simavr: two (Reset and Interrupt Handling; buserror/simavr#441)",
    [MENDED_RETURN] = "one instruction runs after RETI where I was set already; simavr: none (Reset and Interrupt Handling)",
    [MENDED_STALE] = "a request that was cleared is none; simavr: others wait an instruction for it (Reset and Interrupt Handling)",
    [MENDED_SKIP] = "ADIW and SBIW are one word; simavr: some are skipped as two, like JMP (AVR Instruction Set Manual)",
    [MENDED_WRAP] = "PC has 14 bits; simavr: what RET, IJMP and ICALL find (In-System Reprogrammable Flash Program Memory)",
    [MENDED_ASLEEP] = "SLEEP without SE does nothing; simavr: sleeps (SMCR)",
    [MENDED_WRITE] = "writes to a timer, at the end of STS, OUT, SBI; simavr: at the begin (Timer/Counter Timing Diagrams)",
    [MENDED_READ] = "reads of a timer, in the last clock of LDS; simavr: in the first (Timer/Counter Timing Diagrams)",
    [MENDED_KEPT] = "flags of TIFRn that are written as 0 stay; simavr: any write clears all (TIFR0; buserror/simavr#337 for SBI)",
    [MENDED_OVERFLOW] = "CTC does not set TOV at TOP; simavr: does (Clear Timer on Compare Match Mode; wokwi/avr8js#75)",
};

static unsigned word(unsigned r) { return chip.data[r] | (unsigned)chip.data[r + 1] << 8; }

static void set_register(unsigned r, uint8_t value) { chip.data[r] = other->data[r] = value; }

static void set_word(unsigned r, unsigned value)
{
    set_register(r, (uint8_t)value);
    set_register(r + 1, (uint8_t)(value >> 8));
}

static int is_quiet(unsigned address)
{
    switch (address) {
    case GPIOR0: case GPIOR1: case GPIOR2: case SPL: case SPH: case SREG: return 1;
    default: return address < 0x20 || (address >= SRAM && address < RAM_END);
    }
}

/* Loads and stores with a pointer: r26, r28 or r30, and what is added to it for the address; -1: none. */
static int pointer_of(unsigned w, int *plus)
{
    *plus = 0;
    if ((w & 0xd000) == 0x8000) { /* LDD, STD */
        *plus = (int)((w & 7) | (w >> 7 & 24) | (w >> 8 & 32));
        return w & 8 ? 28 : 30;
    }
    if ((w & 0xfc00) != 0x9000) return -1;
    switch (w & 15) {
    case 1: return 30;
    case 2: *plus = -1; return 30;
    case 9: return 28;
    case 10: *plus = -1; return 28;
    case 12: case 13: return 26;
    case 14: *plus = -1; return 26;
    default: return -1;
    }
}

static int is_skip(unsigned w) { return (w & 0xfc00) == 0x1000 || (w & 0xfd00) == 0x9900 || (w & 0xfc08) == 0xfc00; }
static int is_flags(unsigned io) { return io + 0x20 >= TIFR0 && io + 0x20 <= TIFR2; }
static int is_sts(unsigned w) { return (w & 0xfe0f) == 0x9200; }

/* Second words of jumps, loads and stores that are no instructions. */
static int is_illegal(unsigned w) { return w && w < 0x100; }

static void steer_stack(chance *c)
{
    if (chip.sp >= LOWEST_STACK && chip.sp <= RAM_END - 3) return;
    chip.sp = (uint16_t)(LOWEST_STACK + draw_below(c, RAM_END - 3 - LOWEST_STACK));
    simavr_set_sp(chip.sp);
}

/* What would reach a part of the chip, or the end of memory, reaches SRAM or registers. */
static void steer(chance *c, unsigned w)
{
    int plus, pointer = pointer_of(w, &plus);
    if (pointer >= 0) {
        unsigned address = word((unsigned)pointer) + (unsigned)plus, is_own = address - 26 < 6; /* the pointers themselves */
        if ((address & 0xffff) != address || !is_quiet(address) || is_own) {
            address = draw_below(c, 8) ? SRAM + draw_below(c, RAM_END - SRAM) : draw_below(c, 26);
            set_word((unsigned)pointer, address - (unsigned)plus);
        }
    }
    if ((w & 0xfe0e) == 0x9004 || w == 0x95c8) set_register(31, chip.data[31] & 0x7f); /* LPM: 15 bits are there */
}

static int kind_of_step(unsigned w, unsigned next)
{
    if (w == 0x9588) return SIMAVR_SLEEP;
    if ((w & 0xf800) == 0xb800 && is_flags((w & 15) | (w >> 5 & 0x30))) return SIMAVR_CLEARS;
    if ((w & 0xfd00) == 0x9800 && is_flags(w >> 3 & 31)) return SIMAVR_CLEARS;
    if ((w & 0xfe0f) == 0x9000 && !is_quiet(next)) return SIMAVR_READS;
    if ((next & 0xfe0c) == 0x960c && is_skip(w)) return SIMAVR_SKIPS;
    if (w == 0x9518) return SIMAVR_RETI;
    if (is_sts(w) && !is_quiet(next)) return SIMAVR_WRITES;
    return SIMAVR_PLAIN;
}

static int is_equal(void)
{
    return chip.t - begun == simavr_cycle() - others_begun && chip.pc == simavr_pc() && chip.sreg == simavr_sreg() &&
           chip.sp == simavr_sp() && !memcmp(chip.data, other->data, 32);
}

static void say_state(void)
{
    printf("  ours:   clock %" PRIu64 " pc %04x sreg %02x sp %04x enters %d\n", chip.t - begun, chip.pc, chip.sreg, chip.sp, chip.entered);
    printf("  simavr: clock %" PRIu64 " pc %04x sreg %02x sp %04x\n", simavr_cycle() - others_begun, simavr_pc(), simavr_sreg(),
           simavr_sp());
    for (unsigned a = 0; a < RAM_END; a++)
        if ((a < 32 || a >= SRAM || (a >= TIFR0 && a <= TIFR2)) && chip.data[a] != other->data[a])
            printf("  %s %03x: ours %02x, simavr %02x\n", a < 32 ? "r" : "data", a, chip.data[a], other->data[a]);
}

/* One instruction of both, and the entry of an interrupt behind it; whether they are equal after each. */
static int step(chance *c)
{
    simavr_step(kind_of_step(chip.flash[chip.pc], chip.flash[(chip.pc + 1) % AVR_FLASH_WORDS]));
    simavr_forget_overflows(ctc_timers);
    avr_run(&chip, begun + simavr_cycle() - others_begun, NULL);
    if (!is_equal()) return 0;
    steer_stack(c);
    int entered = simavr_enter();
    simavr_forget_overflows(ctc_timers);
    if (!entered) return 1;
    avr_run(&chip, begun + simavr_cycle() - others_begun, NULL);
    return is_equal();
}

/* Code that writes registers of timers: LDI r16 and STS for each; a clock is chosen last. */
typedef struct setup { uint16_t words[SETUP_WORDS]; unsigned count; } setup;

static void put(setup *s, unsigned address, unsigned value)
{
    s->words[s->count++] = (uint16_t)(0xe000 | (value << 4 & 0xf00) | (value & 15)); /* LDI r16 */
    s->words[s->count++] = 0x9300;                                                   /* STS, r16 */
    s->words[s->count++] = (uint16_t)address;
}

enum mode { NORMAL, CTC, FAST };

static void put_timer(chance *c, setup *s, unsigned n, enum mode mode, unsigned clock)
{
    static const uint16_t controls[3] = {TCCR0A, TCCR1A, TCCR2A}, enables[3] = {TIMSK0, TIMSK1, TIMSK2};
    unsigned control = controls[n], most = n == 1 ? 400 : 256, a = 3 + draw_below(c, most - 4), b = 3 + draw_below(c, most - 3);
    if (n == 1) {
        put(s, OCR1AH, a >> 8), put(s, OCR1AL, a & 255), put(s, OCR1BH, b >> 8), put(s, OCR1BL, b & 255);
        put(s, TCCR1A, mode == FAST ? 1 + draw_below(c, 3) : 0); /* 8, 9 or 10 bits */
    } else {
        put(s, control + 3, a), put(s, control + 4, b), put(s, control, mode == CTC ? 2 : mode == FAST ? 3 : 0);
    }
    put(s, enables[n], draw_below(c, 8) & (mode == CTC ? OCFA | OCFB : TOV | OCFA | OCFB));
    put(s, control + 1, clock | (n == 1 && mode != NORMAL ? 8 : 0));
    if (clock != 1 || draw_below(c, 2)) return; /* simavr begins its prescaler where the count is written */
    unsigned count = draw_below(c, mode == CTC && a < 250 ? a : 250);
    if (count - (a & 255) < 2 || count - (b & 255) < 2) count = 0; /* nor does it know that a write blocks a compare */
    if (n == 1) put(s, TCNT1H, mode == NORMAL ? 0xff : 0);
    put(s, n == 1 ? TCNT1L : control + 2, count);
}

/* One to three timers, in modes that simavr knows; the jump into the program is behind them. */
static void draw_timers(chance *c, setup *s)
{
    unsigned used = 1 + draw_below(c, 7), is_divided = 0;
    for (unsigned n = 0; n < 3; n++) {
        if (!(used >> n & 1)) continue;
        enum mode mode = (enum mode)draw_below(c, 3);
        unsigned clock = n < 2 && is_divided ? 1 : 1 + draw_below(c, 3); /* the prescaler of timers 0 and 1 is one, in simavr two */
        if (n < 2 && clock > 1) is_divided = 1;
        if (mode == CTC) ctc_timers |= 1u << n;
        put_timer(c, s, n, mode, clock);
    }
    s->words[s->count++] = draw_below(c, 2) ? 0x9478 : 0x0000; /* SEI or NOP */
    s->words[s->count++] = 0x940c;                             /* JMP */
    s->words[s->count++] = (uint16_t)draw_below(c, SETUP);
}

static int is_clock(unsigned address) { return address == TCCR0B || address == TCCR1B || address == TCCR2B; }

/* The prescaler begins where simavr's does. */
static void begin_prescaler(unsigned address)
{
    if ((chip.data[address] & 7) < 2) return;
    chip.data[GTCCR] = address == TCCR2B ? PSRASY : PSRSYNC;
    avr_timer_gates(&chip, chip.t);
}

static int failed(uint64_t number, unsigned steps, unsigned at)
{
    printf("program %" PRIu64 ", instruction %u, %04x %04x at %04x:\n", number, steps, chip.flash[at],
           chip.flash[(at + 1) % AVR_FLASH_WORDS], at);
    say_state();
    return 1;
}

static int are_flags_equal(void)
{
    for (unsigned n = 0; n < 3; n++)
        if (chip.data[TIFR0 + n] != other->data[TIFR0 + n]) return 0;
    return 1;
}

static int is_memory_equal(void)
{
    return !memcmp(chip.data + SRAM, other->data + SRAM, RAM_END - SRAM) && chip.data[GPIOR0] == other->data[GPIOR0] &&
           chip.data[GPIOR1] == other->data[GPIOR1] && chip.data[GPIOR2] == other->data[GPIOR2];
}

/* Registers are drawn, and some of SRAM: the rest is as the program before has left it. */
static void begin(chance *c, int is_timed)
{
    for (unsigned r = 0; r < 32; r += 8) {
        uint64_t eight = draw(c);
        memcpy(chip.data + r, &eight, 8);
    }
    for (unsigned a = SRAM; a < RAM_END; a += 256) {
        uint64_t eight = draw(c);
        memcpy(chip.data + a + draw_below(c, 248), &eight, 8);
    }
    avr_reset(&chip, 0, 0);
    simavr_reset();
    memcpy(other->data, chip.data, 32);
    memcpy(other->data + SRAM, chip.data + SRAM, RAM_END - SRAM);
    ctc_timers = 0;
    chip.sp = (uint16_t)(LOWEST_STACK + draw_below(c, RAM_END - 3 - LOWEST_STACK));
    chip.sreg = (uint8_t)(draw(c) & (is_timed ? 0x7f : 0xff));
    chip.pc = (uint16_t)(is_timed ? SETUP : draw_below(c, AVR_FLASH_WORDS));
    simavr_begin(chip.pc, chip.sp, chip.sreg);
    begun = chip.t;
    others_begun = simavr_cycle();
}

/* Runs the code that sets timers up; 0: it differs. */
static int set_up(chance *c)
{
    setup s = {.count = 0};
    draw_timers(c, &s);
    avr_load_flash(&chip, SETUP * 2, (const uint8_t *)s.words, s.count * 2);
    memcpy(other->flash + SETUP * 2, s.words, s.count * 2);
    for (unsigned i = 0; i < s.count; i += 3) { /* two instructions */
        if (!step(c) || !step(c)) return 0;
        if (i + 3 < s.count && is_clock(s.words[i + 2])) begin_prescaler(s.words[i + 2]);
    }
    return 1;
}

static void say_step(unsigned number)
{
    unsigned pc = chip.pc;
    printf("%3u: clock %" PRIu64 " pc %04x: %04x %04x sreg %02x sp %04x flags %x %x %x\n", number, chip.t - begun, pc, chip.flash[pc],
           chip.flash[(pc + 1) % AVR_FLASH_WORDS], chip.sreg, chip.sp, chip.data[TIFR0], chip.data[TIFR1], chip.data[TIFR2]);
}

/* Where a program ends before its time: a jump has come to the second word of an instruction, to the last, or into SETUP. */
static int is_end(unsigned pc)
{
    return is_illegal(chip.flash[pc]) || pc >= AVR_FLASH_WORDS - 2 || (pc >= SETUP && pc < SETUP + SETUP_WORDS);
}

/* Runs program `number`; 1: it differs. */
static int run(uint64_t seed, uint64_t number, int is_loud, uint64_t *instructions)
{
    chance c = {seed << 32 ^ number};
    int is_timed = number % TIMED_EVERY == 0;
    begin(&c, is_timed);
    if (is_timed && !set_up(&c)) return failed(number, 0, chip.pc);
    for (unsigned i = 0; i < (is_timed ? TIMED_STEPS : STEPS) && !is_end(chip.pc); i++) {
        unsigned at = chip.pc;
        steer(&c, chip.flash[at]);
        if (is_loud) say_step(i);
        ++*instructions;
        if (!step(&c) || (is_timed && !are_flags_equal())) return failed(number, i, at);
    }
    return is_memory_equal() ? 0 : failed(number, TIMED_STEPS, chip.pc);
}

static void fill_flash(uint64_t seed, uint64_t block)
{
    static uint16_t words[AVR_FLASH_WORDS];
    chance c = {~(seed << 32 ^ block)};
    random_code(&c, words, AVR_FLASH_WORDS);
    words[SETUP - 1] = 0; /* no instruction takes the first word of a setup for its second */
    memcpy(other->flash, words, sizeof(words));
    avr_load_flash(&chip, 0, (const uint8_t *)words, sizeof(words));
}

int main(int count, char **words)
{
    uint64_t seed = count > 1 ? strtoull(words[1], NULL, 10) : 1, all = count > 2 ? strtoull(words[2], NULL, 10) : 1000;
    uint64_t first = count > 3 ? strtoull(words[3], NULL, 10) : 0, block = UINT64_MAX, instructions = 0;
    int failures = 0;
    other = simavr_open();
    avr_open(&chip);
    for (uint64_t number = first; number < first + all && failures < MOST_FAILURES; number++) {
        if (number / PROGRAMS != block) fill_flash(seed, block = number / PROGRAMS);
        failures += run(seed, number, count > 3 && all == 1, &instructions);
    }
    printf("%" PRIu64 " programs, %" PRIu64 " instructions, %d differ\n", all, instructions, failures);
    for (int i = 0; i < MENDED; i++) printf("  %" PRIu64 " times: %s\n", other->mended[i], MENDED_WHY[i]);
    return failures != 0;
}
