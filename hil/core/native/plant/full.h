/* The full plant: rotor, two coils behind a supply, magnetic and dry friction's torques, a load, and an
   encoder with errors. docs/decisions/0008-full-plant.md has the equations and what is left out.

   Nodes are as in simple.h: at every change of a current command or of the load, and every step_ns after
   it. Reading at any time steps a copy, so the motion does not depend on how often anybody looked.
   Every number stays finite, whatever the load. */
#ifndef HIL_PLANT_FULL_H
#define HIL_PLANT_FULL_H

#include "../hil_core.h"

/* Four steps to a Mechaduino control step (153854.17 ns), and rounded up so that the fourth ends it. */
#define FULL_STEP_NS 38464
#define FULL_MAX_STEPS 256

typedef struct full_state {
    double rev, rev_per_s, a_A, b_A;
} full_state;

/* Since the opening. electrical = copper + friction + load + what shaft, coils and detent store. */
typedef struct full_energy {
    double electrical_J, copper_J, friction_J, load_J;
} full_energy;

typedef struct full {
    full_state state; /* at node_ns */
    full_energy energy; /* at node_ns; at rest as of rest_since_ns */
    double a_V, b_V; /* mean over the last step */
    int64_t node_ns, step_ns, rest_since_ns;
    int at_rest; /* the last whole step changed nothing: later ones will not either */
    double command_a_A, command_b_A, load_torque_Nm;
    hil_full_params motor;
    hil_load load;
    uint64_t seed;
    double torque_constant_Nm_per_A, teeth, inertia_kg_m2, viscous_Nm_s_per_rad; /* inertia: rotor and load */
    double stop_Nm_per_rad, stop_Nm_s_per_rad;
    double step_error_rev, step_error_phase, eccentricity_rev, eccentricity_phase, nonlinearity_rev, nonlinearity_phase;
} full;

/* Values as hil_core.h wants them. -1: too stiff to integrate in FULL_MAX_STEPS. */
int full_init(full *p, const hil_axis_params *params, double max_current_A, int64_t now_ns);
void full_advance(full *p, int64_t t_ns); /* the whole steps up to t_ns */
void full_node(full *p, int64_t t_ns);    /* makes t_ns a node: call it before full_set_* */
void full_set_currents(full *p, double a_A, double b_A); /* what the driver is told */
void full_set_load(full *p, double torque_Nm);
full full_at(const full *p, int64_t t_ns); /* the plant at t_ns, not before the node */
double full_motor_torque_Nm(const full *p); /* at the node, detent included */
/* What the encoder reads with its errors: a function of the shaft, the time and the seed alone. */
int full_raw(const full *p, int64_t t_ns);

#endif
