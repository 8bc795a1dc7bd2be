#include "simavr_side.h"

#include <simavr/sim_avr.h>
#include <simavr/sim_core.h>
#include <simavr/sim_cycle_timers.h>
#include <simavr/sim_interrupts.h>
#include <stdlib.h>

enum { TIFR0 = 0x35 };

static avr_t *chip;
static simavr_side side;

static void say_nothing(avr_t *avr, const int level, const char *format, va_list rest)
{
    (void)avr, (void)level, (void)format, (void)rest;
}

simavr_side *simavr_open(void)
{
    avr_global_logger_set(say_nothing);
    chip = avr_make_mcu_by_name("atmega328p");
    if (!chip || avr_init(chip)) abort();
    chip->frequency = 16000000;
    chip->log = LOG_NONE;
    side.flash = chip->flash;
    side.data = chip->data;
    return &side;
}

void simavr_reset(void)
{
    static const avr_io_addr_t clocks[3] = {0x45, 0x81, 0xb1}; /* TCCRnB: its timers keep their clocks over a reset */
    for (int n = 0; n < 3; n++) {
        avr_io_addr_t io = AVR_DATA_TO_IO(clocks[n]);
        chip->io[io].w.c(chip, clocks[n], 0, chip->io[io].w.param);
    }
    avr_reset(chip);
}

void simavr_begin(uint16_t pc, uint16_t sp, uint8_t sreg)
{
    for (int bit = 0; bit < 8; bit++) chip->sreg[bit] = sreg >> bit & 1;
    chip->interrupt_state = 0;
    chip->pc = (avr_flashaddr_t)pc * 2;
    chip->state = cpu_Running;
    simavr_set_sp(sp);
}

int simavr_enter(void)
{
    enum { ENTRY_CLOCKS = 4 };
    if (chip->interrupt_state == -2) {
        chip->interrupt_state = -1;
        side.mended[MENDED_HELD]++;
    }
    if (!chip->interrupt_state) return 0;
    uint8_t was = chip->sreg[S_I];
    int is_held = chip->interrupt_state < 0;
    avr_service_interrupts(chip);
    while (was && !is_held && chip->sreg[S_I] && chip->interrupt_state > 0) {
        side.mended[MENDED_STALE]++;
        avr_service_interrupts(chip);
    }
    if (!was || chip->sreg[S_I]) return 0;
    chip->cycle += ENTRY_CLOCKS;
    side.mended[MENDED_ENTRY]++;
    avr_cycle_timer_process(chip);
    return 1;
}

/* Flags that were not named are set again. */
static void keep_flags(unsigned address, uint8_t kept)
{
    side.mended[MENDED_KEPT]++;
    for (int i = 0; i < chip->interrupts.vector_count; i++) {
        avr_int_vector_t *v = chip->interrupts.vector[i];
        if (v->raised.reg == address && kept >> v->raised.bit & 1) avr_raise_interrupt(chip, v);
    }
}

/* Flags that OUT, SBI or CBI leaves as they are. */
static uint8_t kept_of(unsigned word, unsigned *address)
{
    int is_out = word >= 0xb000;
    *address = 0x20 + (is_out ? (word & 15) | (word >> 5 & 0x30) : word >> 3 & 31);
    unsigned written = is_out ? chip->data[word >> 4 & 31] : word & 0x200 ? 1u << (word & 7) : 0;
    return (uint8_t)(chip->data[*address] & ~written);
}

void simavr_step(int kind)
{
    static const uint8_t clocks[SIMAVR_KINDS] = {[SIMAVR_WRITES] = 2, [SIMAVR_READS] = 1}; /* STS, LDS */
    unsigned word = chip->flash[chip->pc] | (unsigned)chip->flash[chip->pc + 1] << 8, flags = 0;
    unsigned late = kind == SIMAVR_CLEARS ? (word < 0xb000 ? 2 : 1) : clocks[kind];
    uint8_t kept = 0;
    if (late) side.mended[kind == SIMAVR_READS ? MENDED_READ : MENDED_WRITE]++;
    chip->cycle += late;
    if (late) avr_cycle_timer_process(chip);
    if (kind == SIMAVR_CLEARS) kept = kept_of(word, &flags);
    chip->run_cycle_count = 1;
    avr_flashaddr_t next = avr_run_one(chip);
    chip->cycle -= late;
    if (kept) keep_flags(flags, kept);
    if (kind == SIMAVR_SKIPS && next - chip->pc == 6) {
        next -= 2;
        chip->cycle--;
        side.mended[MENDED_SKIP]++;
    }
    avr_cycle_timer_process(chip);
    if (next > chip->flashend) {
        next &= chip->flashend;
        side.mended[MENDED_WRAP]++;
    }
    chip->pc = next;
    if (kind == SIMAVR_SLEEP && chip->state == cpu_Sleeping) {
        chip->state = cpu_Running;
        side.mended[MENDED_ASLEEP]++;
    }
    if (kind == SIMAVR_RETI && chip->interrupt_state >= 0) {
        if (chip->interrupt_state) side.mended[MENDED_RETURN]++;
        chip->interrupt_state = -1;
    }
}

void simavr_forget_overflows(unsigned timers)
{
    for (unsigned n = 0; n < 3; n++) {
        uint8_t *flags = &chip->data[TIFR0 + n];
        if (!(timers >> n & 1) || !(*flags & 1)) continue;
        *flags &= 0xfe;
        side.mended[MENDED_OVERFLOW]++;
    }
}

uint16_t simavr_pc(void) { return (uint16_t)(chip->pc / 2); }
uint64_t simavr_cycle(void) { return chip->cycle; }
uint16_t simavr_sp(void) { return (uint16_t)(chip->data[R_SPL] | chip->data[R_SPH] << 8); }

void simavr_set_sp(uint16_t sp)
{
    chip->data[R_SPL] = (uint8_t)sp;
    chip->data[R_SPH] = (uint8_t)(sp >> 8);
}

uint8_t simavr_sreg(void)
{
    uint8_t sreg = 0;
    for (int bit = 0; bit < 8; bit++) sreg |= (uint8_t)(chip->sreg[bit] << bit);
    return sreg;
}
