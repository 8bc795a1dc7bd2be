/* What is wrong with an axis acts, and leaves nothing behind. */
#include "fixture.h"

static const hil_axis_params FULL = {
    .inertia_kg_m2 = 5.4e-6, .viscous_Nm_s_per_rad = 4e-3, .torque_constant_Nm_per_A = 0.225,
    .sense_resistor_ohm = 0.15, .rotor_teeth = 50, .is_full = 1, .seed = 7,
    .full = {.phase_resistance_ohm = 1.65, .phase_inductance_H = 3.2e-3, .supply_V = 12},
};

static hil_snapshot look(hil_core *c)
{
    hil_snapshot s;
    hil_axis_snapshot(c, 0, &s);
    return s;
}

static hil_core *energised(const hil_axis_params *params)
{
    hil_core *c = new_core(1);
    int group = hil_group_open(c, 0);
    hil_group_set_horizon(c, group, HIL_FOREVER);
    CHECK_INT(hil_axis_open(c, group, params), 0);
    identity_table(hil_axis_table(c, 0));
    hil_axis_output(c, 0, 13, 100);
    hil_group_advance(c, 0, 200000000);
    return c;
}

static void each_plant(void (*test)(hil_core *))
{
    for (int i = 0; i < 2; i++) {
        hil_core *c = energised(i ? &FULL : &MECHADUINO);
        test(c);
        hil_core_free(c);
    }
}

static void jam(hil_core *c)
{
    double before = look(c).position_deg;
    CHECK_INT(hil_axis_fault(c, 0, HIL_FAULT_JAM, 1), 0);
    hil_axis_set(c, 0, HIL_FIELD_load_torque_Nm, 0.4);
    hil_group_advance(c, 0, 400000000);
    CHECK_NEAR(look(c).position_deg, before, 0);
    CHECK_NEAR(look(c).velocity_rpm, 0, 0);
    CHECK_INT(hil_axis_fault(c, 0, HIL_FAULT_JAM, 0), 0);
    hil_group_advance(c, 0, 600000000);
    CHECK(fabs(look(c).position_deg - before) > 0.1);
}

static void open_phases(hil_core *c)
{
    hil_snapshot before = look(c);
    hil_axis_fault(c, 0, HIL_FAULT_OPEN_A, 1);
    hil_group_advance(c, 0, 400000000);
    CHECK_NEAR(look(c).current_a_A, 0, 1e-6);
    CHECK_NEAR(look(c).current_b_A, before.current_b_A, 1e-3);
    hil_axis_fault(c, 0, HIL_FAULT_OPEN_A, 0);
    hil_group_advance(c, 0, 800000000);
    CHECK_NEAR(look(c).current_a_A, before.current_a_A, 1e-3);
}

static void encoder_errors(hil_core *c)
{
    int raw = look(c).raw, seen[32], differ = 0;
    hil_axis_fault(c, 0, HIL_FAULT_SLIP, 100);
    CHECK_INT(look(c).raw, (raw + 100) & 16383);
    hil_axis_fault(c, 0, HIL_FAULT_SLIP, 0);
    CHECK_INT(look(c).raw, raw);
    hil_axis_fault(c, 0, HIL_FAULT_NOISE_SEED, 3);
    hil_axis_fault(c, 0, HIL_FAULT_NOISE, 5);
    for (int i = 0; i < 32; i++) {
        hil_group_advance(c, 0, 200000000 + (i + 1) * 1000000);
        seen[i] = look(c).raw;
        CHECK(abs(seen[i] - raw) < 30);
        differ += i && seen[i] != seen[i - 1];
    }
    CHECK(differ > 16);
    hil_axis_fault(c, 0, HIL_FAULT_NOISE, 0);
    CHECK_INT(look(c).raw, raw);
}

/* What was set and what a fault adds: neither knows the other's value. */
static void loads(hil_core *c)
{
    hil_axis_fault(c, 0, HIL_FAULT_LOAD, 0.05);
    hil_axis_set(c, 0, HIL_FIELD_load_torque_Nm, 0.02);
    CHECK_NEAR(look(c).load_torque_Nm, 0.07, 1e-15);
    hil_axis_set(c, 0, HIL_FIELD_load_torque_Nm, 0);
    CHECK_NEAR(look(c).load_torque_Nm, 0.05, 0);
    hil_axis_fault(c, 0, HIL_FAULT_LOAD, 0);
    CHECK_NEAR(look(c).load_torque_Nm, 0, 0);
}

/* Over an open line nothing is seen of a count that stands still, and of neither when both are over. */
static void blind_encoders(hil_core *c)
{
    int raw = look(c).raw;
    hil_axis_fault(c, 0, HIL_FAULT_OPEN_LINE, 1);
    hil_axis_fault(c, 0, HIL_FAULT_FREEZE, 1);
    CHECK_INT(look(c).raw, 16383);
    CHECK_INT(hil_axis_get(c, 0, HIL_FIELD_raw), 16383);
    hil_axis_set(c, 0, HIL_FIELD_load_torque_Nm, 0.2);
    hil_group_advance(c, 0, 400000000);
    CHECK_INT(look(c).raw, 16383);
    hil_axis_fault(c, 0, HIL_FAULT_OPEN_LINE, 0);
    CHECK_INT(look(c).raw, raw);
    hil_axis_fault(c, 0, HIL_FAULT_FREEZE, 1);
    CHECK_INT(look(c).raw, raw);
    hil_axis_fault(c, 0, HIL_FAULT_FREEZE, 0);
    CHECK(abs(look(c).raw - raw) > 4);
}

static void jam_against_a_hand(hil_core *c)
{
    double before = look(c).position_deg;
    hil_axis_fault(c, 0, HIL_FAULT_JAM, 1);
    hil_axis_fault(c, 0, HIL_FAULT_SHIFT, 0.25);
    CHECK_NEAR(look(c).position_deg, before, 0);
}

static void loads_add_up(void) { each_plant(loads); }
static void an_encoder_is_blind(void) { each_plant(blind_encoders); }
static void a_hand_does_not_turn_what_is_jammed(void) { each_plant(jam_against_a_hand); }
static void a_jam_holds_the_shaft(void) { each_plant(jam); }
static void an_open_phase_has_no_current(void) { each_plant(open_phases); }
static void an_encoder_slips_and_scatters(void) { each_plant(encoder_errors); }

static void a_jam_is_the_same_however_time_is_cut(void)
{
    hil_snapshot seen[2];
    for (int pieces = 0; pieces < 2; pieces++) {
        hil_core *c = energised(&FULL);
        hil_axis_fault(c, 0, HIL_FAULT_JAM, 1);
        hil_axis_set(c, 0, HIL_FIELD_load_torque_Nm, 0.4);
        if (pieces)
            for (int64_t t = 200000000; t < 400000000; t += 777777) hil_group_advance(c, 0, t);
        hil_group_advance(c, 0, 400000000);
        seen[pieces] = look(c);
        hil_core_free(c);
    }
    CHECK(!memcmp(&seen[0], &seen[1], sizeof seen[0]));
}

static void what_an_axis_cannot_have_is_refused(void)
{
    hil_core *c = energised(&MECHADUINO);
    CHECK_INT(hil_axis_fault(c, 0, HIL_FAULT_SUPPLY, 5), -1);
    CHECK_INT(hil_axis_fault(c, 0, 99, 5), -1);
    CHECK_INT(hil_axis_fault(c, 0, HIL_FAULT_SHIFT, NAN), -1);
    CHECK_NEAR(hil_axis_supply_V(c, 0), 0, 0);
    hil_core_free(c);
}

void fault_tests(void)
{
    RUN(a_jam_holds_the_shaft);
    RUN(a_jam_is_the_same_however_time_is_cut);
    RUN(a_hand_does_not_turn_what_is_jammed);
    RUN(loads_add_up);
    RUN(an_encoder_is_blind);
    RUN(an_open_phase_has_no_current);
    RUN(an_encoder_slips_and_scatters);
    RUN(what_an_axis_cannot_have_is_refused);
}
