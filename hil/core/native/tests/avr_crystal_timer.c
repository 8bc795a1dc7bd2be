/* Timer 2 by a crystal of its own: DS40002061, Asynchronous Operation of Timer/Counter2, ASSR. */
#include "../mcu/avr/avr_crystal.h"
#include "../mcu/avr/avr_time.h"
#include "avr_lab.h"

enum { HZ = 32768, EDGES_OF_256 = 125000 /* cycles of 256 edges at 16 MHz */, BUSY = 0x1f };

static avr_lab lab;

static void open_with(uint32_t hz, unsigned assr)
{
    lab_open(&lab);
    avr_crystal_at(&lab.chip, hz, 0);
    put(&lab, ASSR, assr);
}

/* Until nothing is busy. */
static uint64_t settle(void) { return until_bits(&lab, ASSR, BUSY, 0, 1000000); }

static void it_counts_time_in_the_world(void)
{
    open_with(HZ, AS2);
    put(&lab, TCCR2B, 5); /* 128: an overflow each second */
    settle();
    sleep_in(&lab, 3); /* power-save: nothing else has to run */
    lab.chip.sreg = 0;
    lab_until(&lab, 16000000);
    uint64_t first = until_bits(&lab, TIFR2, TOV, TOV, 16000000) + 16000000;
    put(&lab, TIFR2, TOV);
    lab_run(&lab, 15900000);
    CHECK_INT(avr_peek(&lab.chip, TIFR2) & TOV, 0);
    until_bits(&lab, TIFR2, TOV, TOV, 200000);
    CHECK_INT(lab.chip.cycle - first, 16000000);
}

static void what_is_written_takes_two_edges(void)
{
    open_with(HZ, AS2);
    lab_run(&lab, 100);
    put(&lab, OCR2A, 0x12), put(&lab, OCR2B, 0x34), put(&lab, TCCR2A, 2), put(&lab, TCCR2B, 1), put(&lab, TCNT2, 7);
    CHECK_INT(get(&lab, ASSR), AS2 | BUSY);
    CHECK_INT(get(&lab, OCR2A), 0x12); /* what was written */
    CHECK_INT(get(&lab, TCCR2B), 1);
    CHECK_INT(get(&lab, TCNT2), 0); /* the counter's own */
    CHECK_INT(lab.chip.timer[2].compare[0], 0);
    uint64_t took = settle();
    CHECK(took > 16000000 / HZ && took <= 2 * 16000000 / HZ + 1);
    CHECK_INT(lab.chip.timer[2].compare[0], 0x12);
    CHECK_INT(get(&lab, TCNT2), 7);
    uint64_t from = lab.chip.cycle;
    until_bits(&lab, TIFR2, OCFA, OCFA, 100000);
    CHECK_INT((lab.chip.cycle - from + 244) / 488, 0x12 - 7 + 1); /* edges */
}

static void without_a_crystal_it_stands_still(void)
{
    for (int is_off = 0; is_off < 2; is_off++) {
        open_with(is_off ? HZ : 0, is_off ? AS2 | EXCLK : AS2); /* EXCLK: the crystal does not run */
        put(&lab, TCCR2B, 1);
        CHECK_INT(settle(), 1000000);
        CHECK_INT(get(&lab, TCNT2), 0);
        CHECK_INT(get(&lab, ASSR) & BUSY, 1);
        put(&lab, ASSR, 0);
        CHECK_INT(get(&lab, ASSR), 0);
        put(&lab, TCCR2B, 1); /* by the chip's clock it counts */
        lab_run(&lab, 100);
        CHECK_INT(get(&lab, TCNT2), 100);
    }
}

static void a_clock_comes_for_exclk(void)
{
    lab_open(&lab);
    avr_crystal_at(&lab.chip, 1000000, 1);
    put(&lab, ASSR, EXCLK | AS2);
    put(&lab, TCCR2B, 1);
    lab_run(&lab, 16 * 102);
    CHECK_NEAR(get(&lab, TCNT2), 100, 1);
}

static void power_save_leaves_it_running(void)
{
    enum { POWER_SAVE = 3, POWER_DOWN = 2 };
    for (int mode = POWER_DOWN; mode <= POWER_SAVE; mode++) {
        open_with(HZ, AS2);
        put(&lab, TCCR2B, 1);
        settle();
        put(&lab, TIMSK2, TOV), put(&lab, TIFR2, TOV);
        sleep_in(&lab, (unsigned)mode);
        uint64_t from = lab.chip.cycle;
        while (lab.chip.asleep && lab.chip.cycle < from + 3 * EDGES_OF_256) lab_run(&lab, 100);
        if (mode == POWER_DOWN) {
            CHECK(lab.chip.asleep); /* there the crystal stands, too */
            continue;
        }
        CHECK(!lab.chip.asleep);
        CHECK(lab.chip.cycle - from <= EDGES_OF_256);
        lab_run(&lab, 16384 + 4 + 10); /* the chip's crystal starts up */
        CHECK_INT(lab.chip.sreg & FLAG_I, 0);
        CHECK_NEAR(get(&lab, TCNT2), (16384 + 14) * 32768.0 / 16e6, 1.5);
    }
}

static void another_clock_of_the_chip_changes_nothing(void)
{
    open_with(HZ, AS2);
    put(&lab, TCCR2B, 1);
    settle();
    lab_until(&lab, EDGES_OF_256);
    unsigned count = get(&lab, TCNT2);
    avr_set_clock_shift(&lab.chip, 4, lab.chip.t);
    lab_run(&lab, EDGES_OF_256 / 2);
    CHECK_NEAR((uint8_t)(get(&lab, TCNT2) - count), 128, 1);
    avr_clock(&lab.chip, 8e6); /* cycles are twice as long */
    lab_run(&lab, EDGES_OF_256 / 16);
    CHECK_NEAR((uint8_t)(get(&lab, TCNT2) - count), 160, 1);
}

static void prr_does_not_stop_it(void)
{
    open_with(HZ, AS2);
    put(&lab, TCCR2B, 1);
    settle();
    put(&lab, PRR, PRTIM2);
    unsigned count = get(&lab, TCNT2);
    lab_run(&lab, EDGES_OF_256 / 8);
    CHECK_NEAR((uint8_t)(get(&lab, TCNT2) - count), 32, 1);
}

void avr_crystal_timer_tests(void)
{
    RUN(it_counts_time_in_the_world);
    RUN(what_is_written_takes_two_edges);
    RUN(without_a_crystal_it_stands_still);
    RUN(a_clock_comes_for_exclk);
    RUN(power_save_leaves_it_running);
    RUN(another_clock_of_the_chip_changes_nothing);
    RUN(prr_does_not_stop_it);
}
