#include "simple.h"

#include <math.h>

double plant_motor_torque_Nm(const plant *p, double rev)
{
    double s, c;
    sincos_turns(p->motor.teeth * rev, &s, &c);
    return -p->torque_constant_Nm_per_A * (p->current_a_A * c + p->current_b_A * s);
}

static plant_rate rate_of(const plant *p, int64_t h_ns)
{
    double h_s = (double)h_ns * 1e-9, half_s = 0.5 * h_s, x = p->damping_per_s * half_s;
    /* (1 - exp(-x)) / x by its series, x at most 0.07: the same bits on every machine. */
    double mean = 1 - x * (1.0 / 2 - x * (1.0 / 6 - x * (1.0 / 24 - x * (1.0 / 120 - x * (1.0 / 720 - x * (1.0 / 5040 -
                  x * (1.0 / 40320)))))));
    return (plant_rate){.kick_s = h_s / 6, .middle_kick_s = h_s * (2.0 / 3), .gradient_s2 = h_s * h_s / 24,
                        .reach_s = half_s * mean, .keep = 1 - x * mean};
}

/* The step that resolves the fastest thing the plant can do, friction's decay or the swing about a coil's
   pull at the largest current, to a part of 1e-4, of
   a steady speed to 1e-7. */
static int64_t step_for(const plant *p, double max_current_A)
{
    double pull = p->torque_constant_Nm_per_A * max_current_A * p->motor.teeth * p->per_inertia * TWO_PI;
    double swing_per_s = sqrt(2 * pull), rate_per_s = fmax(4 * p->damping_per_s, swing_per_s);
    double steps = ceil(rate_per_s * (PLANT_STEP_NS * 1e-9) / 0.5);
    if (!(steps <= PLANT_MAX_STEPS)) return 0;
    return PLANT_STEP_NS / (int64_t)fmax(steps, 1);
}

int plant_init(plant *p, double inertia_kg_m2, double viscous_Nm_s_per_rad, double torque_constant_Nm_per_A,
               int teeth, double max_current_A, double start_rev, double load_torque_Nm, int64_t now_ns)
{
    double per_inertia = 1 / (inertia_kg_m2 * TWO_PI);
    *p = (plant){.moving = {.rev = start_rev}, .node_ns = now_ns, .torque_constant_Nm_per_A = torque_constant_Nm_per_A,
                 .motor = {.pull = torque_constant_Nm_per_A * per_inertia, .teeth = teeth, .limit = plant_limit_rev_per_s(teeth)}, .per_inertia = per_inertia,
                 .damping_per_s = viscous_Nm_s_per_rad / inertia_kg_m2, .part_ns = {-1, -1}};
    sincos_turns(p->motor.teeth * start_rev, &p->moving.s, &p->moving.c);
    plant_set_load(p, load_torque_Nm);
    p->step_ns = step_for(p, max_current_A);
    if (!p->step_ns) return -1;
    p->whole = rate_of(p, p->step_ns);
    return 0;
}

void plant_halve(plant *p)
{
    p->step_ns /= 2;
    p->whole = rate_of(p, p->step_ns);
}

/* A jammed shaft is put back after each step: it then moves alike however time is cut. */
static void hold(plant *p)
{
    if (!p->is_jammed) return;
    p->moving.rev = p->jam_rev;
    p->moving.rev_per_s = 0;
}

void plant_jam(plant *p, int is_jammed)
{
    p->is_jammed = is_jammed;
    p->jam_rev = p->moving.rev;
    p->at_rest = 0;
    hold(p);
}

void plant_advance(plant *p, int64_t t_ns)
{
    while (t_ns - p->node_ns >= p->step_ns) {
        if (p->at_rest) {
            p->node_ns += (t_ns - p->node_ns) / p->step_ns * p->step_ns;
            return;
        }
        plant_moving before = p->moving;
        plant_step(&p->motor, &p->whole, &p->moving, p->current_a_A, p->current_b_A);
        hold(p);
        p->at_rest = !memcmp(&before, &p->moving, sizeof before); /* the bits: == takes -0 for 0 */
        p->node_ns += p->step_ns;
    }
}

const plant_rate *plant_part(plant *p, int64_t h_ns)
{
    int slot = h_ns & 1; /* a control loop's steps have two lengths, next to each other */
    if (p->part_ns[slot] != h_ns) {
        p->part_ns[slot] = h_ns;
        p->part[slot] = rate_of(p, h_ns);
    }
    return &p->part[slot];
}

void plant_node(plant *p, int64_t t_ns)
{
    plant_advance(p, t_ns);
    if (t_ns == p->node_ns) return;
    plant_step(&p->motor, plant_part(p, t_ns - p->node_ns), &p->moving, p->current_a_A, p->current_b_A);
    hold(p);
    p->node_ns = t_ns;
    p->at_rest = 0;
}

void plant_set_currents(plant *p, double a_A, double b_A)
{
    p->current_a_A = a_A;
    p->current_b_A = b_A;
    p->at_rest = 0;
}

void plant_set_load(plant *p, double torque_Nm)
{
    p->load_torque_Nm = torque_Nm;
    p->motor.load = torque_Nm * p->per_inertia;
    p->at_rest = 0;
}

plant_shaft plant_at(const plant *p, int64_t t_ns)
{
    plant copy = *p;
    plant_node(&copy, t_ns);
    return (plant_shaft){copy.moving.rev, copy.moving.rev_per_s};
}
