/* Ports, external interrupts and the watchdog: DS40002061, I/O-Ports, External Interrupts, Watchdog Timer. */
#include "avr_lab.h"

enum { WDP = 0x27 };

static avr_lab lab;

static void a_one_to_pin_toggles(void)
{
    lab_open(&lab);
    put(&lab, DDRD, 0xf0), put(&lab, PORTD, 0x50);
    put(&lab, PIND, 0x33);
    CHECK_INT(get(&lab, PORTD), 0x63);
    CHECK_INT(avr_driven(&lab.chip, D), AVR_PULLED_UP); /* of an input its pull-up */
    avr_set_bit(&lab.chip, PIND, 1, lab.chip.t); /* SBI: that bit alone */
    CHECK_INT(get(&lab, PORTD), 0x62);
    avr_clear_bit(&lab.chip, PIND, 2, lab.chip.t);
    CHECK_INT(get(&lab, PORTD), 0x62);
}

static void pud_turns_all_pull_ups_off(void)
{
    lab_open(&lab);
    put(&lab, PORTB, 1), put(&lab, PORTC, 1), put(&lab, PORTD, 1);
    lab_run(&lab, 2);
    CHECK_INT(get(&lab, PINB) & get(&lab, PINC) & get(&lab, PIND) & 1, 1);
    put(&lab, MCUCR, PUD);
    lab_run(&lab, 2);
    CHECK_INT((get(&lab, PINB) | get(&lab, PINC) | get(&lab, PIND)) & 1, 0);
    CHECK_INT(avr_driven(&lab.chip, B), AVR_OPEN);
    put(&lab, DDRB, 1), lab_run(&lab, 2);
    CHECK_INT(get(&lab, PINB) & 1, 1); /* an output stays */
}

static void each_sense_of_an_external_interrupt(void)
{
    static const uint8_t seen[4] = {0, 3, 2, 1}; /* by ISC: rising 1, falling 2 */
    for (unsigned n = 0; n < 2; n++)
        for (unsigned sense = 1; sense < 4; sense++) {
            lab_open(&lab);
            put(&lab, EICRA, sense << 2 * n), put(&lab, EIMSK, 1 << n);
            for (int level = 1; level >= 0; level--) {
                avr_pin(&lab.chip, D + 2 + (int)n, level), lab_run(&lab, 5);
                int is_seen = seen[sense] & (level ? 1 : 2);
                CHECK_INT(get(&lab, EIFR), is_seen ? 1 << n : 0);
                CHECK_INT(entered(&lab), is_seen ? VECTOR_INT0 + n : 0);
                CHECK_INT(get(&lab, EIFR), 0);
            }
        }
}

static void a_level_asks_while_it_is_low_and_has_no_flag(void)
{
    lab_open(&lab);
    avr_pin(&lab.chip, D + 3, 1), put(&lab, EIMSK, 2), lab_run(&lab, 5);
    CHECK_INT(entered(&lab), 0);
    avr_pin(&lab.chip, D + 3, 0), lab_run(&lab, 5);
    CHECK_INT(entered(&lab), VECTOR_INT1);
    CHECK_INT(entered(&lab), VECTOR_INT1);
    CHECK_INT(get(&lab, EIFR), 0);
    put(&lab, EICRA, 2 << 2), put(&lab, EIMSK, 0);
    avr_pin(&lab.chip, D + 3, 1), lab_run(&lab, 5), avr_pin(&lab.chip, D + 3, 0), lab_run(&lab, 5);
    CHECK_INT(get(&lab, EIFR), 2); /* an edge is remembered, enabled or not */
    put(&lab, EICRA, 0);
    CHECK_INT(get(&lab, EIFR), 0);
}

static void pin_changes_go_by_their_masks(void)
{
    static const int firsts[3] = {B, C, D};
    for (unsigned port = 0; port < 3; port++)
        for (unsigned bit = 0; bit < 6; bit++) {
            lab_open(&lab);
            put(&lab, PCMSK0 + port, 1 << bit), put(&lab, PCICR, 1 << port);
            for (unsigned other = 0; other < 6; other++) {
                avr_pin(&lab.chip, firsts[port] + (int)other, 1), lab_run(&lab, 5);
                CHECK_INT(get(&lab, PCIFR), other == bit ? 1 << port : 0);
                if (other == bit) CHECK_INT(entered(&lab), VECTOR_PCINT0 + port);
            }
        }
}

static void own_outputs_interrupt_as_well(void)
{
    lab_open(&lab);
    put(&lab, EICRA, 3), put(&lab, PCMSK2, 4), put(&lab, DDRD, 4), put(&lab, PORTD, 4);
    lab_run(&lab, 5);
    CHECK_INT(get(&lab, EIFR), 1);
    CHECK_INT(get(&lab, PCIFR), 4);
}

/* ---- watchdog ---- */

static void set_watchdog(unsigned value) { put(&lab, WDTCSR, WDCE | WDE), put(&lab, WDTCSR, value); }

static unsigned prescaler(unsigned n) { return (n & 7) | (n & 8 ? WDP3 : 0); }

static void each_time_of_the_watchdog(void)
{
    for (unsigned n = 0; n < 10; n++) {
        lab_open(&lab);
        set_watchdog(WDIE | prescaler(n));
        sleep_in(&lab, 2); /* it runs there, too, and nothing else has to */
        lab.chip.sreg = 0;
        uint64_t wanted = 256000ull << n; /* 2048 << n of 128 kHz */
        lab_run(&lab, wanted - 1);
        CHECK_INT(get(&lab, WDTCSR) & WDIF, 0);
        lab_run(&lab, 1);
        CHECK_INT(get(&lab, WDTCSR), WDIF | WDIE | prescaler(n));
    }
}

static void its_interrupt_is_once_where_it_resets_too(void)
{
    lab_open(&lab);
    set_watchdog(WDIE | WDE);
    lab_run(&lab, 256001);
    CHECK_INT(entered(&lab), VECTOR_WDT);
    CHECK_INT(get(&lab, WDTCSR), WDE); /* WDIE is gone: the next one resets */
    CHECK_INT(lab.resets, 0);
    lab_run(&lab, 256000);
    CHECK_INT(lab.resets, 1);
    CHECK_INT(get(&lab, MCUSR), 9);
    CHECK_INT(get(&lab, WDTCSR), WDE);
    put(&lab, WDTCSR, WDCE | WDE), put(&lab, WDTCSR, 0);
    CHECK_INT(get(&lab, WDTCSR), WDE); /* WDRF keeps it */
    put(&lab, MCUSR, 0), put(&lab, WDTCSR, WDCE | WDE), put(&lab, WDTCSR, 0);
    CHECK_INT(get(&lab, WDTCSR), 0);
}

static void it_changes_in_a_timed_sequence(void)
{
    lab_open(&lab);
    put(&lab, WDTCSR, 5);
    CHECK_INT(get(&lab, WDTCSR), 0);
    put(&lab, WDTCSR, WDCE | WDE);
    CHECK_INT(get(&lab, WDTCSR), WDCE);
    lab_run(&lab, 5);
    put(&lab, WDTCSR, 5); /* too late */
    CHECK_INT(get(&lab, WDTCSR), 0);
    set_watchdog(WDE | 5);
    CHECK_INT(get(&lab, WDTCSR), WDE | 5);
    put(&lab, WDTCSR, 0);
    CHECK_INT(get(&lab, WDTCSR), WDE | 5);
    put(&lab, WDTCSR, WDIE); /* at any time */
    CHECK_INT(get(&lab, WDTCSR), WDIE | WDE | 5);
}

void avr_outside_world_tests(void)
{
    RUN(a_one_to_pin_toggles);
    RUN(pud_turns_all_pull_ups_off);
    RUN(each_sense_of_an_external_interrupt);
    RUN(a_level_asks_while_it_is_low_and_has_no_flag);
    RUN(pin_changes_go_by_their_masks);
    RUN(own_outputs_interrupt_as_well);
    RUN(each_time_of_the_watchdog);
    RUN(its_interrupt_is_once_where_it_resets_too);
    RUN(it_changes_in_a_timed_sequence);
}
