#include "full.h"

#include <math.h>
#include <string.h>

#include "trig.h"

static const double MOST_REV = 0x1p40, MOST_REV_PER_S = 1e6, MOST_A = 1e6, MOST_LOAD_NM = 1e6;

static double bounded(double x, double most)
{
    if (isnan(x)) return 0;
    return x > most ? most : x < -most ? -most : x;
}

/* Turns without the whole ones: teeth are whole numbers, so nothing is lost and large angles keep a sine. */
static double part_of_turn(double rev) { return rev - floor(rev); }

static double sine_of_turns(double turns)
{
    double s, c;
    sincos_turns(turns, &s, &c);
    return s;
}

static double wave_rev(double amplitude_rev, double turns, double phase)
{
    return amplitude_rev == 0 ? 0 : amplitude_rev * sine_of_turns(turns + phase);
}

static void magnetic_angle(const full *p, double rev, double *s, double *c)
{
    double turn = part_of_turn(rev);
    sincos_turns(p->teeth * (turn + wave_rev(p->step_error_rev, turn, p->step_error_phase)), s, c);
}

/* Stable where one coil alone holds the rotor: sin of four times the electrical angle. */
static double detent_Nm(const full *p, double s, double c)
{
    return -p->motor.detent_torque_Nm * 4 * s * c * (c * c - s * s);
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
    if (l->pendulum_Nm > 0) torque -= l->pendulum_Nm * sine_of_turns(part_of_turn(rev) - l->centre_deg / 360);
    if (l->end_stops)
        torque += stop_Nm(p, l->min_deg / 360 - rev, -rev_per_s) - stop_Nm(p, rev - l->max_deg / 360, rev_per_s);
    return bounded(torque, 1e3 * MOST_LOAD_NM);
}

/* The speed after h_s of a torque: viscous friction at the mean speed, then the impulse of dry friction,
   which at most stops the shaft. So a shaft that stands stays until the torque exceeds dry friction. */
static double kicked(const full *p, double rev_per_s, double torque_Nm, double h_s)
{
    double per_step = h_s / p->inertia_kg_m2, half_decay = 0.5 * p->viscous_Nm_s_per_rad * per_step;
    double v = (rev_per_s * (1 - half_decay) + torque_Nm * (per_step / TWO_PI)) / (1 + half_decay);
    double dry = p->motor.coulomb_torque_Nm * per_step / TWO_PI;
    return v > dry ? v - dry : v < -dry ? v + dry : 0;
}

/* One coil over h_s, at the mean of its current before and after. The bridge's mean voltage is the one that
   brings the current to the command, as far as the supply goes. Answers the mean current. */
static double regulated(const full *p, double *current_A, double *voltage_V, double command_A, double emf_V, double h_s)
{
    double R = p->motor.phase_resistance_ohm, L = p->motor.phase_inductance_H, before_A = *current_A;
    double wanted_V = emf_V + 0.5 * R * (before_A + command_A) + L * (command_A - before_A) / h_s;
    if (fabs(wanted_V) <= p->motor.supply_V) {
        *voltage_V = wanted_V;
        *current_A = command_A;
    } else {
        double half_decay = 0.5 * R * h_s / L;
        *voltage_V = copysign(p->motor.supply_V, wanted_V);
        *current_A = (before_A * (1 - half_decay) + (*voltage_V - emf_V) * h_s / L) / (1 + half_decay);
        *current_A = bounded(*current_A, MOST_A);
    }
    return 0.5 * (before_A + *current_A);
}

/* Drift, kick, drift: forces are those of the middle of the step. */
static void step(full *p, double h_s)
{
    full_state *x = &p->state;
    double before = x->rev_per_s, middle_rev = x->rev + 0.5 * h_s * before, s, c;
    double K = p->torque_constant_Nm_per_A;
    magnetic_angle(p, middle_rev, &s, &c);
    double load = load_Nm(p, middle_rev, before), other = load + detent_Nm(p, s, c);
    double guess = kicked(p, before, other - K * (x->a_A * c + x->b_A * s), h_s);
    double emf_per_sine_V = -K * TWO_PI * 0.5 * (before + guess);
    double a_A = regulated(p, &x->a_A, &p->a_V, p->command_a_A, emf_per_sine_V * c, h_s);
    double b_A = regulated(p, &x->b_A, &p->b_V, p->command_b_A, emf_per_sine_V * s, h_s);
    double torque = other - K * (a_A * c + b_A * s);
    x->rev_per_s = bounded(kicked(p, before, torque, h_s), MOST_REV_PER_S);
    x->rev = bounded(middle_rev + 0.5 * h_s * x->rev_per_s, MOST_REV);
    if (fabs(x->rev) >= MOST_REV) x->rev_per_s = 0;

    double rad = TWO_PI * 0.5 * (before + x->rev_per_s) * h_s;
    full_energy *e = &p->energy;
    e->electrical_J += (p->a_V * a_A + p->b_V * b_A) * h_s;
    e->copper_J += p->motor.phase_resistance_ohm * (a_A * a_A + b_A * b_A) * h_s;
    e->friction_J += p->viscous_Nm_s_per_rad * rad * rad / h_s + p->motor.coulomb_torque_Nm * fabs(rad);
    e->load_J -= load * rad;
}

/* splitmix64's finisher: every bit of the result depends on every bit of x. */
static uint64_t hash(uint64_t x)
{
    x += 0x9E3779B97F4A7C15;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EB;
    return x ^ (x >> 31);
}

static double phase(uint64_t seed, uint64_t which) { return (double)(hash(hash(seed) + which) >> 11) * 0x1p-53; }

/* About normal, mean 0, variance 1: four uniform parts of one hash. */
static double noise(uint64_t seed, int64_t t_ns)
{
    uint64_t bits = hash(hash(seed) ^ hash((uint64_t)t_ns));
    double sum = 0;
    for (int i = 0; i < 4; i++, bits >>= 16) sum += (double)(bits & 0xFFFF) + 0.5;
    return (sum * 0x1p-16 - 2) * 1.7320508075688772;
}

/* The step that resolves the fastest thing the plant can do. 0: none that is short enough. */
static int64_t step_for(const full *p, double max_current_A)
{
    double stiffness = p->teeth * (1.5 * p->torque_constant_Nm_per_A * max_current_A + 4 * p->motor.detent_torque_Nm) +
                       p->load.stiffness_Nm_per_rad + p->load.pendulum_Nm;
    double swing_per_s = sqrt(stiffness / p->inertia_kg_m2), decay_per_s = p->viscous_Nm_s_per_rad / p->inertia_kg_m2;
    double rate_per_s = fmax(fmax(swing_per_s, decay_per_s), p->motor.phase_resistance_ohm / p->motor.phase_inductance_H);
    double steps = ceil(rate_per_s * (FULL_STEP_NS * 1e-9) / 0.25);
    if (!(steps <= FULL_MAX_STEPS)) return 0;
    return FULL_STEP_NS / (int64_t)fmax(steps, 1);
}

int full_init(full *p, const hil_axis_params *params, double max_current_A, int64_t now_ns)
{
    const hil_full_params *m = &params->full;
    *p = (full){.state = {params->start_deg / 360, 0, 0, 0}, .node_ns = now_ns, .motor = *m, .load = params->load,
                .seed = params->seed, .torque_constant_Nm_per_A = params->torque_constant_Nm_per_A,
                .teeth = params->rotor_teeth, .inertia_kg_m2 = params->inertia_kg_m2 + params->load.inertia_kg_m2,
                .viscous_Nm_s_per_rad = params->viscous_Nm_s_per_rad,
                .step_error_rev = m->full_step_error_pct / 100 / (4 * params->rotor_teeth),
                .step_error_phase = phase(params->seed, 1), .eccentricity_rev = m->encoder_eccentricity_deg / 360,
                .eccentricity_phase = phase(params->seed, 2), .nonlinearity_rev = m->encoder_nonlinearity_deg / 360,
                .nonlinearity_phase = phase(params->seed, 3)};
    full_set_load(p, params->load_torque_Nm);
    p->step_ns = step_for(p, max_current_A);
    if (!p->step_ns) return -1;
    /* As stiff as the step resolves; the damper takes most of a hit's energy. */
    double rate_per_s = 0.3 / (p->step_ns * 1e-9);
    p->stop_Nm_per_rad = p->inertia_kg_m2 * rate_per_s * rate_per_s;
    p->stop_Nm_s_per_rad = 0.6 * p->inertia_kg_m2 * rate_per_s;
    return 0;
}

/* At rest the coils go on heating. One product for the whole rest: sums over parts of it would round
   differently with every way of cutting it. */
static full_energy energy_of_rest(const full *p)
{
    double rested_s = (double)(p->node_ns - p->rest_since_ns) * 1e-9;
    const full_state *x = &p->state;
    full_energy e = p->energy;
    e.electrical_J += (p->a_V * x->a_A + p->b_V * x->b_A) * rested_s;
    e.copper_J += p->motor.phase_resistance_ohm * (x->a_A * x->a_A + x->b_A * x->b_A) * rested_s;
    return e;
}

static void wake(full *p)
{
    if (p->at_rest) p->energy = energy_of_rest(p);
    p->at_rest = 0;
}

void full_advance(full *p, int64_t t_ns)
{
    while (t_ns - p->node_ns >= p->step_ns) {
        if (p->at_rest) {
            p->node_ns += (t_ns - p->node_ns) / p->step_ns * p->step_ns;
            return;
        }
        full_state before = p->state;
        step(p, p->step_ns * 1e-9);
        p->node_ns += p->step_ns;
        p->at_rest = !memcmp(&before, &p->state, sizeof before);
        p->rest_since_ns = p->node_ns;
    }
}

void full_node(full *p, int64_t t_ns)
{
    full_advance(p, t_ns);
    wake(p);
    if (t_ns == p->node_ns) return;
    step(p, (double)(t_ns - p->node_ns) * 1e-9);
    p->node_ns = t_ns;
}

void full_set_currents(full *p, double a_A, double b_A)
{
    wake(p);
    p->command_a_A = a_A;
    p->command_b_A = b_A;
}

void full_set_load(full *p, double torque_Nm)
{
    wake(p);
    p->load_torque_Nm = bounded(torque_Nm, MOST_LOAD_NM);
}

full full_at(const full *p, int64_t t_ns)
{
    full copy = *p;
    full_node(&copy, t_ns);
    return copy;
}

double full_motor_torque_Nm(const full *p)
{
    double s, c;
    magnetic_angle(p, p->state.rev, &s, &c);
    return detent_Nm(p, s, c) - p->torque_constant_Nm_per_A * (p->state.a_A * c + p->state.b_A * s);
}

int full_raw(const full *p, int64_t t_ns)
{
    double turn = part_of_turn(p->state.rev);
    turn += wave_rev(p->eccentricity_rev, turn, p->eccentricity_phase) +
            wave_rev(p->nonlinearity_rev, 2 * turn, p->nonlinearity_phase);
    double count = turn * 16384;
    if (p->motor.encoder_noise_counts > 0) count += p->motor.encoder_noise_counts * noise(p->seed, t_ns);
    return (int)((int64_t)floor(count) & 16383);
}
