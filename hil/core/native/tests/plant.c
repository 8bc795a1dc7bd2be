/* The rotor: plant/simple.c. */
#include "fixture.h"

static const double TAU = 6.28318530717958647692;

static plant rotor(double viscous_Nm_s_per_rad, double start_rev, double load_torque_Nm)
{
    plant p;
    plant_init(&p, MECHADUINO.inertia_kg_m2, viscous_Nm_s_per_rad, MECHADUINO.torque_constant_Nm_per_A,
               MECHADUINO.rotor_teeth, 2.2, start_rev, load_torque_Nm, 0);
    return p;
}

static void comes_to_rest(void)
{
    plant p = rotor(0.004, 0, 0);
    plant_set_currents(&p, 0.3, 0); /* torque -cos: stable at -90 electrical degrees */
    plant_advance(&p, 5000000000);
    CHECK(p.at_rest);
    CHECK_NEAR(p.moving.rev, -0.25 / 50, 1e-12);
    CHECK_NEAR(plant_motor_torque_Nm(&p, p.moving.rev), 0, 1e-12);
    plant_set_load(&p, 0.01);
    CHECK(!p.at_rest);
    plant_advance(&p, 10000000000);
    CHECK_NEAR(plant_motor_torque_Nm(&p, p.moving.rev), -0.01, 1e-12);
}

static void resting_is_the_same_as_stepping(void)
{
    static const double STARTS[] = {0, -0.0, 0.123, -7.75, 0.005, 1e6 / 3};
    uint64_t seed = 2;
    for (int start = 0; start < 6; start++) {
        plant skipping = rotor(0.004, STARTS[start], 0), stepping = skipping;
        int64_t now_ns = 0;
        for (int change = 0; change < 6; change++) {
            double a_A = (double)random_below(&seed, 200) / 100 - 1, b_A = (double)random_below(&seed, 200) / 100 - 1;
            int currents = change != 3; /* once a node alone, with nothing new at it */
            plant_node(&skipping, now_ns);
            if (currents) plant_set_currents(&skipping, a_A, b_A);
            while (now_ns - stepping.node_ns >= PLANT_STEP_NS) {
                stepping.at_rest = 0;
                plant_advance(&stepping, stepping.node_ns + PLANT_STEP_NS);
            }
            plant_node(&stepping, now_ns);
            if (currents) plant_set_currents(&stepping, a_A, b_A);
            CHECK(!memcmp(&skipping.moving, &stepping.moving, sizeof skipping.moving));
            CHECK_INT(skipping.node_ns, stepping.node_ns);
            now_ns += 1000000000 + random_below(&seed, 1000000);
            plant_advance(&skipping, now_ns);
        }
        CHECK(skipping.at_rest);
    }
}

typedef struct journey {
    plant_shaft at[200];
} journey;

/* 200 changes of current or load at given times; between them a reader that looks and advances as it likes. */
static journey travel(uint64_t reader)
{
    plant p = rotor(0.004, 0.3, 0);
    journey j;
    uint64_t plan = 3;
    int64_t now_ns = 0;
    for (int i = 0; i < 200; i++) {
        int64_t then_ns = now_ns + random_below(&plan, 3000000);
        for (int look = reader ? (int)random_below(&reader, 20) : 0; look > 0 && now_ns < then_ns; look--) {
            now_ns += random_below(&reader, then_ns - now_ns + 1);
            if (look & 1) plant_advance(&p, now_ns);
            else plant_at(&p, now_ns);
        }
        now_ns = then_ns;
        j.at[i] = plant_at(&p, now_ns);
        plant_node(&p, now_ns);
        CHECK(!memcmp(&j.at[i], &p.moving, sizeof j.at[i]));
        if (next_random(&plan) & 1)
            plant_set_currents(&p, (double)random_below(&plan, 200) / 100 - 1, (double)random_below(&plan, 200) / 100 - 1);
        else
            plant_set_load(&p, (double)random_below(&plan, 200) / 1000 - 0.1);
    }
    return j;
}

static void looking_changes_nothing(void)
{
    journey undisturbed = travel(0);
    for (uint64_t reader = 1; reader <= 200; reader++) {
        journey j = travel(reader);
        CHECK(!memcmp(&j, &undisturbed, sizeof j));
    }
}

static void terminal_speed(void)
{
    plant p = rotor(0.004, 0, 0.02);
    plant_advance(&p, 1000000000);
    double rad_per_s = p.moving.rev_per_s * TAU;
    CHECK_NEAR(rad_per_s / (0.02 / 0.004), 1, 1e-3);
    plant_set_load(&p, -0.02);
    plant_advance(&p, 2000000000);
    CHECK_NEAR(p.moving.rev_per_s * TAU / -rad_per_s, 1, 1e-3);
}

/* Without friction, kinetic and magnetic energy add up to the same, over 20 s of swinging. */
static void energy_stays(void)
{
    plant p = rotor(0, 0.002, 0);
    plant_set_currents(&p, 0.5, 0);
    double depth_J = 0.225 * 0.5 / 50, least_J = 1, most_J = -1;
    for (int64_t t_ns = 0; t_ns < 20000000000; t_ns += PLANT_STEP_NS) {
        plant_advance(&p, t_ns);
        double rad_per_s = p.moving.rev_per_s * TAU;
        double energy_J = 0.5 * 5.4e-6 * rad_per_s * rad_per_s + depth_J * sin(TAU * 50 * p.moving.rev);
        if (energy_J < least_J) least_J = energy_J;
        if (energy_J > most_J) most_J = energy_J;
    }
    CHECK((most_J - least_J) / depth_J < 2e-3);
    CHECK(!p.at_rest);
}

static void sines(void)
{
    plant p = rotor(0, 0, 0);
    p.torque_constant_Nm_per_A = 1;
    p.motor.teeth = 1;
    uint64_t seed = 4;
    double worst = 0;
    for (int i = 0; i < 1000000; i++) {
        double turns = i < 4000 ? (i - 2000) / 16.0 : ((double)random_below(&seed, 2000000001) / 1e9 - 1) * (i & 1 ? 1 : 1e4);
        long double angle = 6.283185307179586476925286766559L * (long double)(turns - round(turns));
        plant_set_currents(&p, -1, 0);
        worst = fmax(worst, fabs(plant_motor_torque_Nm(&p, turns) - (double)cosl(angle)));
        plant_set_currents(&p, 0, -1);
        worst = fmax(worst, fabs(plant_motor_torque_Nm(&p, turns) - (double)sinl(angle)));
    }
    CHECK(worst < 1e-14);
}

/* Whatever drags it: the limit and no more, and the usual speed as soon as it is let go. */
static void a_dragged_shaft_has_a_limit(void)
{
    static const struct { int teeth; double rpm; } LIMITS[] = {{50, 10000}, {200, 2500}, {1000, 500}, {4, 30000}, {1, 30000}};
    static const double LOADS[] = {4.95, -4.95, 0.5, -0.5};
    for (int i = 0; i < 5; i++) CHECK_NEAR(60 * plant_limit_rev_per_s(LIMITS[i].teeth), LIMITS[i].rpm, 1e-9);
    for (int i = 0; i < 4; i++) {
        plant p = rotor(0, 0, LOADS[i]);
        plant_advance(&p, 100000000);
        CHECK(60 * p.moving.rev_per_s == copysign(10000, LOADS[i]));
        CHECK(isfinite(p.moving.rev));
        CHECK_NEAR(p.moving.rev, copysign(0.1 * 10000 / 60, LOADS[i]), 1);
    }
    plant p = rotor(0.004, 0, 4.95);
    plant_advance(&p, 1000000000);
    plant_set_load(&p, 0.02);
    plant_advance(&p, 2000000000);
    CHECK_NEAR(p.moving.rev_per_s * TAU / (0.02 / 0.004), 1, 1e-3);
}

/* Friction alone brings it to a stand, and not to ever smaller speeds. */
static void a_free_shaft_comes_to_rest(void)
{
    plant p = rotor(0.004, 0, 0.02);
    plant_advance(&p, 1000000000);
    plant_node(&p, 1000000000);
    plant_set_load(&p, 0);
    plant_advance(&p, 1200000000);
    CHECK(p.moving.rev_per_s == 0 && !signbit(p.moving.rev_per_s));
    CHECK(p.at_rest);
}

/* Friction without a limit, and a load that sends the rotor away, end in numbers, not in a hang. */
static void extremes_are_defined(void)
{
    plant p;
    CHECK(plant_init(&p, 5.4e-6, 1e300, 0.225, 50, 2.2, 0.1, 1, 0) == -1);
    CHECK(plant_init(&p, 1e-30, 0.004, 0.225, 50, 2.2, 0.1, 1, 0) == -1);
    p = rotor(1, 0.1, 1); /* stiff: 250 times the usual friction */
    CHECK(p.step_ns < PLANT_STEP_NS / 20);
    plant_advance(&p, 1000000000);
    CHECK_NEAR(p.moving.rev_per_s * TAU, 1, 1e-6);
    static const double LOADS[] = {NAN, INFINITY, -1e300, 1e300, 1e15};
    for (int i = 0; i < 5; i++) {
        p = rotor(0.004, 0.1, 0);
        plant_set_currents(&p, 1, 1);
        plant_set_load(&p, LOADS[i]);
        for (int64_t t_ns = 0; t_ns < 100000000; t_ns += 10000000) plant_node(&p, t_ns);
    }
}

void plant_tests(void)
{
    RUN(comes_to_rest);
    RUN(resting_is_the_same_as_stepping);
    RUN(looking_changes_nothing);
    RUN(terminal_speed);
    RUN(energy_stays);
    RUN(a_dragged_shaft_has_a_limit);
    RUN(a_free_shaft_comes_to_rest);
    RUN(sines);
    RUN(extremes_are_defined);
}
