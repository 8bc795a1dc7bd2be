/* Flags of the ATmega328P's timers, at the clock: beside interrupts that are entered, and where they are cleared. */
#include "../mcu/avr/atmega328p.h"

#include "../mcu/avr/avr_registers.h"
#include "check.h"

enum { NOP = 0x0000, SEI = 0x9478, FIRST = 0x40, MOST = 128 };

static avr chip;
static uint16_t code[MOST];
static unsigned count;

static void word(unsigned value) { code[count++] = (uint16_t)value; }

/* LDI r16 and STS: 3 clocks. */
static void write(unsigned address, unsigned value)
{
    word(0xe000 | (value << 4 & 0xf00) | (value & 15));
    word(0x9300);
    word(address);
}

/* OUT TIFR0: LDI r16 before it. */
static void clear_flags_0(unsigned flags)
{
    word(0xe000 | (flags << 4 & 0xf00) | (flags & 15));
    word(0xbb05);
}

static void nops(unsigned n)
{
    while (n--) word(NOP);
}

static void begin(void)
{
    static const uint8_t nothing[AVR_FLASH_BYTES]; /* NOPs */
    avr_open(&chip);
    avr_load_flash(&chip, 0, nothing, sizeof(nothing));
    avr_load_flash(&chip, FIRST * 2, (const uint8_t *)code, count * 2);
    avr_reset(&chip, AVR_POWER_ON, 0);
    chip.pc = FIRST;
    count = 0;
}

/* The clock at which the flag rises next, from m->cycle on; at most `until`. */
static uint64_t rises(unsigned address, uint8_t flag, uint64_t until)
{
    while (chip.cycle < until && !(avr_peek(&chip, (uint16_t)address) & flag)) avr_run(&chip, chip.cycle + 1, NULL);
    return chip.cycle;
}

/* A match every 23 clocks; the second one within the entry for the first, at each of its clocks. */
static void what_rises_while_an_interrupt_is_entered_stays(void)
{
    for (unsigned early = 0; early < 4; early++) {
        write(TCCR2A, 2), write(OCR2A, 22), write(TIMSK2, OCFA), write(TCCR2B, 1);
        uint64_t started = 12;
        nops(40 + early);
        word(SEI);
        begin();
        avr_run(&chip, started + 46 + early, NULL); /* SEI, NOP, and the 4 clocks of the entry are over */
        CHECK_INT(chip.pc, VECTOR_T2_COMPA * 2);
        CHECK_INT(avr_peek(&chip, TIFR2) & OCFA, OCFA);
    }
}

/* OCR0B 10 and a period of 106 clocks: matches at 11, 117, 223. */
static void start_timer_0(unsigned enabled)
{
    write(TCCR0A, 2), write(OCR0A, 105), write(OCR0B, 10), write(TIMSK0, enabled), write(TCCR0B, 1);
}

enum { STARTED = 15 };

static void a_flag_that_was_cleared_rises_at_the_next_match(void)
{
    start_timer_0(0);
    nops(108);
    clear_flags_0(OCFB); /* ends at 110: it was set at 11, and TOP was at 106 */
    begin();
    CHECK_INT(rises(TIFR0, OCFB, 1000), STARTED + 11);
    avr_run(&chip, STARTED + 110, NULL);
    CHECK_INT(avr_peek(&chip, TIFR0) & OCFB, 0);
    CHECK_INT(rises(TIFR0, OCFB, 1000), STARTED + 117);
}

static void a_match_before_a_flag_was_cleared_does_not_count_again(void)
{
    start_timer_0(OCFB);
    nops(100);
    begin();
    avr_run(&chip, STARTED + 130, NULL); /* a match at 11, one at 117 while the flag was set */
    chip.sreg |= FLAG_I;
    avr_run(&chip, STARTED + 135, NULL);
    CHECK_INT(avr_peek(&chip, TIFR0) & OCFB, 0);
    CHECK_INT(rises(TIFR0, OCFB, 1000), STARTED + 223);
}

void avr_flags_tests(void)
{
    RUN(what_rises_while_an_interrupt_is_entered_stays);
    RUN(a_flag_that_was_cleared_rises_at_the_next_match);
    RUN(a_match_before_a_flag_was_cleared_does_not_count_again);
}
