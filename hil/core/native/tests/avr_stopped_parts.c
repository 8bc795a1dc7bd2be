/* What PRR, CLKPR and sleep stop, and what ends it; where vectors are. DS40002061, Power Reduction Register, System Clock Prescaler,
   Sleep Modes, Moving Interrupts Between Application and Boot Space. */
#include "avr_lab.h"

enum { POWER_DOWN = 2, STANDBY = 6, CRYSTAL = 16384 };

static avr_lab lab;

static void a_stopped_timer_keeps_its_count(void)
{
    static const struct { unsigned bit, control, count; } timers[] = {{PRTIM0, TCCR0B, TCNT0}, {PRTIM1, TCCR1B, TCNT1L}, {PRTIM2, TCCR2B, TCNT2}};
    for (int n = 0; n < 3; n++) {
        lab_open(&lab);
        put(&lab, timers[n].control, 1);
        lab_run(&lab, 50);
        put(&lab, PRR, timers[n].bit);
        lab_run(&lab, 1000);
        CHECK_INT(get(&lab, timers[n].count), 0); /* unreadable */
        put(&lab, timers[n].count, 99);           /* nor written */
        put(&lab, PRR, 0);
        CHECK_INT(get(&lab, timers[n].count), 50);
        lab_run(&lab, 7);
        CHECK_INT(get(&lab, timers[n].count), 57);
    }
}

static void a_pulse_at_t1_is_not_counted_while_timer_1_is_stopped(void)
{
    lab_open(&lab);
    put(&lab, TCCR1B, 7);
    put(&lab, PRR, PRTIM1);
    avr_pin(&lab.chip, D + 5, 1);
    lab_run(&lab, 10);
    put(&lab, PRR, 0);
    CHECK_INT(get(&lab, TCNT1L), 0);
}

static void a_frame_goes_on_where_it_was_stopped(void)
{
    lab_open(&lab);
    put(&lab, UBRR0L, 0), put(&lab, UCSR0B, TXEN), put(&lab, UDR0, 0x55);
    lab_run(&lab, 50);
    put(&lab, PRR, PRUSART);
    lab_run(&lab, 5000);
    CHECK_INT(avr_peek(&lab.chip, UCSR0A) & TXC, 0);
    CHECK_INT(get(&lab, UCSR0A), 0);
    put(&lab, UDR0, 1); /* nobody takes it */
    put(&lab, PRR, 0);
    CHECK_INT(until_bits(&lab, UCSR0A, TXC, TXC, 1000), 160 + 1 - 50);
    CHECK_INT(lab.frames, 1);
}

static void a_byte_of_spi_and_a_conversion_go_on_as_well(void)
{
    lab_open(&lab);
    put(&lab, DDRB, 0x2c), put(&lab, SPCR, SPE | MSTR | 1), put(&lab, SPDR, 1); /* 128 clocks */
    lab_run(&lab, 28);
    put(&lab, PRR, PRSPI);
    lab_run(&lab, 1000);
    CHECK_INT(avr_peek(&lab.chip, SPSR) & SPIF, 0);
    put(&lab, PRR, 0);
    CHECK_INT(until_bits(&lab, SPSR, SPIF, SPIF, 1000), 100);
    put(&lab, ADCSRA, ADEN | ADSC | 4); /* 16 clocks: 25 of them, from the next on */
    lab_run(&lab, 100);
    put(&lab, PRR, PRADC);
    lab_run(&lab, 1000);
    CHECK_INT(get(&lab, ADCSRA), 0);
    put(&lab, PRR, 0);
    CHECK_INT(until_bits(&lab, ADCSRA, ADSC, 0, 1000), 16 * 26 - 100);
}

static void the_clock_changes_in_a_timed_sequence(void)
{
    static const struct { int pause, again, is_in_time; } cases[] = {{4, 0, 1}, {5, 0, 0}, {4, 3, 1}, {6, 3, 0}};
    for (int n = 0; n < 4; n++) {
        lab_open(&lab);
        put(&lab, CLKPR, CLKPCE);
        CHECK_INT(get(&lab, CLKPR), CLKPCE);
        if (cases[n].again) {
            lab_run(&lab, 3);
            put(&lab, CLKPR, CLKPCE); /* that is no longer time */
        }
        lab_until(&lab, (uint64_t)cases[n].pause);
        put(&lab, CLKPR, 3);
        CHECK_INT(get(&lab, CLKPR), cases[n].is_in_time ? 3 : 0);
    }
    put(&lab, CLKPR, CLKPCE | 3);
    put(&lab, CLKPR, 3); /* together with other bits it is not set */
    CHECK_INT(get(&lab, CLKPR), 0);
}

static void all_but_own_oscillators_follow_the_clock(void)
{
    lab_open(&lab);
    put(&lab, CLKPR, CLKPCE), put(&lab, CLKPR, 4);
    put(&lab, TCCR1B, 1);
    put(&lab, UBRR0L, 0), put(&lab, UCSR0B, TXEN), put(&lab, UDR0, 0x55);
    put(&lab, EECR, EEMPE), put(&lab, EECR, EEPE);
    lab_run(&lab, 1600);
    CHECK_NEAR(get(&lab, TCNT1L), 100, 2); /* EEPE has halted it for two */
    CHECK_INT(lab.frame[0].bit_cycles_256, 16 * 16 * 256);
    CHECK_NEAR((double)until_bits(&lab, EECR, EEPE, 0, 100000) + 1600, 16000 * 3.4, 40);
}

static void vectors_move_in_a_timed_sequence(void)
{
    lab_open(&lab);
    put(&lab, EIMSK, 1); /* INT0 asks by its level */
    lab_run(&lab, 4);
    put(&lab, MCUCR, IVSEL);
    CHECK_INT(get(&lab, MCUCR), 0);
    put(&lab, MCUCR, IVCE);
    lab_run(&lab, 5);
    put(&lab, MCUCR, IVSEL); /* too late */
    CHECK_INT(get(&lab, MCUCR), 0);
    put(&lab, MCUCR, IVCE), put(&lab, MCUCR, IVSEL);
    CHECK_INT(get(&lab, MCUCR), IVSEL);
    lab.chip.sreg |= FLAG_I;
    lab_run(&lab, 1 + 4 + 1); /* the instruction after it, the entry, one there */
    CHECK_INT(lab.chip.pc, 0x3f00 + 2 * VECTOR_INT0 + 1);
}

static void no_interrupt_is_entered_while_vectors_may_move(void)
{
    lab_open(&lab);
    lab.chip.pc = 0x100;
    put(&lab, EIMSK, 1), put(&lab, MCUCR, IVCE);
    lab.chip.sreg |= FLAG_I;
    lab_run(&lab, 4);
    CHECK_INT(lab.chip.pc, 0x104);
    lab_run(&lab, 4);
    CHECK_INT(lab.chip.pc, 2 * VECTOR_INT0);
}

/* Puts it asleep, I set, and tells how long; 0: it still is after `most`. */
static uint64_t slept_in(unsigned mode, uint64_t most)
{
    sleep_in(&lab, mode);
    uint64_t from = lab.chip.cycle;
    while (lab.chip.asleep && lab.chip.cycle < from + most) lab_run(&lab, 1);
    return lab.chip.asleep ? 0 : lab.chip.cycle - from;
}

static void begin_eeprom(unsigned more)
{
    lab_open(&lab);
    put(&lab, EECR, EEMPE), put(&lab, EECR, EEPE | more);
}

static void each_mode_has_its_wake_up_sources(void)
{
    begin_eeprom(EERIE);
    CHECK_NEAR((double)slept_in(1, 100000), 16000 * 3.4, 20); /* noise reduction */
    begin_eeprom(EERIE);
    CHECK_INT(slept_in(POWER_DOWN, 100000), 0);
    lab_open(&lab);
    put(&lab, TCCR0B, 1), put(&lab, TIMSK0, TOV);
    CHECK_INT(slept_in(0, 1000), 256);
    for (unsigned mode = 1; mode <= STANDBY; mode += mode == 3 ? 3 : 1) {
        lab_open(&lab);
        put(&lab, TCCR0B, 1), put(&lab, TIMSK0, TOV);
        CHECK_INT(slept_in(mode, 1000), 0);
        put(&lab, PCICR, 1), put(&lab, PCMSK0, 1); /* a pin's change */
        avr_pin(&lab.chip, B, 1);
        lab_run(&lab, 4);
        CHECK(!lab.chip.asleep);
    }
}

static void edges_of_int0_wake_from_idle_alone(void)
{
    for (unsigned mode = 0; mode < 3; mode++) {
        lab_open(&lab);
        put(&lab, EICRA, 3), put(&lab, EIMSK, 1);
        sleep_in(&lab, mode);
        avr_pin(&lab.chip, D + 2, 1);
        lab_run(&lab, 10);
        CHECK_INT(!lab.chip.asleep, mode == 0);
    }
}

/* The level has to be there until the chip has woken: else it wakes, and enters nothing. */
static void a_short_level_wakes_and_interrupts_not(void)
{
    for (int is_long = 0; is_long < 2; is_long++) {
        lab_open(&lab);
        lab.chip.pc = 0x100;
        avr_pin(&lab.chip, D + 2, 1);
        lab_run(&lab, 10);
        put(&lab, EIMSK, 1), sleep_in(&lab, POWER_DOWN);
        lab_run(&lab, 10);
        avr_pin(&lab.chip, D + 2, 0);
        lab_run(&lab, 1000);
        CHECK(!lab.chip.asleep);
        if (!is_long) avr_pin(&lab.chip, D + 2, 1);
        lab_run(&lab, CRYSTAL - 1000 + 3 + 4); /* it runs from here on */
        lab_run(&lab, 4);
        CHECK_INT(lab.chip.pc, is_long ? 2 * VECTOR_INT0 : 0x10a + 4);
    }
}

static void wake_up_times(void)
{
    static const struct { unsigned mode; uint64_t clocks; } modes[] = {{0, 4}, {1, 4}, {2, CRYSTAL + 4}, {3, CRYSTAL + 4}, {6, 6 + 4}, {7, 6 + 4}};
    for (int n = 0; n < 6; n++) {
        lab_open(&lab);
        put(&lab, PCICR, 4), put(&lab, PCMSK2, 0x80);
        sleep_in(&lab, modes[n].mode);
        lab_run(&lab, 100);
        avr_pin(&lab.chip, D + 7, 1);
        lab_run(&lab, 3);
        CHECK_INT(lab.chip.t - lab.chip.cycle, modes[n].clocks);
    }
}

void avr_stopped_parts_tests(void)
{
    RUN(a_stopped_timer_keeps_its_count);
    RUN(a_pulse_at_t1_is_not_counted_while_timer_1_is_stopped);
    RUN(a_frame_goes_on_where_it_was_stopped);
    RUN(a_byte_of_spi_and_a_conversion_go_on_as_well);
    RUN(the_clock_changes_in_a_timed_sequence);
    RUN(all_but_own_oscillators_follow_the_clock);
    RUN(vectors_move_in_a_timed_sequence);
    RUN(no_interrupt_is_entered_while_vectors_may_move);
    RUN(each_mode_has_its_wake_up_sources);
    RUN(edges_of_int0_wake_from_idle_alone);
    RUN(a_short_level_wakes_and_interrupts_not);
    RUN(wake_up_times);
}
