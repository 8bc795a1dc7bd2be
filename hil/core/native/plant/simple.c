#include "simple.h"

#include <math.h>
#include <string.h>

#include "trig.h"

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

/* Runge-Kutta of fourth order; *accel is the acceleration at s without friction, and follows it. */
static plant_shaft step(const plant *p, plant_shaft s, double *accel, double h_s)
{
    double v1 = s.rev_per_s, a1 = *accel - p->damping_per_s * v1;
    double v2 = v1 + a1 * (h_s * 0.5), a2 = acceleration(p, s.rev + v1 * (h_s * 0.5)) - p->damping_per_s * v2;
    double v3 = v1 + a2 * (h_s * 0.5), a3 = acceleration(p, s.rev + v2 * (h_s * 0.5)) - p->damping_per_s * v3;
    double v4 = v1 + a3 * h_s, a4 = acceleration(p, s.rev + v3 * h_s) - p->damping_per_s * v4;
    s.rev += (v1 + 2 * v2 + 2 * v3 + v4) * (h_s / 6);
    s.rev_per_s += (a1 + 2 * a2 + 2 * a3 + a4) * (h_s / 6);
    *accel = acceleration(p, s.rev);
    return s;
}

/* The step that resolves the fastest thing the plant can do, friction's decay or the swing about a coil's
   pull at the largest current, to a part of 1e-4. */
static int64_t step_for(const plant *p, double max_current_A)
{
    double pull = p->torque_constant_Nm_per_A * max_current_A * p->teeth * p->per_inertia * TWO_PI;
    double swing_per_s = sqrt(2 * pull), rate_per_s = fmax(p->damping_per_s, swing_per_s);
    double steps = ceil(rate_per_s * (PLANT_STEP_NS * 1e-9) / 0.5);
    if (!(steps <= PLANT_MAX_STEPS)) return 0;
    return PLANT_STEP_NS / (int64_t)fmax(steps, 1);
}

int plant_init(plant *p, double inertia_kg_m2, double viscous_Nm_s_per_rad, double torque_constant_Nm_per_A,
               int teeth, double max_current_A, double start_rev, double load_torque_Nm, int64_t now_ns)
{
    *p = (plant){.shaft = {start_rev, 0}, .node_ns = now_ns, .load_torque_Nm = load_torque_Nm,
                 .torque_constant_Nm_per_A = torque_constant_Nm_per_A, .teeth = teeth,
                 .per_inertia = 1 / (inertia_kg_m2 * TWO_PI),
                 .damping_per_s = viscous_Nm_s_per_rad / inertia_kg_m2};
    p->acceleration = acceleration(p, start_rev);
    p->step_ns = step_for(p, max_current_A);
    return p->step_ns ? 0 : -1;
}

void plant_advance(plant *p, int64_t t_ns)
{
    while (t_ns - p->node_ns >= p->step_ns) {
        if (p->at_rest) {
            p->node_ns += (t_ns - p->node_ns) / p->step_ns * p->step_ns;
            return;
        }
        plant_shaft s = step(p, p->shaft, &p->acceleration, p->step_ns * 1e-9);
        p->at_rest = !memcmp(&s, &p->shaft, sizeof s); /* the bits: == takes -0 for 0 */
        p->shaft = s;
        p->node_ns += p->step_ns;
    }
}

static plant_shaft partial(const plant *p, int64_t t_ns, double *accel)
{
    double h_s = (double)(t_ns - p->node_ns) * 1e-9;
    return step(p, p->shaft, accel, h_s);
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
