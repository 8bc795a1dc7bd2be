/* Axes in lanes move as axes alone do, to the last bit: batch.c against hil_group_advance, and against axes that keep
   time with each other, step by step. */
#include "../batch.h"
#include "../core.h"
#include "../lanes.h"
#include "../law/servo.h"

#include "fixture.h"

#define AXES 29 /* three batches of a kind at most, and some left over */

static hil_axis_params random_params(uint64_t *seed, int kind)
{
    hil_axis_params p = MECHADUINO;
    p.inertia_kg_m2 *= 1 + (double)random_below(seed, 100) / 50;
    p.start_deg = (double)random_below(seed, 720000) / 1000 - 360;
    p.load_torque_Nm = (double)(random_below(seed, 3) - 1) * 0.02;
    p.is_full = kind;
    p.seed = next_random(seed);
    p.viscous_Nm_s_per_rad = kind ? 4e-5 : 0.004;
    p.torque_constant_Nm_per_A = kind ? 0.155 : 0.225;
    p.full = (hil_full_params){.phase_resistance_ohm = 1.1, .phase_inductance_H = 2.6e-3, .detent_torque_Nm = 0.015,
                               .full_step_error_pct = 5, .encoder_eccentricity_deg = 0.5,
                               .encoder_nonlinearity_deg = 0.2, .supply_V = 8 + (double)random_below(seed, 20)};
    if (random_below(seed, 2)) p.full.coulomb_torque_Nm = 0.008;
    if (random_below(seed, 2)) p.full.encoder_noise_counts = 0.7;
    if (random_below(seed, 10) == 0) p.load.pendulum_Nm = 0.02; /* no lane has room for it */
    return p;
}

static const hil_axis_params SAC = {
    .law = HIL_LAW_SAC, .phase_current_A = 1, .inertia_kg_m2 = 5.4e-6, .viscous_Nm_s_per_rad = 0.0015,
    .torque_constant_Nm_per_A = 0.155, .sense_resistor_ohm = 1, .rotor_teeth = 50,
};
static const motion_setup SETUP = {.steps_per_rev = 200, .slow_rpm = 10, .pulse_us = 30, .interrupt_overhead_us = 8,
                                   .is_clock_internal = 1, .ops = 36, .external_clock_Hz = 1000000};

static int is_servo(const hil_core *c, int axis) { return c->axes[axis].law == &mechaduino_law; }

static void open_servo(hil_core *c, int group, uint64_t *seed)
{
    hil_axis_params p = random_params(seed, (int)random_below(seed, 2));
    int axis = hil_axis_open(c, group, &p);
    identity_table(hil_axis_table(c, axis));
    for (int k = 0; k < HIL_TABLE_LEN; k++) hil_axis_table(c, axis)[k] += (float)random_below(seed, 100) / 1000;
    hil_axis_set(c, axis, HIL_FIELD_mode, 'x');
}

/* A SAC, wired to any axis of its group, itself too. */
static void open_sac(hil_core *c, int group, int first, uint64_t *seed)
{
    int axis = hil_axis_open(c, group, &SAC), to = first + (int)random_below(seed, axis - first + 1);
    motion_setup setup = SETUP;
    motion_entry move = {.rpm = 100 + (uint32_t)random_below(seed, 900), .acc_hundredths = 20000, .dec_hundredths = 200};
    move.cycle_us = 300000 / move.rpm;
    move.steps = (uint32_t)random_below(seed, 12);
    move.is_pulses = random_below(seed, 2) != 0;
    move.is_linear = random_below(seed, 2) != 0;
    setup.microstep_exponent = (int32_t)random_below(seed, 5);
    setup.is_clock_internal = random_below(seed, 2) != 0;
    hil_motion_setup(c, axis, &setup);
    hil_axis_set(c, axis, HIL_FIELD_clock_Hz, 900000 + (double)random_below(seed, 200000));
    hil_motion_write(c, axis, 1, &move);
    hil_axis_do(c, axis, HIL_MOTION_REPORT, (double)random_below(seed, 4), 0, 0);
    if (random_below(seed, 3) == 0) hil_wire(c, axis, random_below(seed, 2) ? HIL_OUT_CLK : HIL_OUT_OP_SA, to, 1);
}

/* In groups of one to `most`. Answers how many groups. */
static int open_axes(hil_core *c, uint64_t seed, int64_t most)
{
    int group = -1;
    for (int i = 0, first = 0; i < AXES; i++) {
        if (group < 0 || i - first == most || random_below(&seed, most) == 0) {
            group = open_group(c, 0);
            first = i;
        }
        if (most > 1 && random_below(&seed, 6) == 0) open_sac(c, group, first, &seed);
        else open_servo(c, group, &seed);
    }
    return group + 1;
}

/* Something new for one axis, of all that a firmware or a test can do. */
static void disturb(hil_core *c, int axis, uint64_t *seed)
{
    static const char MODES[] = {'x', 'x', 'x', 'v', 't', 'h'};
    static const double NUMBERS[] = {NAN, 1e30, -1e30, 3e9};
    double number = (double)random_below(seed, 2000) - 1000;
    const hil_edges edges = {.at_ns = random_below(seed, 1000000), .pin = 1, .steps = 1 + random_below(seed, 300),
                             .duration_ns = 1 + random_below(seed, 20000000)};
    if (!is_servo(c, axis)) {
        if (random_below(seed, 3) == 0) hil_axis_do(c, axis, HIL_MOTION_STOP, -1, 0, 0);
        for (int i = 0; i < AXES; i++) /* so that several end in one turn */
            if (!is_servo(c, i)) hil_axis_do(c, i, HIL_MOTION_ENQUEUE, 1, 0, 0);
        return;
    }
    switch (random_below(seed, 14)) {
    case 0: hil_axis_loop(c, axis, 0); break;
    case 1: hil_axis_set(c, axis, HIL_FIELD_mode, MODES[random_below(seed, 6)]); break;
    case 2: hil_axis_set(c, axis, HIL_FIELD_load_torque_Nm, number / (random_below(seed, 4) ? 5000 : 500)); break; /* up to the limit of speed */
    case 3: hil_axis_spi(c, axis, 0xFFFC); break;
    case 4: hil_axis_set(c, axis, HIL_FIELD_print_yw, (double)random_below(seed, 2)); break;
    case 5: hil_axis_output(c, axis, (float)number, 100); break;
    case 6: hil_axis_set(c, axis, HIL_FIELD_r, NUMBERS[random_below(seed, 4)]); break;
    case 7: hil_axis_set(c, axis, HIL_FIELD_PA, random_below(seed, 3) ? 1.8 : NUMBERS[random_below(seed, 4)]); break;
    case 8: hil_axis_set(c, axis, HIL_FIELD_uMAX, random_below(seed, 3) ? 115 : 2e9); break;
    case 9: hil_axis_power_up(c, axis); break;
    case 10: CHECK_INT(hil_axis_drive(c, axis, 1, &edges), 0); break;
    case 11: CHECK_INT(hil_axis_watch(c, axis, 0, random_below(seed, 3) * 333333, 1, 64), 0); break;
    default: hil_axis_set(c, axis, HIL_FIELD_r, number); break;
    }
    if (random_below(seed, 3)) hil_axis_loop(c, axis, 1);
    if (random_below(seed, 3)) hil_axis_set(c, axis, HIL_FIELD_mode, 'x');
}

static void check_same(hil_core *batched, hil_core *alone, int groups)
{
    hil_event one, other;
    for (int i = 0; i < AXES; i++) {
        hil_snapshot a, b;
        hil_axis_snapshot(batched, i, &a);
        hil_axis_snapshot(alone, i, &b);
        CHECK(!memcmp(&a, &b, sizeof a));
        while (hil_axis_take_samples(alone, i, 0, &a, 1)) {
            CHECK_INT(hil_axis_take_samples(batched, i, 0, &b, 1), 1);
            CHECK(!memcmp(&a, &b, sizeof a));
        }
        CHECK_INT(hil_axis_take_samples(batched, i, 0, &b, 1), 0);
    }
    for (int i = 0; i < groups; i++) {
        while (hil_group_take_event(alone, i, &one)) {
            CHECK_INT(hil_group_take_event(batched, i, &other), 1);
            CHECK(one.at_ns == other.at_ns && one.value == other.value && one.axis == other.axis && one.kind == other.kind);
        }
        CHECK_INT(hil_group_take_event(batched, i, &other), 0);
    }
}

/* One is moved in lanes, the other alone; if they are to keep time, all axes of a group in time's order. */
static void compare(uint64_t round, int64_t most, hil_lanes lanes, int keeps_time)
{
    hil_core *batched = new_core(AXES), *alone = new_core(AXES);
    if (hil_core_set_lanes(batched, lanes)) CHECK(lanes > HIL_LANES_ANY); /* this processor does not have them */
    int n = open_axes(batched, round, most), groups[AXES];
    CHECK_INT(open_axes(alone, round, most), n);
    uint64_t plan = round, a = 3, b = 3;
    int64_t now_ns = 0;
    for (int i = 0; i < n; i++) groups[i] = i;
    for (int i = 0; i < AXES && keeps_time; i++) core_join(alone, i);
    for (int i = 0; i < AXES; i++) { /* steps at times of their own */
        now_ns += random_below(&plan, 100000);
        for (int k = 0; k < n; k++) {
            hil_group_advance(batched, k, now_ns);
            hil_group_advance(alone, k, now_ns);
        }
        hil_axis_loop(batched, i, 1);
        hil_axis_loop(alone, i, 1);
    }
    for (int turn = 0; turn < 400; turn++) {
        now_ns += random_below(&plan, random_below(&plan, 20) ? 3000000 : 50000000);
        batch_advance(batched, groups, n, now_ns);
        for (int i = 0; i < n; i++) hil_group_advance(alone, i, now_ns);
        check_same(batched, alone, n);
        int axis = (int)random_below(&plan, AXES);
        if (turn % 3 && is_servo(alone, axis)) continue;
        disturb(batched, axis, &a);
        disturb(alone, axis, &b);
    }
    hil_core_free(batched);
    hil_core_free(alone);
}

static void lanes_are_as_axes_alone(void)
{
    for (uint64_t round = 1; round <= 4; round++) compare(round, 1, 1 + round % 3, 0);
}

static void lanes_of_a_group_are_as_axes_alone(void)
{
    for (uint64_t round = 1; round <= 3; round++) compare(round, 12, 1 + round % 3, 0);
}

static void lanes_of_a_group_are_as_axes_in_times_order(void)
{
    for (uint64_t round = 4; round <= 7; round++) compare(round, AXES, round % 4, 1);
}

static hil_core *new_row(int is_full)
{
    hil_core *c = new_core(MOST_SEATS + 3);
    for (int i = 0; i < MOST_SEATS + 3; i++) {
        uint64_t seed = (uint64_t)i + 1;
        hil_axis_params p = random_params(&seed, is_full);
        p.load.pendulum_Nm = 0;
        int axis = hil_axis_open(c, open_group(c, 0), &p);
        identity_table(hil_axis_table(c, axis));
        hil_axis_set(c, axis, HIL_FIELD_mode, 'x');
        hil_axis_set(c, axis, HIL_FIELD_r, 40 * i);
        hil_axis_loop(c, axis, 1);
    }
    return c;
}

/* All kinds of code for lanes that this processor can run, whichever it would choose; for a whole row and what is left. */
static void all_widths_are_the_same(void)
{
    int groups[MOST_SEATS + 3];
    for (int i = 0; i < MOST_SEATS + 3; i++) groups[i] = i;
    for (int is_full = 0; is_full < 2; is_full++)
        for (hil_lanes lanes = HIL_LANES_ANY; lanes < HIL_LANES_MOST; lanes++) {
            hil_core *alone = new_row(is_full), *c = new_row(is_full);
            int n = MOST_SEATS + 3, is_there = !hil_core_set_lanes(c, lanes);
            CHECK_INT(hil_core_set_lanes(alone, HIL_LANES_NONE), 0);
            for (int64_t now_ns = 0; now_ns < 300000000 && is_there; now_ns += 1234567) {
                hil_groups_advance(c, groups, n, now_ns);
                hil_groups_advance(alone, groups, n, now_ns);
                for (int i = 0; i < n; i++) {
                    hil_axis *a = &c->axes[i], *b = &alone->axes[i];
                    CHECK(!memcmp(&servo_of(a)->law, &servo_of(b)->law, sizeof servo_of(a)->law));
                    CHECK(!memcmp(&a->full.moving, &b->full.moving, sizeof a->full.moving));
                    CHECK(!memcmp(&a->plant.moving, &b->plant.moving, sizeof a->plant.moving));
                    CHECK_INT(a->law_next_ns, b->law_next_ns);
                }
            }
            hil_core_free(alone);
            hil_core_free(c);
        }
}

static void the_widest_is_chosen(void)
{
    hil_core *c = new_core(1);
    hil_lanes widest = hil_core_lanes(c);
    CHECK(widest >= HIL_LANES_ANY);
    for (hil_lanes lanes = widest + 1; lanes < HIL_LANES_MOST; lanes++) CHECK_INT(hil_core_set_lanes(c, lanes), -1);
    CHECK_INT(hil_core_set_lanes(c, HIL_LANES_MOST), -1);
    CHECK_INT(hil_core_lanes(c), widest);
    hil_core_free(c);
}

void batch_tests(void)
{
    RUN(lanes_are_as_axes_alone);
    RUN(lanes_of_a_group_are_as_axes_alone);
    RUN(lanes_of_a_group_are_as_axes_in_times_order);
    RUN(all_widths_are_the_same);
    RUN(the_widest_is_chosen);
}
