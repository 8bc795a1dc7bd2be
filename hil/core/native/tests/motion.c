/* The motion engine alone: what tests/motion_model.py of the profile leaves out (loops, arrays, retargeting, the
   external clock), totals, and what must not hang. */
#include "../motion/motion.h"
#include "../motion/profile.h"
#include "fixture.h"

static const motion_setup SETUP = {.steps_per_rev = 200, .slow_rpm = 10, .pulse_us = 30, .interrupt_overhead_us = 8,
                                   .is_clock_internal = 1, .ops = 36, .external_clock_Hz = 1000000};
static const motion_entry MOVE = {.steps = 200, .rpm = 100, .cycle_us = 3000, .acc_hundredths = 100, .dec_hundredths = 100};

enum { LOG = 4096 };

typedef struct bench {
    motion m;
    int64_t now, pulses, last_pulse;
    int begun[LOG], n_begun; /* slots */
    int64_t begun_at[LOG], ended_at[LOG];
    int n_ended;
} bench;

static bench *new_motion(const motion_setup *setup)
{
    bench *b = calloc(1, sizeof *b);
    motion_init(&b->m, setup);
    return b;
}

static void run_until(bench *b, int64_t until)
{
    for (int64_t next; (next = motion_next(&b->m)) <= until && next < MOTION_NEVER;) {
        int64_t begun = b->m.begun, ended = b->m.ended;
        CHECK(next >= b->now);
        b->now = next;
        if (motion_run(&b->m)) {
            b->pulses++;
            b->last_pulse = next;
        }
        if (b->m.ended > ended && b->n_ended < LOG) b->ended_at[b->n_ended++] = next;
        if (b->m.begun > begun && b->n_begun < LOG) {
            b->begun_at[b->n_begun] = next;
            b->begun[b->n_begun++] = b->m.slot;
        }
    }
    b->now = until;
}

static void set(bench *b, int slot, motion_entry e) { b->m.entries[slot] = e; }

static motion_entry steps(uint32_t n)
{
    motion_entry e = MOVE;
    e.steps = n;
    return e;
}

static void check_slots(const bench *b, int n, const int *slots)
{
    CHECK_INT(b->n_begun, n);
    for (int i = 0; i < n && i < b->n_begun; i++) CHECK_INT(b->begun[i], slots[i]);
}
#define CHECK_SLOTS(b, ...) \
    check_slots(b, (int)(sizeof((int[]){__VA_ARGS__}) / sizeof(int)), (const int[]){__VA_ARGS__})

/* Manual, harmonic curve: 90 steps from 10 to 100 RPM; 704,486 us. */
static void a_move_has_the_manuals_times(void)
{
    bench *b = new_motion(&SETUP);
    set(b, 1, MOVE);
    motion_enqueue(&b->m, 1, 1000);
    CHECK_INT(motion_next(&b->m), 1000);
    run_until(b, 1000 + 2 * 704486 - 1);
    CHECK_INT(b->pulses, 90);
    CHECK_INT(b->m.state, MOTION_ACCEL);
    run_until(b, 1000 + 2 * 704486);
    CHECK_INT(b->pulses, 91);
    CHECK_INT(b->m.state, MOTION_CRUISE);
    run_until(b, 1000 + 2 * (704486 + 20 * 3000));
    CHECK_INT(b->m.state, MOTION_DECEL);
    run_until(b, INT64_C(1) << 40);
    CHECK_INT(b->pulses, 200);
    CHECK_INT(b->ended_at[0], 1000 + 2 * (2 * 704486 + 20 * 3000)); /* one period after the last pulse */
    CHECK_INT(b->m.state, MOTION_STANDBY);
    free(b);
}

/* Days of pulses, and not one half-microsecond lost. */
static void times_stay_exact_over_days(void)
{
    bench *b = new_motion(&SETUP);
    motion_entry e = {.steps = 100000000, .rpm = 5, .cycle_us = 60000, .acc_hundredths = 100, .dec_hundredths = 100};
    b->m.setup.microstep_exponent = 1;
    set(b, 1, e);
    int64_t start = INT64_C(2000000) * 86400 * 365;
    motion_enqueue(&b->m, 1, start);
    run_until(b, start + INT64_C(2) * 60000 * 500000);
    CHECK_INT(b->pulses, 1000001);
    CHECK_INT(b->last_pulse, start + INT64_C(2) * 60000 * 500000);
    free(b);
}

/* Pulse i of a step starts (i * 2 * period) >> J after the step. */
static void a_steps_pulses_share_its_period_exactly(void)
{
    for (int j = 0; j <= 7; j++) {
        motion_setup s = SETUP;
        s.microstep_exponent = j;
        bench *b = new_motion(&s);
        motion_entry e = {.steps = 3, .rpm = 1, .cycle_us = 300007};
        set(b, 1, e);
        motion_enqueue(&b->m, 1, 0);
        for (int i = 0; i < 3 << j; i++) {
            int64_t at = INT64_C(2) * 300007 * (i >> j) + ((i & ((1 << j) - 1)) * INT64_C(2) * 300007 >> j);
            run_until(b, at - 1);
            CHECK_INT(b->pulses, i);
            run_until(b, at);
            CHECK_INT(b->pulses, i + 1);
        }
        free(b);
    }
}

static motion_entry random_entry(uint64_t *random)
{
    static const int32_t ramps[] = {0, 1, 40, 100, 1047, 5000, 99899, 99900};
    int64_t cycle = 150 + random_below(random, 40000);
    return (motion_entry){
        .steps = (uint32_t)random_below(random, 500), .rpm = (uint32_t)(300000 / cycle), .cycle_us = (uint32_t)cycle,
        .acc_hundredths = ramps[random_below(random, 8)], .dec_hundredths = ramps[random_below(random, 8)],
        .is_ccw = random_below(random, 2) == 0, .is_linear = random_below(random, 2) == 0,
        .is_pulses = random_below(random, 2) == 0};
}

static void totals_are_exact_whatever_the_ramps(void)
{
    uint64_t random = 3;
    for (int round = 0; round < 400; round++) {
        motion_setup s = SETUP;
        s.microstep_exponent = (int32_t)random_below(&random, 8);
        bench *b = new_motion(&s);
        int64_t pulses = 0, way = 0;
        for (int slot = 1; slot <= 8; slot++) {
            motion_entry e = random_entry(&random);
            int64_t n = (int64_t)e.steps << (e.is_pulses ? 0 : s.microstep_exponent);
            set(b, slot, e);
            motion_enqueue(&b->m, slot, 0);
            pulses += n;
            way += e.is_ccw ? -n : n;
        }
        run_until(b, INT64_C(1) << 50);
        CHECK_INT(b->pulses, pulses);
        CHECK_INT(b->m.pulses, way);
        CHECK_INT(b->n_ended, 8);
        CHECK_INT(b->m.state, MOTION_STANDBY);
        free(b);
    }
}

static void a_loop_begins_with_both_ends_and_wraps(void)
{
    bench *b = new_motion(&SETUP);
    for (int slot = 1; slot <= 30; slot++) set(b, slot, steps(2));
    motion_loop_passes(&b->m, 2);
    motion_loop_bounds(&b->m, 0, 2, 0);
    CHECK_INT(motion_next(&b->m), MOTION_NEVER);
    motion_loop_bounds(&b->m, 2, 0, 0); /* equal ends are refused */
    CHECK_INT(motion_next(&b->m), MOTION_NEVER);
    motion_loop_bounds(&b->m, 29, 0, 0);
    run_until(b, INT64_C(1) << 40);
    CHECK_SLOTS(b, 29, 30, 1, 2, 29, 30, 1, 2);
    CHECK_INT(b->m.loop.is_on + b->m.loop.start + b->m.loop.finish, 0); /* counters and ends are cleared */
    free(b);
}

static void commands_entered_during_a_loop_run_after_it(void)
{
    bench *b = new_motion(&SETUP);
    for (int slot = 1; slot <= 5; slot++) set(b, slot, steps(2));
    motion_loop_bounds(&b->m, 1, 2, 0);
    motion_enqueue(&b->m, 5, 1);
    run_until(b, 2 * 2 * 60000 * 2);
    CHECK(b->n_begun > 2);
    motion_loop_passes(&b->m, 1); /* this pass is the last */
    int so_far = b->n_begun;
    run_until(b, INT64_C(1) << 40);
    CHECK(b->n_begun <= so_far + 2);
    CHECK_INT(b->begun[b->n_begun - 1], 5);
    CHECK_INT(b->begun[b->n_begun - 2], 2);
    free(b);
}

/* Manual, xRef: interrupt and return. */
static void what_x_interrupts_goes_on_with_its_next_entry(void)
{
    bench *b = new_motion(&SETUP);
    for (int slot = 1; slot <= 9; slot++) set(b, slot, steps(40));
    motion_loop_passes(&b->m, 1);
    motion_loop_bounds(&b->m, 1, 3, 0);
    run_until(b, 100000);
    int64_t end = motion_next(&b->m); /* of the present period */
    motion_once(&b->m, 9, 100000);
    run_until(b, end);
    CHECK_INT(b->ended_at[0], end);
    CHECK_INT(b->begun_at[1], end);
    run_until(b, INT64_C(1) << 40);
    CHECK_SLOTS(b, 1, 9, 2, 3);
    free(b);
}

static void continuous_motion_cut_by_x_is_gone_but_not_what_it_interrupted(void)
{
    bench *b = new_motion(&SETUP);
    for (int slot = 0; slot <= 9; slot++) set(b, slot, steps(slot ? 40 : 0));
    motion_enqueue(&b->m, 1, 0);
    motion_enqueue(&b->m, 2, 0);
    run_until(b, 100000);
    motion_once(&b->m, MOTION_CONTINUOUS_SLOT, 100000);
    run_until(b, 10000000);
    CHECK_INT(b->m.state, MOTION_CRUISE);
    motion_once(&b->m, 9, 10000000);
    run_until(b, INT64_C(1) << 40);
    CHECK_SLOTS(b, 1, 0, 9, 2);
    free(b);
}

static void an_array_loops_and_ends_at_its_0(void)
{
    bench *b = new_motion(&SETUP);
    for (int slot = 1; slot <= 9; slot++) set(b, slot, steps(2));
    motion_loop_array(&b->m, 1, 0); /* it is empty */
    CHECK_INT(motion_next(&b->m), MOTION_NEVER);
    memcpy(b->m.xref, (uint8_t[]){1, 3, 3, 7}, 4);
    motion_loop_array(&b->m, 2, 0);
    run_until(b, INT64_C(1) << 40);
    CHECK_SLOTS(b, 1, 3, 3, 7, 1, 3, 3, 7);
    CHECK_INT(b->m.array.is_on, 0);
    for (int i = 0; i <= MOTION_QUEUE; i++) b->m.xref[i] = (uint8_t)(i < MOTION_QUEUE ? 1 : 0);
    motion_loop_array(&b->m, 1, b->now);
    run_until(b, INT64_C(1) << 41);
    CHECK_INT(b->n_begun, 8 + MOTION_QUEUE);
    free(b);
}

static void n_goes_on_with_the_loop_and_s_ends_it(void)
{
    bench *b = new_motion(&SETUP);
    for (int slot = 1; slot <= 3; slot++) set(b, slot, steps(400));
    motion_loop_bounds(&b->m, 1, 3, 0);
    run_until(b, 3000000);
    motion_next_command(&b->m, 0, 3000000);
    CHECK_INT(motion_next(&b->m), 3000000 + 32); /* 16 us to load */
    run_until(b, 6000000);
    motion_stop(&b->m, 6000000);
    CHECK_INT(motion_next(&b->m), MOTION_NEVER);
    CHECK_SLOTS(b, 1, 2);
    motion_enqueue(&b->m, 3, 6000000);
    run_until(b, INT64_C(1) << 40);
    CHECK_SLOTS(b, 1, 2, 3);
    free(b);
}

static void a_retarget_ramps_from_the_speed_in_play(void)
{
    bench *b = new_motion(&SETUP);
    set(b, 0, steps(0));
    motion_once(&b->m, 0, 0);
    run_until(b, 4000000);
    CHECK_INT(b->m.state, MOTION_CRUISE);
    int64_t before = b->pulses;
    motion_retarget(&b->m, 200, 1500, 4000000);
    int64_t from = motion_next(&b->m), up = 0;
    for (int k = 0; k < 100; k++) up += 30000000 / (10000 + 100 * k); /* the manual's curve, acc 1 */
    run_until(b, from + 2 * up - 1);
    CHECK_INT(b->pulses - before, 100);
    CHECK_INT(b->m.state, MOTION_ACCEL);
    run_until(b, from + 2 * up);
    CHECK_INT(b->m.state, MOTION_CRUISE);
    CHECK_INT(b->m.period_us, 1500);
    free(b);
}

/* Between the stop and the first pulse of its ramp too. */
static void nothing_retargets_motion_that_stops(void)
{
    bench *b = new_motion(&SETUP);
    set(b, 0, steps(0));
    motion_once(&b->m, 0, 0);
    run_until(b, 4000000);
    motion_stop_gracefully(&b->m, 100, 4000000);
    motion_retarget(&b->m, 200, 1500, 4000000);
    motion_stop_gracefully(&b->m, 100, 4000000); /* and a second stop changes nothing */
    int64_t before = b->pulses;
    run_until(b, INT64_C(1) << 40);
    CHECK_INT(b->pulses - before, 90);
    CHECK_INT(b->m.state, MOTION_STANDBY);
    free(b);
}

static void a_single_pulse_needs_standby(void)
{
    bench *b = new_motion(&SETUP);
    set(b, 1, steps(1));
    CHECK_INT(motion_single(&b->m, 1, 0), 1);
    CHECK_INT(b->m.pulses, -1);
    b->m.entries[1].is_sync = 1;
    motion_enqueue(&b->m, 1, 0);
    CHECK_INT(motion_single(&b->m, 0, 0), 0); /* a command is held */
    motion_release_sync(&b->m, 50);
    run_until(b, 50);
    CHECK_INT(b->pulses, 1);
    CHECK_INT(motion_single(&b->m, 0, 51), 0);
    free(b);
}

static void an_external_clock_scales_each_period_without_drift(void)
{
    motion_setup s = SETUP;
    s.is_clock_internal = 0;
    bench *b = new_motion(&s);
    set(b, 1, (motion_entry){.steps = 3000, .rpm = 5, .cycle_us = 1001});
    motion_clock(&b->m, 3000000, 0);
    motion_enqueue(&b->m, 1, 0);
    run_until(b, INT64_C(1) << 40);
    CHECK_INT(b->pulses, 3000);
    CHECK_INT(b->ended_at[0], 2 * 1001 * 1000); /* a third of the time, not of each rounded period */
    free(b);
}

static void without_an_external_clock_a_command_hangs(void)
{
    motion_setup s = SETUP;
    s.is_clock_internal = 0;
    bench *b = new_motion(&s);
    set(b, 1, steps(5));
    motion_clock(&b->m, 0, 0);
    motion_enqueue(&b->m, 1, 0);
    run_until(b, 1000000);
    CHECK_INT(b->pulses, 0);
    CHECK_INT(b->m.op_sa, 1);
    motion_clock(&b->m, 1000000, 1000000);
    CHECK_INT(motion_next(&b->m), 1000000);
    run_until(b, 1000001);
    CHECK_INT(b->pulses, 1);
    motion_clock(&b->m, 0, 1000001);
    run_until(b, 2000000);
    motion_stop(&b->m, 2000000);
    CHECK_INT(b->m.op_sa, 0);
    CHECK_INT(b->pulses, 1);
    free(b);
}

/* Numbers that a terminal or a damaged memory may bring: time goes on, and no ramp takes the machine away. */
static void absurd_numbers_neither_hang_nor_overflow(void)
{
    uint64_t random = 11;
    static const uint32_t numbers[] = {0, 1, 2, 3, 7, 255, 65535, 4000000, 300000000, UINT32_MAX};
#define ANY_NUMBER numbers[random_below(&random, 10)]
    for (int round = 0; round < 300; round++) {
        motion_setup s = {.steps_per_rev = (int32_t)ANY_NUMBER, .slow_rpm = (int32_t)ANY_NUMBER,
                          .microstep_exponent = (int32_t)ANY_NUMBER, .pulse_us = (int32_t)ANY_NUMBER,
                          .interrupt_overhead_us = (int32_t)random_below(&random, 256),
                          .clock_correction_us = (int32_t)random_below(&random, 256),
                          .is_clock_internal = (int32_t)random_below(&random, 2), .is_cw_high = (int32_t)ANY_NUMBER,
                          .external_clock_Hz = ANY_NUMBER};
        bench *b = new_motion(&SETUP);
        motion_configure(&b->m, &s, 0);
        motion_clock(&b->m, (int64_t)ANY_NUMBER - 1, 0);
        for (int slot = 0; slot < MOTION_SLOTS; slot++)
            set(b, slot, (motion_entry){.steps = ANY_NUMBER, .rpm = ANY_NUMBER, .cycle_us = ANY_NUMBER,
                                        .acc_hundredths = (int32_t)random_below(&random, 99901), .wait_us = ANY_NUMBER % 1000,
                                        .dec_hundredths = (int32_t)random_below(&random, 3), .extra_pulses = 255,
                                        .is_linear = random_below(&random, 4) > 0, .is_pulses = random_below(&random, 2) == 0});
        motion_enqueue(&b->m, 1, 0);
        motion_enqueue(&b->m, 2, 0);
        for (int i = 0; i < 40 && motion_next(&b->m) < MOTION_NEVER; i++) {
            b->now = motion_next(&b->m);
            motion_run(&b->m);
            switch (random_below(&random, 12)) {
            case 0: motion_once(&b->m, (int)random_below(&random, MOTION_SLOTS), b->now); break;
            case 1: motion_retarget(&b->m, ANY_NUMBER, ANY_NUMBER, b->now); break;
            case 2: motion_stop_gracefully(&b->m, (int32_t)random_below(&random, 3), b->now); break;
            case 3: motion_next_command(&b->m, 1, b->now); break;
            case 4: motion_loop_bounds(&b->m, 1, 2, b->now); break;
            }
            CHECK(motion_next(&b->m) >= b->now);
            CHECK(b->m.fall_after >= 0);
        }
        free(b);
    }
}

/* Beyond the exact part of the list: the closed form goes on where the recurrence stops. */
static void a_long_ramp_down_is_the_recurrences_list_reversed(void)
{
    static ramp_list list;
    enum { LENGTH = RAMP_EXACT + 300000 };
    double *forward = malloc(LENGTH * sizeof *forward), c = 0.676 * 1e6 * sqrt(2 * (2 * 3.14159265358979323846 / 200) / 0.01);
    for (int64_t n = 0; n < LENGTH; c -= 2 * c / (double)(4 * ++n + 1)) forward[n] = c;
    ramp r;
    ramp_linear_from_stop(&r, 1, 200);
    ramp_reverse(&r, LENGTH, &list);
    int64_t wrong = 0;
    for (int64_t n = LENGTH - 1; n >= 0; n--) wrong += ramp_next_us(&r) != (int64_t)forward[n];
    CHECK_INT(wrong, 0);
    free(forward);
}

/* V^2 / (2 alpha acc): half of the manual's table. */
static void linear_steps_follow_the_texts_formula(void)
{
    CHECK_INT(ramp_linear_steps(100, 1047, 200), 166);
    CHECK_INT(ramp_linear_steps(50, 100, 200), 436);
    CHECK_INT(ramp_linear_steps(600, 100, 200), 62831);
    CHECK_INT(ramp_linear_steps(600, 0, 200), 0);
    CHECK_INT(ramp_linear_steps(600, 99900, 200), 0);
    CHECK_INT(ramp_linear_steps(UINT32_MAX, 1, 60000000), INT64_C(1) << 62);
}

void motion_tests(void)
{
    RUN(a_move_has_the_manuals_times);
    RUN(times_stay_exact_over_days);
    RUN(a_steps_pulses_share_its_period_exactly);
    RUN(totals_are_exact_whatever_the_ramps);
    RUN(a_loop_begins_with_both_ends_and_wraps);
    RUN(commands_entered_during_a_loop_run_after_it);
    RUN(what_x_interrupts_goes_on_with_its_next_entry);
    RUN(continuous_motion_cut_by_x_is_gone_but_not_what_it_interrupted);
    RUN(an_array_loops_and_ends_at_its_0);
    RUN(n_goes_on_with_the_loop_and_s_ends_it);
    RUN(a_retarget_ramps_from_the_speed_in_play);
    RUN(nothing_retargets_motion_that_stops);
    RUN(a_single_pulse_needs_standby);
    RUN(an_external_clock_scales_each_period_without_drift);
    RUN(without_an_external_clock_a_command_hangs);
    RUN(absurd_numbers_neither_hang_nor_overflow);
    RUN(a_long_ramp_down_is_the_recurrences_list_reversed);
    RUN(linear_steps_follow_the_texts_formula);
}
