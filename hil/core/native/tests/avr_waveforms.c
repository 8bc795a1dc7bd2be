/* Timers: DS40002061, 8-bit Timer/Counter0, 16-bit Timer/Counter1, Prescalers, 8-bit Timer/Counter2. */
#include "avr_lab.h"

enum { OC1A = B + 1, OC1B = B + 2, OC0A = D + 6, OC0B = D + 5, ICP1 = B, T0 = D + 4, T1 = D + 5 };

static avr_lab lab;

static void put_wide(unsigned low, unsigned value) { put(&lab, low + 1, value >> 8), put(&lab, low, value); }

static unsigned get_wide(unsigned low)
{
    unsigned byte = get(&lab, low);
    return byte | (unsigned)get(&lab, low + 1) << 8;
}

/* Timer 1 in a mode, OC1A cleared going up (COM 2), from count 0 on; the pin is an output. */
static void open_1(unsigned mode, unsigned top, unsigned compare)
{
    lab_open(&lab);
    put(&lab, DDRB, 6);
    put(&lab, TCCR1B, (mode & 12) << 1), put(&lab, TCCR1A, 0x80 | (mode & 3));
    int is_capture = mode == 8 || mode == 10 || mode == 12 || mode == 14;
    if (is_capture) put_wide(ICR1L, top);
    put_wide(OCR1AL, compare);
    put(&lab, TCCR1B, (mode & 12) << 1 | 1);
}

/* Length of the period at OC1A, and of its high part, once it has settled. */
static void check_pwm(unsigned mode, unsigned top, unsigned compare, unsigned period, unsigned high)
{
    open_1(mode, top, compare);
    lab_run(&lab, 6 * period + 10);
    int first = edges_of(&lab, OC1A) - 6;
    if (high == 0 || high == period) {
        lab.count = 0;
        lab_run(&lab, 3 * period);
        CHECK_INT(edges_of(&lab, OC1A), 0);
        CHECK_INT(avr_level(&lab.chip, OC1A), high != 0);
        return;
    }
    if (first < 0) {
        CHECK_FAILED("mode %u: %d edges", mode, first + 6);
        return;
    }
    while (drive_of(&lab, OC1A, first) != AVR_HIGH) first++;
    CHECK_INT(edge_of(&lab, OC1A, first + 2) - edge_of(&lab, OC1A, first), period);
    CHECK_INT(edge_of(&lab, OC1A, first + 1) - edge_of(&lab, OC1A, first), high);
}

static void pwm_has_its_periods_also_at_the_ends(void)
{
    static const struct { unsigned mode, top; } dual[] = {{1, 0xff}, {2, 0x1ff}, {3, 0x3ff}, {8, 100}, {10, 100}}, single[] = {{5, 0xff}, {6, 0x1ff}, {7, 0x3ff}, {14, 100}};
    for (int n = 0; n < 5; n++) {
        unsigned top = dual[n].top;
        check_pwm(dual[n].mode, top, 30, 2 * top, 60);
        check_pwm(dual[n].mode, top, 0, 2 * top, 0);
        check_pwm(dual[n].mode, top, top, 2 * top, 2 * top);
        check_pwm(dual[n].mode, top, top - 1, 2 * top, 2 * top - 2);
    }
    for (int n = 0; n < 4; n++) {
        unsigned top = single[n].top;
        check_pwm(single[n].mode, top, 30, top + 1, 31);
        check_pwm(single[n].mode, top, 0, top + 1, 1); /* a spike */
        check_pwm(single[n].mode, top, top, top + 1, top + 1);
    }
}

/* When a new compare value is at work: TOP, BOTTOM, at once. */
static void compare_values_wait_for_their_place(void)
{
    static const struct { unsigned mode, at; } cases[] = {{10, 100}, {8, 200}, {14, 101}, {12, 60}};
    for (int n = 0; n < 4; n++) {
        open_1(cases[n].mode, 100, 30);
        lab_run(&lab, 60); /* the count is 60 */
        CHECK_INT(get_wide(TCNT1L), 60);
        put_wide(OCR1AL, 50);
        CHECK_INT(get_wide(OCR1AL), 50); /* what was written */
        uint64_t from = lab.chip.cycle - 60;
        while (lab.chip.timer[1].compare[0] != 50 && lab.chip.cycle < 1000) {
            lab_run(&lab, 1);
            get(&lab, TCNT1L);
        }
        CHECK_NEAR((double)(lab.chip.cycle - from), cases[n].at, 1);
    }
}

static void toggling_halves_the_frequency(void)
{
    open_1(15, 0, 49);
    put(&lab, TCCR1A, 0x43);
    lab_run(&lab, 1000);
    CHECK_INT(edge_of(&lab, OC1A, 8) - edge_of(&lab, OC1A, 6), 100);
    open_1(14, 49, 20);
    put(&lab, TCCR1A, 0x12); /* OC1B never toggles in PWM: the port has it */
    lab_run(&lab, 1);
    lab.count = 0;
    lab_run(&lab, 300);
    CHECK_INT(edges_of(&lab, OC1B), 0);
}

static void tov_is_where_each_mode_has_it(void)
{
    static const struct { unsigned mode, first, again; } cases[] = {
        {0, 0x10000, 0x10000}, {12, 0, 0}, {14, 101, 101}, {10, 200, 200}, {8, 200, 200}};
    for (int n = 0; n < 5; n++) {
        open_1(cases[n].mode, 100, 10);
        lab_run(&lab, 3); /* a dual slope passes BOTTOM where it begins */
        put(&lab, TIFR1, TOV);
        uint64_t took = until_bits(&lab, TIFR1, TOV, TOV, 70000);
        if (!cases[n].first) {
            CHECK_INT(avr_peek(&lab.chip, TIFR1) & TOV, 0); /* not at TOP of CTC */
            continue;
        }
        CHECK_NEAR((double)took + 3, cases[n].first, 1);
        put(&lab, TIFR1, TOV);
        CHECK_INT(until_bits(&lab, TIFR1, TOV, TOV, 70000), cases[n].again);
    }
}

static void foc_sets_pins_and_no_flag(void)
{
    lab_open(&lab);
    put(&lab, DDRD, 0x60), put(&lab, TCCR0A, 0x70); /* toggle OC0A, set OC0B */
    put(&lab, TCCR0B, 0x80);
    CHECK_INT(avr_level(&lab.chip, OC0A), 1);
    CHECK_INT(avr_level(&lab.chip, OC0B), 0);
    put(&lab, TCCR0B, 0xc0);
    CHECK_INT(avr_level(&lab.chip, OC0A), 0);
    CHECK_INT(avr_level(&lab.chip, OC0B), 1);
    CHECK_INT(get(&lab, TIFR0), 0);
    CHECK_INT(get(&lab, TCCR0B), 0); /* they read as 0 */
    put(&lab, TCCR0A, 0x73), put(&lab, TCCR0B, 0x88); /* in PWM nothing */
    CHECK_INT(avr_level(&lab.chip, OC0A), 0);
}

static void a_held_prescaler_begins_where_it_is_let_go(void)
{
    lab_open(&lab);
    put(&lab, TCCR0B, 3), put(&lab, TCCR1B, 3), put(&lab, TCCR2B, 4); /* 64 each */
    lab_run(&lab, 100);
    put(&lab, GTCCR, TSM | PSRSYNC | PSRASY);
    lab_run(&lab, 333);
    CHECK_INT(get(&lab, GTCCR), TSM | PSRSYNC | PSRASY);
    put(&lab, TCNT0, 10), put_wide(TCNT1L, 10), put(&lab, TCNT2, 10);
    put(&lab, GTCCR, 0);
    lab_run(&lab, 63);
    CHECK_INT(get(&lab, TCNT0), 10);
    CHECK_INT(get(&lab, TCNT2), 10);
    lab_run(&lab, 1);
    CHECK_INT(get(&lab, TCNT0), 11);
    CHECK_INT(get_wide(TCNT1L), 11);
    CHECK_INT(get(&lab, TCNT2), 11);
    put(&lab, GTCCR, PSRSYNC); /* alone it is over at once */
    CHECK_INT(get(&lab, GTCCR), 0);
}

static void edges_at_t0_and_t1_are_counted(void)
{
    for (int rising = 0; rising < 2; rising++) {
        lab_open(&lab);
        put(&lab, TCCR0B, 6u + (unsigned)rising), put(&lab, TCCR1B, 6u + (unsigned)rising);
        avr_pin(&lab.chip, T0, 0), avr_pin(&lab.chip, T1, 0);
        for (int n = 0; n < 7; n++) {
            lab_run(&lab, 10);
            avr_pin(&lab.chip, T0, n % 2 == 0), avr_pin(&lab.chip, T1, n % 2 == 0);
        }
        lab_run(&lab, 10);
        CHECK_INT(get(&lab, TCNT0), rising ? 4 : 3);
        CHECK_INT(get_wide(TCNT1L), rising ? 4 : 3);
    }
}

static void the_noise_canceller_wants_four_equal_samples(void)
{
    for (unsigned width = 2; width < 6; width++) {
        lab_open(&lab);
        put(&lab, TCCR1B, ICNC1 | ICES1 | 1);
        lab_run(&lab, 100);
        avr_pin(&lab.chip, ICP1, 1), lab_run(&lab, width);
        avr_pin(&lab.chip, ICP1, 0), lab_run(&lab, 20);
        CHECK_INT(get(&lab, TIFR1) & ICF1, width < 4 ? 0 : ICF1);
    }
    lab_open(&lab);
    put(&lab, TCCR1B, ICNC1 | 1), avr_pin(&lab.chip, ICP1, 1), lab_run(&lab, 100);
    avr_pin(&lab.chip, ICP1, 0), lab_run(&lab, 20);
    unsigned filtered = get_wide(ICR1L);
    put(&lab, TIFR1, ICF1), put(&lab, TCCR1B, 1), avr_pin(&lab.chip, ICP1, 1), lab_run(&lab, 80);
    avr_pin(&lab.chip, ICP1, 0), lab_run(&lab, 20);
    CHECK_INT(get_wide(ICR1L) - filtered, 100 - 4);
}

static void temp_is_shared(void)
{
    lab_open(&lab);
    put_wide(TCNT1L, 0x1234), put_wide(OCR1AL, 0x5678);
    put(&lab, OCR1BH, 0x9a);
    CHECK_INT(get(&lab, OCR1AH), 0x56); /* is read without it */
    put(&lab, TCNT1L, 0xbc);
    CHECK_INT(get_wide(TCNT1L), 0x9abc);
    get(&lab, TCNT1L);
    put(&lab, OCR1BL, 0x11);
    CHECK_INT(get_wide(OCR1BL), 0x9a11);
    put_wide(ICR1L, 0x4444); /* read only, but in modes that have it as TOP */
    CHECK_INT(get_wide(ICR1L), 0);
}

static void a_count_beyond_the_compare_value_goes_round(void)
{
    lab_open(&lab);
    put(&lab, TCCR0A, 2), put(&lab, OCR0A, 20), put(&lab, TCCR0B, 1);
    lab_run(&lab, 10);
    put(&lab, OCR0A, 5); /* missed: up to 255, then as before */
    put(&lab, TIFR0, 7);
    CHECK_INT(until_bits(&lab, TIFR0, OCFA, OCFA, 1000), 246 + 6);
    CHECK_INT(avr_peek(&lab.chip, TIFR0) & TOV, TOV);
}

void avr_waveforms_tests(void)
{
    RUN(pwm_has_its_periods_also_at_the_ends);
    RUN(compare_values_wait_for_their_place);
    RUN(toggling_halves_the_frequency);
    RUN(tov_is_where_each_mode_has_it);
    RUN(foc_sets_pins_and_no_flag);
    RUN(a_held_prescaler_begins_where_it_is_let_go);
    RUN(edges_at_t0_and_t1_are_counted);
    RUN(the_noise_canceller_wants_four_equal_samples);
    RUN(temp_is_shared);
    RUN(a_count_beyond_the_compare_value_goes_round);
}
