#include "simple.h"

#include <math.h>
#include <string.h>

static const double TWO_PI = 6.28318530717958647692;

/* sin and cos of an angle in turns, to about 1e-15, of plain operations only: the same bits on every
   machine, whatever its libm. From 2^50 turns on (a rotor that an absurd load has run away with) NaN. */
static void sincos_turns(double turns, double *s, double *c)
{
    if (!(fabs(turns) < 0x1p50)) {
        *s = *c = NAN;
        return;
    }
    int64_t quarter = (int64_t)(4 * turns + (turns < 0 ? -0.5 : 0.5));
    double x = (turns - (double)quarter * 0.25) * TWO_PI, xx = x * x; /* |x| <= pi/4 */
    double sine = x + x * xx * (-1.0 / 6 + xx * (1.0 / 120 + xx * (-1.0 / 5040 + xx * (1.0 / 362880 +
                  xx * (-1.0 / 39916800 + xx * (1.0 / 6227020800.0 + xx * (-1.0 / 1307674368000.0)))))));
    double cosine = 1 + xx * (-0.5 + xx * (1.0 / 24 + xx * (-1.0 / 720 + xx * (1.0 / 40320 +
                    xx * (-1.0 / 3628800 + xx * (1.0 / 479001600.0 + xx * (-1.0 / 87178291200.0)))))));
    switch (quarter & 3) {
    case 0: *s = sine; *c = cosine; break;
    case 1: *s = cosine; *c = -sine; break;
    case 2: *s = -sine; *c = -cosine; break;
    default: *s = -cosine; *c = sine; break;
    }
}

/* exp(-x) for 0 <= x, of plain operations for the same reason. */
static double decay(double x)
{
    if (!(x < 1000)) return 0; /* below the smallest double; and an infinite x would halve for ever */
    int halvings = 0;
    while (x > 0.05) {
        x *= 0.5;
        halvings++;
    }
    double e = 1 - x * (1 - x / 2 * (1 - x / 3 * (1 - x / 4 * (1 - x / 5 * (1 - x / 6 * (1 - x / 7))))));
    while (halvings--) e *= e;
    return e;
}

double plant_motor_torque_Nm(const plant *p, double rev)
{
    double s, c;
    sincos_turns(p->teeth * rev, &s, &c);
    return -p->torque_constant_Nm_per_A * (p->current_a_A * c + p->current_b_A * s);
}

static double acceleration(const plant *p, double rev)
{
    return (plant_motor_torque_Nm(p, rev) + p->load_torque_Nm) * p->per_inertia;
}

/* Kick, damp, drift, damp, kick: second order, one torque a step, exact damping. */
static plant_shaft step(const plant *p, plant_shaft s, double *accel, double h_s, double half_decay)
{
    s.rev_per_s = (s.rev_per_s + *accel * (h_s * 0.5)) * half_decay;
    s.rev += s.rev_per_s * h_s;
    *accel = acceleration(p, s.rev);
    s.rev_per_s = s.rev_per_s * half_decay + *accel * (h_s * 0.5);
    return s;
}

void plant_init(plant *p, double inertia_kg_m2, double viscous_Nm_s_per_rad, double torque_constant_Nm_per_A,
                int teeth, double start_rev, double load_torque_Nm, int64_t now_ns)
{
    *p = (plant){.shaft = {start_rev, 0}, .node_ns = now_ns, .load_torque_Nm = load_torque_Nm,
                 .torque_constant_Nm_per_A = torque_constant_Nm_per_A, .teeth = teeth,
                 .per_inertia = 1 / (inertia_kg_m2 * TWO_PI),
                 .damping_per_s = viscous_Nm_s_per_rad / inertia_kg_m2};
    p->full_step_decay = decay(p->damping_per_s * (PLANT_STEP_NS * 1e-9) * 0.5);
    p->acceleration = acceleration(p, start_rev);
}

void plant_advance(plant *p, int64_t t_ns)
{
    while (t_ns - p->node_ns >= PLANT_STEP_NS) {
        if (p->at_rest) {
            p->node_ns += (t_ns - p->node_ns) / PLANT_STEP_NS * PLANT_STEP_NS;
            return;
        }
        plant_shaft s = step(p, p->shaft, &p->acceleration, PLANT_STEP_NS * 1e-9, p->full_step_decay);
        p->at_rest = !memcmp(&s, &p->shaft, sizeof s); /* the bits: == takes -0 for 0 */
        p->shaft = s;
        p->node_ns += PLANT_STEP_NS;
    }
}

static plant_shaft partial(const plant *p, int64_t t_ns, double *accel)
{
    double h_s = (double)(t_ns - p->node_ns) * 1e-9;
    return step(p, p->shaft, accel, h_s, decay(p->damping_per_s * h_s * 0.5));
}

void plant_node(plant *p, int64_t t_ns)
{
    plant_advance(p, t_ns);
    if (t_ns == p->node_ns) return;
    p->shaft = partial(p, t_ns, &p->acceleration);
    p->node_ns = t_ns;
    p->at_rest = 0;
}

void plant_set_currents(plant *p, double a_A, double b_A)
{
    p->current_a_A = a_A;
    p->current_b_A = b_A;
    p->acceleration = acceleration(p, p->shaft.rev);
    p->at_rest = 0;
}

void plant_set_load(plant *p, double torque_Nm)
{
    p->load_torque_Nm = torque_Nm;
    p->acceleration = acceleration(p, p->shaft.rev);
    p->at_rest = 0;
}

plant_shaft plant_at(const plant *p, int64_t t_ns)
{
    plant copy = *p;
    plant_advance(&copy, t_ns);
    double accel = copy.acceleration;
    return t_ns == copy.node_ns ? copy.shaft : partial(&copy, t_ns, &accel);
}
