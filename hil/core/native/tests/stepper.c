/* Stepper axes: pulses to pins, wires, driver and motor. */
#include "fixture.h"

/* device_profiles/sac/profile.yaml */
static const hil_axis_params SAC = {
    .law = HIL_LAW_SAC, .phase_current_A = 1, .inertia_kg_m2 = 5.4e-6, .viscous_Nm_s_per_rad = 0.0015,
    .torque_constant_Nm_per_A = 0.155, .sense_resistor_ohm = 1, .rotor_teeth = 50,
};
static const motion_setup SETUP = {.steps_per_rev = 200, .slow_rpm = 10, .pulse_us = 30, .interrupt_overhead_us = 8,
                                   .is_clock_internal = 1, .ops = 36, .external_clock_Hz = 1000000};
static const motion_entry MOVE = {.steps = 400, .rpm = 300, .cycle_us = 1000, .acc_hundredths = 200, .dec_hundredths = 200};

static hil_core *new_sac(const motion_entry *e)
{
    hil_core *c = new_core(2);
    hil_axis_open(c, open_group(c, 0), &SAC);
    hil_motion_setup(c, 0, &SETUP);
    hil_motion_write(c, 0, 1, e);
    return c;
}

static void start(hil_core *c) { hil_axis_do(c, 0, HIL_MOTION_ENQUEUE, 1, 0, 0); }

static int64_t get(hil_core *c, int axis, hil_field field) { return (int64_t)hil_axis_get(c, axis, field); }

static void the_rotor_follows(void)
{
    hil_core *c = new_sac(&MOVE);
    start(c);
    hil_group_advance(c, 0, INT64_C(5000000000));
    CHECK_INT(get(c, 0, HIL_FIELD_pulses), 400);
    CHECK_NEAR(hil_axis_get(c, 0, HIL_FIELD_position_deg), 720, 0.01);
    CHECK_INT(get(c, 0, HIL_FIELD_lost_steps), 0);
    CHECK_INT(get(c, 0, HIL_FIELD_motion_state), MOTION_STANDBY);
    hil_core_free(c);
}

/* A zero is of what is told: the shaft and its board know nothing of it. */
static void a_zero_moves_nothing(void)
{
    hil_core *c = new_sac(&MOVE), *other = new_sac(&MOVE);
    hil_snapshot a, b;
    for (int i = 0; i < 2; i++) {
        start(i ? other : c);
        hil_group_advance(i ? other : c, 0, INT64_C(400000007));
    }
    double here_deg = hil_axis_get(c, 0, HIL_FIELD_position_deg);
    CHECK(here_deg > 10);
    CHECK_INT(hil_axis_set(c, 0, HIL_FIELD_position_deg, 0), 0);
    CHECK(hil_axis_get(c, 0, HIL_FIELD_position_deg) == 0);
    hil_group_advance(c, 0, INT64_C(5000000000));
    hil_group_advance(other, 0, INT64_C(5000000000));
    hil_axis_snapshot(c, 0, &a);
    hil_axis_snapshot(other, 0, &b);
    CHECK_NEAR(a.position_deg, b.position_deg - here_deg, 1e-9);
    CHECK_NEAR(a.commanded_deg, b.commanded_deg - here_deg, 1e-9);
    a.position_deg = b.position_deg;
    a.commanded_deg = b.commanded_deg;
    CHECK(!memcmp(&a, &b, sizeof a));
    CHECK_INT(hil_axis_set(c, 0, HIL_FIELD_position_deg, 90), 0);
    CHECK_NEAR(hil_axis_get(c, 0, HIL_FIELD_position_deg), 90, 1e-9);
    hil_axis_power_up(c, 0);
    CHECK_NEAR(hil_axis_get(c, 0, HIL_FIELD_position_deg), 90, 1e-9);
    hil_core_free(c);
    hil_core_free(other);
}

static void a_ramp_that_is_too_steep_loses_whole_teeth(void)
{
    motion_entry steep = MOVE;
    steep.acc_hundredths = 99900;
    steep.rpm = 1200;
    steep.cycle_us = 250;
    hil_core *c = new_sac(&steep);
    start(c);
    hil_group_advance(c, 0, INT64_C(5000000000));
    CHECK_INT(get(c, 0, HIL_FIELD_pulses), 400);
    int64_t lost = get(c, 0, HIL_FIELD_lost_steps);
    CHECK(lost >= 100);
    CHECK_INT(lost % 4, 0);
    CHECK_NEAR(hil_axis_get(c, 0, HIL_FIELD_lag_steps), (double)lost, 0.01);
    hil_core_free(c);
}

/* Axes that stand still are published in short: what is read there is what the axis is, whatever was done to it. */
static void what_is_published_is_what_it_is(void)
{
    static const int64_t at_ns[] = {0, 1000000000}, raw[] = {0, 9000};
    hil_core *c = new_sac(&MOVE);
    open_axis(c, 0);
    uint64_t state = 20261121;
    for (int round = 0; round < 300; round++) {
        int axis = (int)random_below(&state, 2);
        switch (random_below(&state, 12)) {
        case 0: hil_axis_set(c, axis, HIL_FIELD_load_torque_Nm, (double)random_below(&state, 3) * 0.01); break;
        case 1: hil_axis_set(c, 1, HIL_FIELD_r, (double)random_below(&state, 360)); break;
        case 2: hil_axis_pin(c, axis, axis ? 0 : HIL_IN_SYNC, (int)random_below(&state, 2)); break;
        case 3: hil_axis_spi(c, 1, random_below(&state, 2) ? 0x4001 : 0xC000); break;
        case 4: hil_axis_script_encoder(c, 1, (int)random_below(&state, 3), at_ns, raw, 1); break;
        case 5: hil_axis_fault(c, 1, HIL_FAULT_NOISE, (double)random_below(&state, 2) * 40); break;
        case 6: hil_axis_output(c, 1, (float)random_below(&state, 360), 50); break;
        case 7: start(c); break;
        case 8: hil_axis_do(c, 0, HIL_MOTION_PULSE, random_below(&state, 2), 0, 0); break;
        case 9: hil_axis_power_up(c, axis); break;
        case 10: hil_axis_fault(c, axis, HIL_FAULT_SHIFT, 0.25); break;
        case 11: hil_axis_record_edges(c, 0, (int)random_below(&state, 2)); break;
        }
        for (int again = 0; again < 3; again++) {
            hil_group_advance(c, 0, hil_group_now(c, 0) + random_below(&state, 50000000));
            hil_event e;
            while (hil_group_take_event(c, 0, &e)) {}
            hil_group_release(c, 0);
            hil_group_acquire(c, 0);
            for (int i = 0; i < 2; i++) {
                hil_snapshot published, now;
                hil_axis_published(c, i, &published);
                hil_axis_snapshot(c, i, &now);
                CHECK_NEAR(published.velocity_rpm, now.velocity_rpm, 1e-9); /* between two nodes at rest: rounding */
                published.velocity_rpm = now.velocity_rpm;
                size_t at = 0;
                while (at < sizeof now && ((char *)&published)[at] == ((char *)&now)[at]) at++;
                CHECK_INT(at, sizeof now); /* else: where they differ */
            }
        }
    }
    hil_core_free(c);
}

/* Whoever looks, and however time is cut: the same bits. */
static void looking_changes_nothing(void)
{
    hil_snapshot whole, cut;
    hil_core *c = new_sac(&MOVE);
    start(c);
    hil_group_advance(c, 0, 700000123);
    hil_axis_snapshot(c, 0, &whole);
    hil_core_free(c);
    c = new_sac(&MOVE);
    start(c);
    uint64_t random = 5;
    hil_axis_watch(c, 0, 0, 777777, 1, 4);
    for (int64_t at_ns = 0; at_ns < 700000123;) {
        at_ns += 1 + random_below(&random, 300000);
        hil_group_advance(c, 0, at_ns < 700000123 ? at_ns : 700000123);
        hil_axis_get(c, 0, HIL_FIELD_position_deg);
    }
    hil_axis_snapshot(c, 0, &cut);
    CHECK(!memcmp(&whole, &cut, sizeof whole));
    hil_core_free(c);
}

/* Each axis of a group against a twin that has a group of its own and is watched, so that it never idles: what rests
   in company is left behind, and may not show it. */
static void company_changes_nothing(void)
{
    enum { AXES = 6, ACTIONS = 400 };
    hil_core *c = new_core(2 * AXES);
    hil_axis_params full = SAC;
    full.is_full = 1;
    full.full = (hil_full_params){.phase_resistance_ohm = 2, .phase_inductance_H = 0.003, .supply_V = 24,
                                  .detent_torque_Nm = 0.005, .coulomb_torque_Nm = 0.003, .encoder_noise_counts = 0.5};
    int group = open_group(c, 0), resting = 0;
    for (int i = 0; i < AXES; i++) hil_axis_open(c, group, i % 3 ? &SAC : &full);
    for (int i = 0; i < AXES; i++) hil_axis_open(c, open_group(c, 0), i % 3 ? &SAC : &full);
    for (int axis = 0; axis < 2 * AXES; axis++) {
        hil_motion_setup(c, axis, &SETUP);
        hil_motion_write(c, axis, 1, &MOVE);
        if (axis >= AXES) hil_axis_watch(c, axis, 0, 1000000, 1, 1);
    }
    uint64_t random = 9;
    hil_snapshot shared, alone;
    for (int64_t k = 0, now_ns = 0; k < ACTIONS; k++) {
        now_ns += random_below(&random, k % 9 ? 3000000 : 3000000000);
        CHECK_INT(advance_to(c, group, now_ns), now_ns);
        int axis = (int)random_below(&random, AXES), what = (int)random_below(&random, 8), level = (int)random_below(&random, 2);
        advance_to(c, c->axes[AXES + axis].group, now_ns);
        resting += !c->axes[axis].is_active;
        CHECK(c->axes[AXES + axis].is_active);
        for (int i = axis; i < 2 * AXES; i += AXES) {
            switch (what) {
            case 0: hil_axis_do(c, i, HIL_MOTION_ENQUEUE, 1, 0, 0); break;
            case 1: hil_axis_do(c, i, HIL_MOTION_PULSE, level, 0, 0); break;
            case 2: hil_axis_do(c, i, HIL_MOTION_STOP, level ? -1 : 400, 0, 0); break;
            case 3: hil_axis_set(c, i, HIL_FIELD_load_torque_Nm, level * 0.1); break;
            case 4: hil_axis_pin(c, i, HIL_IN_SYNC + (int)(k % 5), level); break;
            case 5: hil_axis_power_up(c, i); break;
            case 6: hil_axis_get(c, i, HIL_FIELD_position_deg); break;
            default: hil_motion_setup(c, i, &SETUP);
            }
        }
        hil_axis_snapshot(c, axis, &shared);
        hil_axis_snapshot(c, AXES + axis, &alone);
        CHECK_INT(shared.at_ns, now_ns);
        CHECK(!memcmp(&shared, &alone, sizeof shared));
    }
    CHECK(resting > ACTIONS / 8);
    hil_core_free(c);
}

/* High for K, or for the period less 1 us. */
static void edges_have_their_widths(void)
{
    static const uint32_t cycles[] = {1000, 20, 2};
    for (int i = 0; i < 3; i++) {
        motion_entry e = {.steps = 3, .rpm = 5, .cycle_us = cycles[i]};
        hil_core *c = new_sac(&e);
        hil_axis_record_edges(c, 0, 1 << HIL_OUT_CLK);
        start(c);
        hil_group_advance(c, 0, 10000000);
        hil_edge edges[10];
        CHECK_INT(hil_axis_take_edges(c, 0, edges, 10), 6);
        int64_t width_ns = cycles[i] == 1000 ? 30000 : (cycles[i] - 1) * 1000;
        for (int k = 0; k < 6; k++) {
            CHECK_INT(edges[k].level, k % 2 == 0);
            CHECK_INT(edges[k].at_ns, k / 2 * (int64_t)cycles[i] * 1000 + k % 2 * width_ns);
        }
        hil_core_free(c);
    }
}

/* Whether anybody is at the pin or begins to be in the middle; and a board does not rest with clk up. */
static void clk_reads_as_it_is_whoever_looks(void)
{
    for (int looks = 0; looks < 3; looks++) {
        hil_core *c = new_sac(&MOVE);
        motion_setup setup = SETUP;
        setup.pulse_us = 700000; /* the rotor has long come to rest */
        hil_motion_setup(c, 0, &setup);
        if (looks == 1) hil_axis_record_edges(c, 0, 1 << HIL_OUT_CLK);
        hil_axis_do(c, 0, HIL_MOTION_PULSE, 0, 0, 0);
        CHECK_INT(get(c, 0, HIL_FIELD_pin_clk), 1);
        hil_group_advance(c, 0, 500000000);
        if (looks) hil_axis_record_edges(c, 0, (looks - 1) << HIL_OUT_CLK);
        hil_group_advance(c, 0, 699999999);
        CHECK_INT(get(c, 0, HIL_FIELD_pin_clk), 1);
        hil_group_advance(c, 0, 700000000);
        CHECK_INT(get(c, 0, HIL_FIELD_pin_clk), 0);
        hil_snapshot published;
        hil_group_release(c, 0);
        hil_axis_published(c, 0, &published);
        CHECK_INT(published.pin_clk, 0);
        hil_edge edge;
        CHECK_INT(hil_axis_take_edges(c, 0, &edge, 1), looks == 2);
        if (looks == 2) CHECK_INT(edge.at_ns, 700000000);
        hil_core_free(c);
    }
}

static void a_wire_moves_a_servos_set_point_with_each_rise(void)
{
    motion_entry e = {.steps = 5, .rpm = 5, .cycle_us = 1000};
    hil_core *c = new_sac(&e);
    hil_axis_open(c, 0, &MECHADUINO);
    CHECK_INT(hil_wire(c, 0, HIL_OUT_CLK, 1, 1), 0);
    CHECK_INT(hil_wire(c, 1, HIL_OUT_CLK, 0, 0), -1); /* a servo has no outputs */
    start(c);
    for (int i = 0; i < 5; i++) {
        hil_group_advance(c, 0, i * INT64_C(1000000) - (i > 0));
        if (i > 0) CHECK_NEAR(fabs(hil_axis_get(c, 1, HIL_FIELD_r)), i * 1.8 / 32, 1e-6);
        hil_group_advance(c, 0, i * INT64_C(1000000) + (i == 0));
        CHECK_NEAR(fabs(hil_axis_get(c, 1, HIL_FIELD_r)), (i + 1) * 1.8 / 32, 1e-6);
    }
    hil_core_free(c);
}

/* OP SB to its own Estop: a command ends in the nanosecond in which it begins. */
static void a_board_may_be_wired_to_itself(void)
{
    hil_core *c = new_sac(&MOVE);
    CHECK_INT(hil_wire(c, 0, HIL_OUT_OP_SB, 0, HIL_IN_ESTOP), 0);
    hil_axis_record_edges(c, 0, 1 << HIL_OUT_OP_SB | 1 << HIL_OUT_CLK);
    start(c);
    hil_group_advance(c, 0, 10000000);
    hil_edge edges[4];
    CHECK_INT(hil_axis_take_edges(c, 0, edges, 4), 2);
    CHECK_INT(edges[0].level, 0);
    CHECK_INT(edges[1].level, 1);
    CHECK_INT(edges[1].at_ns, 0);
    CHECK_INT(get(c, 0, HIL_FIELD_motion_state), MOTION_STANDBY);
    CHECK_INT(get(c, 0, HIL_FIELD_pulses), 0);
    hil_core_free(c);
}

/* clk turns its own board's encoder, and, in a circle, that of the board behind it: pulses that make pulses. */
static void a_pulse_makes_no_pulses_without_end(void)
{
    for (int boards = 1; boards <= 2; boards++) {
        hil_core *c = new_core(2);
        int group = open_group(c, 0);
        for (int i = 0; i < boards; i++) {
            hil_axis_open(c, group, &SAC);
            hil_motion_setup(c, i, &SETUP);
        }
        for (int i = 0; i < boards; i++) {
            CHECK_INT(hil_wire(c, i, HIL_OUT_CLK, (i + 1) % boards, HIL_IN_ENB), 0);
            CHECK_INT(hil_wire(c, i, HIL_OUT_CLK, (i + 1) % boards, HIL_IN_ENA), 0);
        }
        uint64_t random = 7;
        for (int k = 0; k < 2000; k++) {
            int axis = (int)random_below(&random, boards), what = (int)random_below(&random, 3);
            if (what) hil_axis_do(c, axis, HIL_MOTION_PULSE, what - 1, 0, 0);
            else hil_axis_power_up(c, axis); /* wherever its encoder is in the cycle */
            hil_motion_setup(c, axis, &SETUP);
            advance_to(c, group, hil_group_now(c, group) + random_below(&random, 100000));
        }
        CHECK_INT(hil_group_failed(c, group), 0);
        hil_core_free(c);
    }
}

static void commands_are_told_when_they_are_asked_for(void)
{
    motion_entry e = {.steps = 2, .rpm = 5, .cycle_us = 1000};
    hil_core *c = new_sac(&e);
    hil_event event;
    start(c);
    hil_group_advance(c, 0, 10000000);
    CHECK_INT(hil_group_take_event(c, 0, &event), 0);
    hil_axis_do(c, 0, HIL_MOTION_REPORT, 1, 0, 0);
    start(c);
    CHECK_INT(hil_group_advance(c, 0, 20000000), 10000000); /* time waits for who hears of it */
    CHECK_INT(hil_group_take_event(c, 0, &event), 1);
    CHECK_INT(event.kind, HIL_EVENT_COMMAND_BEGUN);
    CHECK_INT(event.at_ns, 10000000);
    CHECK_NEAR(event.value, 1, 0);
    CHECK_INT(hil_group_advance(c, 0, 20000000), 12000000);
    CHECK_INT(hil_group_advance(c, 0, 20000000), 12000000);
    CHECK_INT(hil_group_take_event(c, 0, &event), 1);
    CHECK_INT(event.kind, HIL_EVENT_COMMAND_ENDED);
    CHECK_INT(event.at_ns, 12000000);
    CHECK_INT(hil_group_take_event(c, 0, &event), 0);
    CHECK_INT(hil_group_advance(c, 0, 20000000), 20000000);
    hil_core_free(c);
}

static void estop_and_sync_act_on_their_falling_edges(void)
{
    motion_entry e = {.steps = 1000, .rpm = 5, .cycle_us = 1000, .is_sync = 1};
    hil_core *c = new_sac(&e);
    start(c);
    hil_group_advance(c, 0, 5000000);
    CHECK_INT(get(c, 0, HIL_FIELD_is_held), 1);
    hil_axis_pin(c, 0, HIL_IN_SYNC, 0);
    hil_group_advance(c, 0, 9999999);
    CHECK_INT(get(c, 0, HIL_FIELD_pulses), 5);
    hil_axis_pin(c, 0, HIL_IN_ESTOP, 0);
    CHECK_INT(get(c, 0, HIL_FIELD_pin_op_sa), 0);
    CHECK_INT(get(c, 0, HIL_FIELD_pin_op_sb), 1);
    hil_group_advance(c, 0, 90000000);
    CHECK_INT(get(c, 0, HIL_FIELD_pulses), 5);
    hil_core_free(c);
}

/* A before B is clockwise; one pulse a whole cycle. */
static void an_idle_motor_follows_the_encoder(void)
{
    hil_core *c = new_sac(&MOVE);
    static const int cycle[4][2] = {{HIL_IN_ENA, 1}, {HIL_IN_ENB, 1}, {HIL_IN_ENA, 0}, {HIL_IN_ENB, 0}};
    for (int i = 0; i < 12; i++) {
        hil_group_advance(c, 0, (i + 1) * INT64_C(1000000));
        hil_axis_pin(c, 0, cycle[i % 4][0], cycle[i % 4][1]);
        CHECK_INT(get(c, 0, HIL_FIELD_pulses), (i + 1) / 4);
    }
    for (int i = 11; i >= 0; i--) hil_axis_pin(c, 0, cycle[i % 4][0], !cycle[i % 4][1]);
    CHECK_INT(get(c, 0, HIL_FIELD_pulses), 0);
    hil_core_free(c);
}

/* The driver makes of a pulse what its pins say, not what the engine believes. */
static void the_drivers_step_follows_the_mode_pins(void)
{
    static const struct { int driver, pins; double deg; } rows[] = {
        {0, 0, 1.8}, {0, 1, 0.9}, {0, 3, 0.225}, {0, 7, 0.1125}, {1, 3, 0.225}, {1, 5, 0.05625}, {1, 7, 0.05625}};
    for (int i = 0; i < 7; i++) {
        hil_axis_params params = SAC;
        params.driver = rows[i].driver;
        hil_core *c = new_core(1);
        hil_axis_open(c, open_group(c, 0), &params);
        motion_setup s = SETUP;
        s.mode_pins = rows[i].pins;
        hil_motion_setup(c, 0, &s);
        hil_axis_do(c, 0, HIL_MOTION_PULSE, 1, 0, 0);
        hil_axis_do(c, 0, HIL_MOTION_PULSE, 1, 0, 0);
        CHECK_NEAR(hil_axis_get(c, 0, HIL_FIELD_commanded_deg), -2 * rows[i].deg, 1e-9);
        hil_core_free(c);
    }
}

/* A SAC has a small ring; with a servo in its group it grows, and the events that wait stay in order. */
static void a_ring_grows_with_its_group(void)
{
    hil_core *c = new_sac(&MOVE);
    hil_event e;
    int level = 0;
    for (int i = 0; i < 40; i++, level = !level) {
        hil_axis_pin(c, 0, HIL_IN_ESTOP, level);
        CHECK_INT(hil_group_take_event(c, 0, &e), 1);
    }
    for (int i = 0; i < 50; i++, level = !level) hil_axis_pin(c, 0, HIL_IN_ESTOP, level);
    CHECK_INT(c->groups[0].events.len, RING_LEAST);
    CHECK_INT(open_axis(c, 0), 1);
    CHECK_INT(c->groups[0].events.len, RING_MOST);
    for (int i = 0; i < 50; i++) {
        CHECK_INT(hil_group_take_event(c, 0, &e), 1);
        CHECK_INT(e.kind, HIL_EVENT_ESTOP);
        CHECK_INT(e.value, i & 1);
    }
    CHECK_INT(hil_group_take_event(c, 0, &e), 0);
    CHECK_INT(hil_group_failed(c, 0), 0);
    hil_core_free(c);
}

/* What only a servo has: refused, or nothing. */
static void a_stepper_is_no_servo(void)
{
    hil_core *c = new_sac(&MOVE);
    hil_path_piece piece = {.duration_ns = 1000000, .per_s = 1};
    hil_snapshot before, after;
    hil_axis_snapshot(c, 0, &before);
    CHECK(!hil_axis_table(c, 0));
    CHECK_INT(hil_axis_follow(c, 0, 0, 1, &piece), -3);
    CHECK_INT(hil_axis_set(c, 0, HIL_FIELD_r, 1), -1);
    hil_axis_output(c, 0, 10, 100);
    hil_axis_vref(c, 0, 10, 10);
    hil_axis_loop(c, 0, 1);
    hil_axis_snapshot(c, 0, &after);
    CHECK(!memcmp(&before, &after, sizeof before));
    hil_core_free(c);
}

void stepper_tests(void)
{
    RUN(a_ring_grows_with_its_group);
    RUN(a_stepper_is_no_servo);
    RUN(the_rotor_follows);
    RUN(a_zero_moves_nothing);
    RUN(a_ramp_that_is_too_steep_loses_whole_teeth);
    RUN(what_is_published_is_what_it_is);
    RUN(looking_changes_nothing);
    RUN(company_changes_nothing);
    RUN(edges_have_their_widths);
    RUN(clk_reads_as_it_is_whoever_looks);
    RUN(a_wire_moves_a_servos_set_point_with_each_rise);
    RUN(a_board_may_be_wired_to_itself);
    RUN(a_pulse_makes_no_pulses_without_end);
    RUN(commands_are_told_when_they_are_asked_for);
    RUN(estop_and_sync_act_on_their_falling_edges);
    RUN(an_idle_motor_follows_the_encoder);
    RUN(the_drivers_step_follows_the_mode_pins);
}
