/* The ADC and the comparator: DS40002061, Analog-to-Digital Converter; Analog Comparator. */
#include "avr_lab.h"

enum { BANDGAP = 14, GROUND = 15, TEMPERATURE = 8, AVCC = 1 << 6, INTERNAL = 3 << 6, DIV = 2 /* ADPS: 4 clocks */, CLOCK = 4 };

static avr_lab lab;

static void open_adc(unsigned mux)
{
    lab_open(&lab);
    put(&lab, ADMUX, mux);
    put(&lab, ADCSRA, ADEN | DIV);
}

static uint64_t convert(void)
{
    put(&lab, ADCSRA, get(&lab, ADCSRA) | ADSC);
    return until_bits(&lab, ADCSRA, ADSC, 0, 10000);
}

static unsigned result(void)
{
    unsigned low = get(&lab, ADCL);
    return low | (unsigned)get(&lab, ADCH) << 8;
}

static void the_first_conversion_takes_longer(void)
{
    open_adc(AVCC);
    avr_volts(&lab.chip, 0, 2.5);
    CHECK_INT(convert(), (1 + 25) * CLOCK); /* from the next edge of the ADC's clock on */
    CHECK_INT(result(), 512);
    CHECK_INT(convert(), (1 + 13) * CLOCK);
    put(&lab, ADCSRA, 0), put(&lab, ADCSRA, ADEN | DIV);
    CHECK_INT(convert(), (1 + 25) * CLOCK); /* again after each ADEN */
}

static void each_prescaler(void)
{
    static const uint64_t clocks[8] = {2, 2, 4, 8, 16, 32, 64, 128};
    for (unsigned n = 0; n < 8; n++) {
        open_adc(AVCC);
        put(&lab, ADCSRA, ADEN | n);
        convert();
        uint64_t took = convert();
        CHECK(took > 13 * clocks[n] && took <= 14 * clocks[n]);
    }
}

static void its_clock_begins_with_aden(void)
{
    for (unsigned late = 1; late < CLOCK; late++) {
        open_adc(AVCC);
        lab_run(&lab, late);
        CHECK_INT(convert(), (1 + 25) * CLOCK - late);
    }
}

static void it_samples_after_one_and_a_half_clocks(void)
{
    for (uint64_t at = 0; at < 2; at++) {
        open_adc(AVCC);
        convert();
        put(&lab, ADCSRA, ADEN | ADSC | DIV);
        lab_run(&lab, CLOCK + CLOCK * 3 / 2 - 1 + at);
        avr_volts(&lab.chip, 0, 5);
        lab_run(&lab, 100);
        CHECK_INT(result(), at ? 0 : 1023);
    }
}

static void channels_of_its_own(void)
{
    open_adc(AVCC | BANDGAP);
    convert();
    CHECK_INT(result(), (int)(1.1 * 1024 / 5));
    put(&lab, ADMUX, INTERNAL | GROUND), convert();
    CHECK_INT(result(), 0);
    put(&lab, ADMUX, INTERNAL | TEMPERATURE), convert();
    CHECK_NEAR(result(), 0.314 * 1024 / 1.1, 1); /* 25 C */
    put(&lab, ADMUX, INTERNAL | 3), avr_volts(&lab.chip, 3, 2), convert();
    CHECK_INT(result(), 1023); /* above the reference */
    put(&lab, ADMUX, 3), avr_supply(&lab.chip, 5, 4), convert();
    CHECK_INT(result(), 512); /* AREF */
}

static void adlar_shifts_what_is_read(void)
{
    open_adc(AVCC), avr_volts(&lab.chip, 0, 3), convert();
    put(&lab, ADMUX, AVCC | ADLAR);
    CHECK_INT(result(), 614 << 6);
    put(&lab, ADMUX, AVCC);
    CHECK_INT(result(), 614);
}

static void a_result_is_kept_between_its_bytes(void)
{
    open_adc(AVCC), avr_volts(&lab.chip, 0, 3), convert();
    CHECK_INT(get(&lab, ADCL), 614 & 0xff);
    avr_volts(&lab.chip, 0, 1), convert();
    CHECK_INT(get(&lab, ADCH), 614 >> 8);
    CHECK_INT(result(), 614); /* the other is lost */
    convert();
    CHECK_INT(result(), 204);
}

static void free_running_takes_the_channel_of_its_begin(void)
{
    open_adc(AVCC), avr_volts(&lab.chip, 0, 1), avr_volts(&lab.chip, 1, 2);
    put(&lab, ADCSRA, ADEN | ADATE | DIV);
    lab_run(&lab, 200);
    CHECK_INT(get(&lab, ADCSRA) & (ADIF | ADSC), 0); /* the first needs ADSC */
    put(&lab, ADCSRA, ADEN | ADATE | ADSC | DIV);
    lab_run(&lab, 20);
    put(&lab, ADMUX, AVCC | 1); /* for the next */
    until_bits(&lab, ADCSRA, ADIF, ADIF, 200);
    CHECK_INT(result(), 204);
    put(&lab, ADCSRA, ADEN | ADATE | ADIF | DIV);
    CHECK_INT(until_bits(&lab, ADCSRA, ADIF, ADIF, 200), 13 * CLOCK);
    CHECK_INT(result(), 409);
}

/* From the trigger on: 3 clocks of the CPU, 13.5 of the ADC; none while its flag stays. */
static void check_trigger(unsigned source, void (*fire)(void), unsigned flags, unsigned flag)
{
    open_adc(AVCC), convert();
    put(&lab, ADCSRB, source), put(&lab, ADCSRA, ADEN | ADATE | ADIF | DIV);
    put(&lab, flags, 0xff);
    fire();
    until_bits(&lab, ADCSRA, ADSC, ADSC, 2000);
    CHECK_INT(until_bits(&lab, ADCSRA, ADSC, 0, 2000), 3 + CLOCK * 27 / 2);
    fire();
    lab_run(&lab, 700);
    CHECK_INT(avr_peek(&lab.chip, (uint16_t)flags) & flag, flag);
    put(&lab, ADCSRA, ADEN | ADATE | ADIF | DIV);
    lab_run(&lab, 700);
    CHECK_INT(get(&lab, ADCSRA) & ADIF, 0);
}

static void fire_comparator(void) { put(&lab, ACSR, 3), avr_pin(&lab.chip, D + 6, 0), lab_run(&lab, 9), avr_pin(&lab.chip, D + 6, 1); }
static void fire_int0(void) { put(&lab, EICRA, 3), avr_pin(&lab.chip, D + 2, 0), lab_run(&lab, 9), avr_pin(&lab.chip, D + 2, 1); }
static void fire_t0(void) { put(&lab, OCR0A, 20), put(&lab, TCCR0B, 1); }
static void fire_t1(void) { put(&lab, TCCR1A, 1), put(&lab, OCR1BH, 0), put(&lab, OCR1BL, 20), put(&lab, TCCR1B, 9); } /* fast, 8 bits */
static void fire_capture(void) { put(&lab, TCCR1B, ICES1), avr_pin(&lab.chip, B, 0), lab_run(&lab, 9), avr_pin(&lab.chip, B, 1); }

static void each_trigger(void)
{
    check_trigger(1, fire_comparator, ACSR, ACI);
    check_trigger(2, fire_int0, EIFR, 1);
    check_trigger(3, fire_t0, TIFR0, OCFA);
    check_trigger(4, fire_t0, TIFR0, TOV);
    check_trigger(5, fire_t1, TIFR1, OCFB);
    check_trigger(6, fire_t1, TIFR1, TOV);
    check_trigger(7, fire_capture, TIFR1, ICF1);
}

/* ICR1 as TOP sets the same flag. */
static void top_in_icr1_triggers_too(void)
{
    open_adc(AVCC), convert();
    put(&lab, ADCSRB, 7), put(&lab, ADCSRA, ADEN | ADATE | ADIF | DIV);
    put(&lab, TCCR1B, 0x18), put(&lab, ICR1H, 0), put(&lab, ICR1L, 50), put(&lab, TCCR1B, 0x19);
    CHECK_INT(until_bits(&lab, ADCSRA, ADSC, ADSC, 2000), 51);
}

static void another_source_whose_flag_is_set_triggers(void)
{
    open_adc(AVCC), convert();
    put(&lab, ADCSRA, ADEN | ADATE | ADIF | DIV), put(&lab, ADCSRB, 1);
    put(&lab, TCCR0B, 1), lab_run(&lab, 300), put(&lab, TCCR0B, 0);
    CHECK_INT(get(&lab, ADCSRA) & ADSC, 0);
    put(&lab, ADCSRB, 4);
    CHECK_INT(get(&lab, ADCSRA) & ADSC, ADSC);
}

static void sleep_begins_a_conversion_idle_and_quiet(void)
{
    for (unsigned mode = 0; mode < 3; mode++) {
        open_adc(AVCC), convert();
        put(&lab, ADCSRA, ADEN | ADIE | ADIF | DIV);
        sleep_in(&lab, mode);
        lab_run(&lab, 14 * CLOCK + 8);
        CHECK_INT(!lab.chip.asleep, mode < 2);
    }
}

static void the_comparator_compares(void)
{
    lab_open(&lab);
    CHECK_INT(get(&lab, ACSR) & ACO, 0);
    avr_pin(&lab.chip, D + 6, 1);
    CHECK_INT(get(&lab, ACSR) & ACO, ACO);
    avr_pin(&lab.chip, D + 7, 1);
    CHECK_INT(get(&lab, ACSR) & ACO, 0);
    put(&lab, ACSR, ACBG); /* 1.1 V against AIN1 */
    CHECK_INT(get(&lab, ACSR) & ACO, 0);
    avr_pin(&lab.chip, D + 7, 0);
    CHECK_INT(get(&lab, ACSR) & ACO, ACO);
    put(&lab, ACSR, ACBG | ACD);
    CHECK_INT(get(&lab, ACSR) & ACO, 0); /* off */
}

static void a_channel_may_be_its_negative_input(void)
{
    lab_open(&lab);
    put(&lab, ADCSRB, ACME), put(&lab, ADMUX, 3), put(&lab, ACSR, ACBG);
    CHECK_INT(get(&lab, ACSR), ACBG | ACO | ACI);
    put(&lab, ACSR, ACBG | ACI | ACIE | 2); /* falling: the channel comes above 1.1 V */
    avr_volts(&lab.chip, 3, 1.2);
    lab_run(&lab, 1);
    CHECK_INT(entered(&lab), VECTOR_COMPARATOR);
    CHECK_INT(get(&lab, ACSR) & ACI, 0);
    put(&lab, ADCSRA, ADEN); /* the multiplexer is the ADC's: AIN1, low */
    CHECK_INT(get(&lab, ACSR) & ACO, ACO);
}

static void each_edge_of_the_comparator(void)
{
    static const uint8_t seen[4] = {3, 0, 2, 1}; /* by ACIS: rising 1, falling 2 */
    for (unsigned sense = 0; sense < 4; sense++) {
        if (sense == 1) continue; /* reserved */
        lab_open(&lab);
        put(&lab, ACSR, sense);
        for (int level = 1; level >= 0; level--) {
            avr_pin(&lab.chip, D + 6, level);
            lab_run(&lab, 5);
            CHECK_INT(avr_peek(&lab.chip, ACSR) & ACI, seen[sense] & (level ? 1 : 2) ? ACI : 0);
            put(&lab, ACSR, sense | ACI);
        }
    }
}

static void the_comparator_captures(void)
{
    lab_open(&lab);
    put(&lab, ACSR, ACIC), put(&lab, TCCR1B, ICES1 | 1);
    lab_run(&lab, 40);
    avr_pin(&lab.chip, B, 1); /* ICP1 is not looked at */
    lab_run(&lab, 10);
    CHECK_INT(get(&lab, TIFR1) & ICF1, 0);
    avr_pin(&lab.chip, D + 6, 1);
    lab_run(&lab, 10);
    CHECK_INT(get(&lab, TIFR1) & ICF1, ICF1);
    CHECK_INT(get(&lab, ICR1L), 53);
}

static void digital_inputs_may_be_off(void)
{
    lab_open(&lab);
    avr_pin(&lab.chip, C + 2, 1), avr_pin(&lab.chip, D + 7, 1), lab_run(&lab, 5);
    put(&lab, PCMSK1, 4), put(&lab, DIDR0, 4), put(&lab, DIDR1, 2);
    CHECK_INT(get(&lab, PINC) & 4, 0);
    CHECK_INT(get(&lab, PIND) & 0x80, 0);
    avr_pin(&lab.chip, C + 2, 0), lab_run(&lab, 5);
    CHECK_INT(get(&lab, PCIFR), 0);
    put(&lab, DIDR1, 0);
    CHECK_INT(get(&lab, PIND) & 0x80, 0x80);
}

void avr_analogue_tests(void)
{
    RUN(the_first_conversion_takes_longer);
    RUN(each_prescaler);
    RUN(its_clock_begins_with_aden);
    RUN(it_samples_after_one_and_a_half_clocks);
    RUN(channels_of_its_own);
    RUN(adlar_shifts_what_is_read);
    RUN(a_result_is_kept_between_its_bytes);
    RUN(free_running_takes_the_channel_of_its_begin);
    RUN(each_trigger);
    RUN(top_in_icr1_triggers_too);
    RUN(another_source_whose_flag_is_set_triggers);
    RUN(sleep_begins_a_conversion_idle_and_quiet);
    RUN(the_comparator_compares);
    RUN(a_channel_may_be_its_negative_input);
    RUN(each_edge_of_the_comparator);
    RUN(the_comparator_captures);
    RUN(digital_inputs_may_be_off);
}
