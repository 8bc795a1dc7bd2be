/* The full plant: rotor, two coils behind a supply, magnetic and dry friction's torques, a load, and an
   encoder with errors. docs/decisions/0008-full-plant.md has the equations and what is left out.

   Nodes are as in simple.h: at every change of a current command or of the load, and every step_ns after
   it. Reading at any time steps a copy, so the motion does not depend on how often anybody looked.
   Every number stays finite, whatever the load. */
#ifndef HIL_PLANT_FULL_H
#define HIL_PLANT_FULL_H

#include "../types.h"
#include "speed.h"
#include "trig.h"
#include "full_kernel.h"

/* Four steps to a Mechaduino control step (153854.17 ns), and rounded up so that the fourth ends it. */
#define FULL_STEP_NS 38464
#define FULL_MAX_STEPS 256

#define FULL_WINDOW 4 /* steps */

typedef struct full {
    full_moving moving; /* at node_ns; its energy, at rest, as of rest_since_ns */
    int64_t node_ns, step_ns, rest_since_ns;
    int steps; /* of the present window */
    int stirred; /* the window's steps have changed something */
    int at_rest; /* a whole window's changed nothing: later ones will not either */
    double command_a_A, command_b_A, steady_Nm; /* steady: what pulls the same everywhere */
    int load_varies; /* with angle or speed */
    full_motor motor;
    full_rate whole, part[2]; /* part[n]: of the latest shorter step of an even or odd length */
    int64_t part_ns[2];
    int is_jammed; /* the shaft stands at jam_rev, whatever pulls */
    double jam_rev;
    uint64_t noise_key;
    double noise_counts, load_torque_Nm, inertia_kg_m2, inductance_H; /* inertia: rotor and load */
    hil_load load;
    double fall_a, fall_b; /* how much of the supply brings a coil's current down: 0 none to 1 all */
    double stop_Nm_per_rad, stop_Nm_s_per_rad;
} full;

/* Values as types.h wants them. -1: too stiff to integrate in FULL_MAX_STEPS. */
int full_init(full *p, const hil_axis_params *params, double max_current_A, int64_t now_ns);
void full_advance(full *p, int64_t t_ns); /* the whole steps up to t_ns */
void full_node(full *p, int64_t t_ns);    /* makes t_ns a node: call it before full_set_* */
void full_set_currents(full *p, double a_A, double b_A); /* what the driver is told */
void full_set_fall(full *p, double a, double b); /* of the supply, 0 to 1: what a falling current gets; 1 until then */
void full_jam(full *p, int is_jammed); /* at a node */
void full_set_load(full *p, double torque_Nm);
full full_at(const full *p, int64_t t_ns); /* the plant at t_ns, not before the node; t_ns is a node */
double full_motor_torque_Nm(const full *p); /* at the node, detent included */
/* What the encoder reads with its errors, at a node: a function of the shaft, the time and the seed alone. */
int full_raw(const full *p, int64_t t_ns);
/* What a step of h_ns, shorter than a whole one, is multiplied with. */
const full_rate *full_part(full *p, int64_t h_ns);

#endif
