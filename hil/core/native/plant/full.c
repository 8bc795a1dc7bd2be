#include "full.h"

#include <math.h>
#include <string.h>

static const double MOST_REV = 0x1p40, MOST_LOAD_NM = 1e6;

static double bounded(double x, double most)
{
    if (isnan(x)) return 0;
    return x > most ? most : x < -most ? -most : x;
}

static double sine_of_turns(double turns)
{
    double s, c;
    sincos_turns(turns, &s, &c);
    return s;
}

/* One-sided: a stop pushes back, and never holds. */
static double stop_Nm(const full *p, double beyond_rev, double outward_rev_per_s)
{
    if (beyond_rev <= 0) return 0;
    return fmax(0, TWO_PI * (p->stop_Nm_per_rad * beyond_rev + p->stop_Nm_s_per_rad * outward_rev_per_s));
}

static double load_Nm(const full *p, double rev, double rev_per_s)
{
    const hil_load *l = &p->load;
    double torque = p->load_torque_Nm + l->torque_Nm;
    if (l->stiffness_Nm_per_rad > 0) torque -= l->stiffness_Nm_per_rad * TWO_PI * (rev - l->centre_deg / 360);
    if (l->pendulum_Nm > 0) torque -= l->pendulum_Nm * sine_of_turns(rev - floor_of(rev) - l->centre_deg / 360);
    if (l->end_stops)
        torque += stop_Nm(p, l->min_deg / 360 - rev, -rev_per_s) - stop_Nm(p, rev - l->max_deg / 360, rev_per_s);
    return bounded(torque, 1e3 * MOST_LOAD_NM);
}

static full_rate rate_of(const full *p, int64_t h_ns)
{
    double h_s = (double)h_ns * 1e-9, per_step = h_s / p->inertia_kg_m2, braked = 0.5 * p->motor.viscous * per_step;
    double faded = 0.5 * p->motor.R * h_s / p->inductance_H;
    return (full_rate){.h_s = h_s, .half_s = 0.5 * h_s, .slow = (1 - braked) / (1 + braked),
                       .push = per_step / TWO_PI / (1 + braked), .dry = p->motor.coulomb_Nm * per_step / TWO_PI,
                       .henry_per_s = p->inductance_H / h_s, .fade = (1 - faded) / (1 + faded),
                       .feed = h_s / p->inductance_H / (1 + faded)};
}

static void hold(full *p)
{
    if (!p->is_jammed) return;
    p->moving.state.rev = p->jam_rev;
    p->moving.state.rev_per_s = 0;
}

/* What a step leaves of a coil's current. Less than this part of the supply brings it down only while it flows the way it
   is driven; the other way the bridge gives all. */
static double left_A(const full *p, const full_rate *r, double fall, double before_A, double command_A, double after_A,
                     double given_V)
{
    double way = copysign(1, command_A != 0 ? command_A : before_A), least_V = -fall * p->motor.supply_V;
    if (way * before_A <= 0 || way * given_V >= least_V) return command_A;
    double emf_V = given_V - p->motor.R * 0.5 * (before_A + after_A) - r->henry_per_s * (after_A - before_A);
    return r->fade * before_A + r->feed * (way * least_V - emf_V);
}

/* A step that took more of the supply than a falling current gets is made again, with what is left of that current. */
static void step_falling(full *p, const full_rate *r, double load)
{
    full_moving before = p->moving, *x = &p->moving;
    full_step(&p->motor, r, x, p->command_a_A, p->command_b_A, load);
    double a_A = left_A(p, r, p->fall_a, before.state.a_A, p->command_a_A, x->state.a_A, x->a_V);
    double b_A = left_A(p, r, p->fall_b, before.state.b_A, p->command_b_A, x->state.b_A, x->b_V);
    if (a_A == p->command_a_A && b_A == p->command_b_A) return;
    *x = before;
    full_step(&p->motor, r, x, a_A, b_A, load);
}

static void step(full *p, const full_rate *r)
{
    full_moving *x = &p->moving;
    if (p->steps++ == 0) full_open(&p->motor, x);
    double load = p->steady_Nm;
    if (p->load_varies) load = load_Nm(p, x->state.rev + r->half_s * x->state.rev_per_s, x->state.rev_per_s);
    if (p->fall_a < 1 || p->fall_b < 1) step_falling(p, r, load);
    else full_step(&p->motor, r, x, p->command_a_A, p->command_b_A, load);
    hold(p);
}

/* A node at which the next window begins. */
static void close_window(full *p)
{
    full_state *q = &p->moving.state;
    p->steps = p->stirred = 0;
    if (fabs(q->rev) >= MOST_REV) {
        q->rev = copysign(MOST_REV, q->rev);
        q->rev_per_s = 0;
    }
    full_locate(&p->moving);
}

static double phase(uint64_t seed, uint64_t which) { return (double)(full_hash(full_hash(seed) + which) >> 11) * 0x1p-53; }

/* The step that resolves the fastest thing the plant can do. 0: none that is short enough. */
static int64_t step_for(const full *p, double max_current_A)
{
    double stiffness = p->motor.teeth * (1.5 * p->motor.K * max_current_A + 4 * p->motor.detent_Nm) +
                       p->load.stiffness_Nm_per_rad + p->load.pendulum_Nm;
    double swing_per_s = sqrt(stiffness / p->inertia_kg_m2), decay_per_s = p->motor.viscous / p->inertia_kg_m2;
    double rate_per_s = fmax(fmax(swing_per_s, decay_per_s), p->motor.R / p->inductance_H);
    rate_per_s = fmax(rate_per_s, sqrt(p->load.stop_Nm_per_rad / p->inertia_kg_m2));
    double steps = ceil(rate_per_s * (FULL_STEP_NS * 1e-9) / 0.25);
    if (!(steps <= FULL_MAX_STEPS)) return 0;
    return FULL_STEP_NS / (int64_t)fmax(steps, 1);
}

/* An error of so many revolutions at most, as the weights of the angle's sine and cosine. */
static void wave(double most_rev, double turns, double *of_c, double *of_s)
{
    double s, c;
    sincos_turns(turns, &s, &c);
    *of_s = most_rev * s;
    *of_c = most_rev * c;
}

int full_init(full *p, const hil_axis_params *params, double max_current_A, int64_t now_ns)
{
    const hil_full_params *m = &params->full;
    const hil_load *l = &params->load;
    *p = (full){.moving.state.rev = params->start_deg / 360, .node_ns = now_ns, .load = *l, .fall_a = 1, .fall_b = 1,
                .noise_key = full_hash(params->seed), .noise_counts = m->encoder_noise_counts, .part_ns = {-1, -1},
                .inertia_kg_m2 = params->inertia_kg_m2 + l->inertia_kg_m2, .inductance_H = m->phase_inductance_H,
                .load_varies = l->stiffness_Nm_per_rad > 0 || l->pendulum_Nm > 0 || l->end_stops,
                .motor = {.R = m->phase_resistance_ohm, .K = params->torque_constant_Nm_per_A,
                          .supply_V = m->supply_V, .detent_Nm = m->detent_torque_Nm,
                          .viscous = params->viscous_Nm_s_per_rad, .coulomb_Nm = m->coulomb_torque_Nm,
                          .teeth = params->rotor_teeth, .limit = plant_limit_rev_per_s(params->rotor_teeth)}};
    full_motor *of = &p->motor;
    of->emf_V_s = -0.5 * TWO_PI * of->K;
    wave(m->full_step_error_pct / 100 / (4 * params->rotor_teeth), phase(params->seed, 1), &of->step_c, &of->step_s);
    wave(m->encoder_eccentricity_deg / 360, phase(params->seed, 2), &of->once_c, &of->once_s);
    wave(m->encoder_nonlinearity_deg / 360, phase(params->seed, 3), &of->twice_c, &of->twice_s);
    full_set_load(p, params->load_torque_Nm);
    p->step_ns = step_for(p, max_current_A);
    if (!p->step_ns) return -1;
    p->whole = rate_of(p, p->step_ns);
    of->whole_s = p->whole.h_s;
    full_locate(&p->moving);
    /* As stiff as the step resolves, or as it is said; the damper takes most of a hit's energy. */
    double rate_per_s = l->stop_Nm_per_rad > 0 ? sqrt(l->stop_Nm_per_rad / p->inertia_kg_m2) : 0.3 / p->whole.h_s;
    p->stop_Nm_per_rad = p->inertia_kg_m2 * rate_per_s * rate_per_s;
    p->stop_Nm_s_per_rad = 0.6 * p->inertia_kg_m2 * rate_per_s;
    return 0;
}

/* At rest the coils go on heating. One product for the whole rest: sums over parts of it would round
   differently with every way of cutting it. */
static full_energy energy_of_rest(const full *p)
{
    double rested_s = (double)(p->node_ns - p->rest_since_ns) * 1e-9;
    const full_state *x = &p->moving.state;
    full_energy e = p->moving.energy;
    e.electrical_J += (p->moving.a_V * x->a_A + p->moving.b_V * x->b_A) * rested_s;
    e.copper_J += p->motor.R * (x->a_A * x->a_A + x->b_A * x->b_A) * rested_s;
    return e;
}

static void wake(full *p)
{
    if (p->at_rest) p->moving.energy = energy_of_rest(p);
    p->at_rest = 0;
}

void full_advance(full *p, int64_t t_ns)
{
    while (t_ns - p->node_ns >= p->step_ns) {
        if (p->at_rest) {
            p->node_ns += (t_ns - p->node_ns) / p->step_ns * p->step_ns;
            return;
        }
        full_state before = p->moving.state;
        step(p, &p->whole);
        p->node_ns += p->step_ns;
        p->stirred |= memcmp(&before, &p->moving.state, sizeof before) != 0;
        if (p->steps < FULL_WINDOW) continue;
        p->at_rest = !p->stirred;
        p->rest_since_ns = p->node_ns;
        close_window(p);
    }
}

const full_rate *full_part(full *p, int64_t h_ns)
{
    int slot = h_ns & 1; /* a control loop's last steps have two lengths, next to each other */
    if (p->part_ns[slot] != h_ns) {
        p->part_ns[slot] = h_ns;
        p->part[slot] = rate_of(p, h_ns);
    }
    return &p->part[slot];
}

void full_node(full *p, int64_t t_ns)
{
    full_advance(p, t_ns);
    wake(p);
    int64_t h_ns = t_ns - p->node_ns;
    if (h_ns) {
        step(p, full_part(p, h_ns));
        p->node_ns = t_ns;
    }
    if (p->steps) close_window(p);
}

void full_set_currents(full *p, double a_A, double b_A)
{
    wake(p);
    p->command_a_A = a_A;
    p->command_b_A = b_A;
}

void full_set_fall(full *p, double a, double b)
{
    wake(p);
    p->fall_a = a;
    p->fall_b = b;
}

void full_jam(full *p, int is_jammed)
{
    wake(p);
    p->is_jammed = is_jammed;
    p->jam_rev = p->moving.state.rev;
    hold(p);
}

void full_set_load(full *p, double torque_Nm)
{
    wake(p);
    p->load_torque_Nm = bounded(torque_Nm, MOST_LOAD_NM);
    p->steady_Nm = bounded(p->load_torque_Nm + p->load.torque_Nm, 1e3 * MOST_LOAD_NM);
}

full full_at(const full *p, int64_t t_ns)
{
    full copy = *p;
    full_node(&copy, t_ns);
    return copy;
}

double full_motor_torque_Nm(const full *p)
{
    const full_motor *m = &p->motor;
    const full_state *x = &p->moving.state;
    double turn = x->rev - floor_of(x->rev), s, c;
    sincos_turns(turn, &s, &c);
    sincos_turns(m->teeth * (turn + (m->step_c * s + m->step_s * c)), &s, &c);
    return -m->detent_Nm * 4 * s * c * (c * c - s * s) - m->K * (x->a_A * c + x->b_A * s);
}

int full_raw(const full *p, int64_t t_ns)
{
    double noise = full_noise(p->noise_key, p->noise_counts, (uint64_t)t_ns);
    return (int)full_rounded(full_count(&p->motor, &p->moving) + noise);
}
