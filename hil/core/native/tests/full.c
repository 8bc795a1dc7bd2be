/* The full plant: plant/full.c. */
#include "fixture.h"

static const double TAU = 6.28318530717958647692;

/* device_profiles/mechaduino/profile.yaml, `plant: full` */
static const hil_axis_params FULL = {
    .inertia_kg_m2 = 5.4e-6, .viscous_Nm_s_per_rad = 2e-5, .torque_constant_Nm_per_A = 0.1564,
    .sense_resistor_ohm = 0.15, .rotor_teeth = 50, .is_full = 1, .seed = 7,
    .full = {.phase_resistance_ohm = 1.1, .phase_inductance_H = 2.6e-3, .supply_V = 24, .detent_torque_Nm = 0.015,
             .coulomb_torque_Nm = 0.004, .full_step_error_pct = 5, .encoder_eccentricity_deg = 0.5,
             .encoder_nonlinearity_deg = 0.2, .encoder_noise_counts = 0.7},
};

static full motor(const hil_axis_params *params)
{
    full p;
    CHECK_INT(full_init(&p, params, 2.2, 0), 0);
    return p;
}

/* The members that a motion changes; the structs have padding. */
static int same(const full *a, const full *b)
{
    return !memcmp(&a->moving.state, &b->moving.state, sizeof a->moving.state) && !memcmp(&a->moving.energy, &b->moving.energy, sizeof a->moving.energy) &&
           a->moving.a_V == b->moving.a_V && a->moving.b_V == b->moving.b_V;
}

static void current_rises_with_L_over_R(void)
{
    hil_axis_params held = FULL;
    held.load.inertia_kg_m2 = 1000;
    held.full.supply_V = 2; /* 1.82 A at most: less than the command */
    full p = motor(&held);
    full_set_currents(&p, 2.2, -2.2);
    double final_A = 2 / 1.1;
    int64_t tau_ns = 2363636;
    for (int i = 1; i <= 5; i++) {
        full now = full_at(&p, i * tau_ns);
        CHECK_NEAR(now.moving.state.a_A / final_A, 1 - exp(-i), 1e-4);
        CHECK_NEAR(now.moving.state.b_A / final_A, exp(-i) - 1, 1e-4);
    }
    full_set_currents(&p, 0.5, -0.5);
    full_advance(&p, 100000000);
    CHECK(p.moving.state.a_A == 0.5 && p.moving.state.b_A == -0.5); /* regulated: the command itself */
    CHECK_NEAR(p.moving.a_V, 0.55, 1e-3);
}

static void a_stopped_shaft_stays(void)
{
    hil_axis_params bare = FULL;
    bare.full.detent_torque_Nm = 0;
    full p = motor(&bare);
    full_set_load(&p, 0.00399);
    full_advance(&p, 10000000000);
    CHECK(p.at_rest && p.moving.state.rev == 0 && p.moving.state.rev_per_s == 0);
    full_set_load(&p, 0.00401);
    full_advance(&p, 11000000000);
    CHECK(p.moving.state.rev_per_s > 0);
    full_set_load(&p, 0);
    full_advance(&p, 20000000000);
    CHECK(p.at_rest && p.moving.state.rev_per_s == 0);
}

static void detent_has_four_places_a_tooth(void)
{
    hil_axis_params smooth = FULL;
    smooth.full.full_step_error_pct = smooth.full.coulomb_torque_Nm = 0;
    smooth.viscous_Nm_s_per_rad = 0.002;
    for (int step = -8; step < 8; step++) {
        smooth.start_deg = (step + 0.4) * 1.8;
        full p = motor(&smooth);
        full_advance(&p, 2000000000);
        CHECK_NEAR(p.moving.state.rev * 200, step, 1e-6);
        p.moving.state.rev += 1 / 1600.0; /* an eighth of a detent's period further: its largest torque */
        CHECK_NEAR(full_motor_torque_Nm(&p), -0.015 * sin(TAU / 8), 1e-6);
    }
}

static void resting_is_the_same_as_stepping(void)
{
    uint64_t seed = 2;
    full skipping = motor(&FULL), stepping = skipping;
    int64_t now_ns = 0;
    int rests = 0;
    for (int change = 0; change < 8; change++) {
        double a_A = (double)random_below(&seed, 200) / 100 - 1, b_A = (double)random_below(&seed, 200) / 100 - 1;
        full_node(&skipping, now_ns);
        full_node(&stepping, now_ns);
        full_set_currents(&skipping, a_A, b_A);
        full_set_currents(&stepping, a_A, b_A);
        now_ns += 500000000 + random_below(&seed, 1000000);
        full_advance(&skipping, now_ns);
        rests += skipping.at_rest;
        while (now_ns - stepping.node_ns >= stepping.step_ns) {
            if (stepping.at_rest) stepping.rest_since_ns = stepping.node_ns + stepping.step_ns;
            stepping.at_rest = 0;
            full_advance(&stepping, stepping.node_ns + stepping.step_ns);
        }
        CHECK(!memcmp(&skipping.moving.state, &stepping.moving.state, sizeof skipping.moving.state));
        CHECK_INT(skipping.node_ns, stepping.node_ns);
        full a = full_at(&skipping, now_ns), b = full_at(&stepping, now_ns);
        CHECK_NEAR(a.moving.energy.electrical_J, b.moving.energy.electrical_J, 1e-9);
        CHECK_NEAR(a.moving.energy.copper_J, b.moving.energy.copper_J, 1e-9);
    }
    CHECK(rests > 4);
}

typedef struct journey {
    full at[100];
    int raw[100];
} journey;

/* 100 changes of current or load at given times; between them a reader that looks and advances as it likes. */
static void travel(uint64_t reader, journey *j)
{
    hil_axis_params params = FULL;
    params.load = (hil_load){.inertia_kg_m2 = 1e-5, .pendulum_Nm = 0.05, .stiffness_Nm_per_rad = 0.01, .end_stops = 1,
                             .min_deg = -30, .max_deg = 20};
    full p = motor(&params);
    uint64_t plan = 3;
    int64_t now_ns = 0;
    for (int i = 0; i < 100; i++) {
        int64_t then_ns = now_ns + random_below(&plan, i % 10 ? 3000000 : 300000000); /* long enough for a rest */
        for (int look = reader ? (int)random_below(&reader, 20) : 0; look > 0 && now_ns < then_ns; look--) {
            now_ns += random_below(&reader, then_ns - now_ns + 1);
            if (look & 1) full_advance(&p, now_ns);
            else full_at(&p, now_ns);
        }
        now_ns = then_ns;
        j->at[i] = full_at(&p, now_ns);
        j->raw[i] = full_raw(&j->at[i], now_ns);
        full_node(&p, now_ns);
        CHECK(same(&j->at[i], &p));
        if (next_random(&plan) & 1)
            full_set_currents(&p, (double)random_below(&plan, 400) / 100 - 2, (double)random_below(&plan, 400) / 100 - 2);
        else
            full_set_load(&p, (double)random_below(&plan, 400) / 1000 - 0.2);
    }
}

static void looking_changes_nothing(void)
{
    journey undisturbed, j;
    travel(0, &undisturbed);
    for (uint64_t reader = 1; reader <= 100; reader++) {
        travel(reader, &j);
        for (int i = 0; i < 100; i++) {
            CHECK(same(&j.at[i], &undisturbed.at[i]));
            CHECK_INT(j.raw[i], undisturbed.raw[i]);
        }
    }
}

static void noise_is_a_function_of_seed_and_time(void)
{
    hil_axis_params noisy = FULL, other = FULL;
    noisy.full.encoder_noise_counts = other.full.encoder_noise_counts = 20;
    noisy.full.encoder_eccentricity_deg = noisy.full.encoder_nonlinearity_deg = 0;
    noisy.start_deg = 180;
    other.seed = 8;
    full p = motor(&noisy), q = motor(&other);
    double sum = 0, squares = 0;
    int differ = 0, n = 100000;
    for (int i = 0; i < n; i++) {
        int raw = full_raw(&p, i), deviation = raw - 8192;
        CHECK_INT(full_raw(&p, i), raw);
        sum += deviation + 0.5; /* counts are rounded down */
        squares += (deviation + 0.5) * (deviation + 0.5);
        differ += full_raw(&q, i) != raw;
    }
    CHECK_NEAR(sum / n, 0, 0.3);
    CHECK_NEAR(sqrt(squares / n), 20, 0.3);
    CHECK(differ > n / 2);
}

static void end_stops_hold_and_let_go(void)
{
    hil_axis_params stopped = FULL;
    stopped.load = (hil_load){.end_stops = 1, .min_deg = -10, .max_deg = 10};
    full p = motor(&stopped);
    for (int sign = -1; sign <= 1; sign += 2) {
        int64_t since_ns = p.node_ns;
        full_set_load(&p, sign * 0.3);
        full_advance(&p, since_ns + 1000000000);
        CHECK_NEAR(p.moving.state.rev * 360, sign * 10, 0.1);
        CHECK_NEAR(p.moving.state.rev_per_s, 0, 1e-3);
    }
    full_set_load(&p, -0.03);
    full_advance(&p, p.node_ns + 5000000);
    CHECK(p.moving.state.rev * 360 < 10);
}

/* At the limit of speed the coils carry what their inductance lets through, not what a few ohms would. */
static void a_dragged_shaft_has_a_limit(void)
{
    static const double LOADS[] = {0.35, 3.4, -3.4, 1e6};
    for (int i = 0; i < 4; i++) {
        hil_axis_params params = FULL;
        full p = motor(&params);
        full_set_currents(&p, 1, 1);
        full_set_load(&p, LOADS[i]);
        full_advance(&p, 500000000);
        CHECK_NEAR(60 * p.moving.state.rev_per_s, copysign(10000, LOADS[i]), 1e-6);
        for (int64_t t_ns = 500000000; t_ns < 510000000; t_ns += 10000) {
            full_node(&p, t_ns);
            CHECK(hypot(p.moving.state.a_A, p.moving.state.b_A) < 4);
        }
    }
}

static void extremes_are_defined(void)
{
    static const double LOADS[] = {NAN, INFINITY, -INFINITY, -1e300, 1e300, 1e15, 1};
    hil_axis_params params = FULL;
    for (int i = 0; i < 7; i++)
        for (int kind = 0; kind < 2; kind++) {
            params.load = kind ? (hil_load){.end_stops = 1, .min_deg = -10, .max_deg = 10, .pendulum_Nm = 1}
                               : (hil_load){.stiffness_Nm_per_rad = 1};
            full p = motor(&params);
            full_set_currents(&p, 2, 2);
            full_set_load(&p, LOADS[i]);
            for (int64_t t_ns = 0; t_ns < 1000000000; t_ns += 10000000) {
                full_node(&p, t_ns);
                full_raw(&p, t_ns);
                double all[] = {p.moving.state.rev, p.moving.state.rev_per_s, p.moving.state.a_A, p.moving.state.b_A, p.moving.a_V, p.moving.b_V,
                                full_motor_torque_Nm(&p), p.moving.energy.electrical_J, p.moving.energy.copper_J,
                                p.moving.energy.friction_J, p.moving.energy.load_J, p.load_torque_Nm};
                for (int k = 0; k < 12; k++) CHECK(isfinite(all[k]));
            }
        }
    full p;
    hil_axis_params stiff[6] = {FULL, FULL, FULL, FULL, FULL, FULL};
    stiff[0].inertia_kg_m2 = 1e-30;
    stiff[1].viscous_Nm_s_per_rad = 1e300;
    stiff[2].torque_constant_Nm_per_A = 1e300;
    stiff[3].full.phase_resistance_ohm = 1e300;
    stiff[4].full.phase_inductance_H = 1e-300;
    stiff[5].load.stiffness_Nm_per_rad = 1e300;
    for (int i = 0; i < 6; i++) CHECK_INT(full_init(&p, &stiff[i], 2.2, 0), -1);
}

void full_tests(void)
{
    RUN(current_rises_with_L_over_R);
    RUN(a_stopped_shaft_stays);
    RUN(detent_has_four_places_a_tooth);
    RUN(resting_is_the_same_as_stepping);
    RUN(looking_changes_nothing);
    RUN(noise_is_a_function_of_seed_and_time);
    RUN(end_stops_hold_and_let_go);
    RUN(a_dragged_shaft_has_a_limit);
    RUN(extremes_are_defined);
}
