/* The simple plant: a rotor with inertia, viscous friction and a sinusoidal torque constant; coil
   currents follow their command at once (no inductance, back-EMF, detent or supply limit).

   State lives on a grid of nodes: one at every change of a current or of the load, and one every
   step_ns after it. Between nodes nothing is stored: reading the shaft at any time integrates a
   copy. So the motion does not depend on how often anybody looked, bit for bit. */
#ifndef HIL_PLANT_SIMPLE_H
#define HIL_PLANT_SIMPLE_H

#include <stdint.h>

#include "speed.h"
#include "trig.h"
#include "simple_kernel.h"

/* A Mechaduino control step (153854.17 ns), rounded up so that the next one ends it. A plant that is too
   stiff for that has a whole number of steps in one of these. */
#define PLANT_STEP_NS 153856
#define PLANT_MAX_STEPS 2048

typedef struct plant_shaft {
    double rev, rev_per_s;
} plant_shaft;

typedef struct plant {
    plant_moving moving; /* at node_ns */
    int64_t node_ns, step_ns;
    plant_motor motor;
    double current_a_A, current_b_A, load_torque_Nm;
    int at_rest; /* the last full step changed nothing: later ones will not either */
    int is_jammed; /* the shaft stands at jam_rev, whatever pulls */
    double jam_rev;
    double torque_constant_Nm_per_A, per_inertia, damping_per_s;
    plant_rate whole, part[2]; /* part[n]: of the latest shorter step of an even or odd length */
    int64_t part_ns[2];
} plant;

/* All finite; inertia, torque constant, teeth and largest current above 0. -1: too stiff to integrate in
   PLANT_MAX_STEPS. */
int plant_init(plant *p, double inertia_kg_m2, double viscous_Nm_s_per_rad, double torque_constant_Nm_per_A,
               int teeth, double max_current_A, double start_rev, double load_torque_Nm, int64_t now_ns);
/* Steps of half the length from now on: for a motor whose currents change at the plant's own nodes. */
void plant_halve(plant *p);
/* Runs the whole steps up to t_ns; the node stays behind t_ns by less than a step. */
void plant_advance(plant *p, int64_t t_ns);
/* Makes t_ns a node: call it before a change of current or load, then plant_set_*. */
void plant_node(plant *p, int64_t t_ns);
void plant_set_currents(plant *p, double a_A, double b_A);
void plant_jam(plant *p, int is_jammed); /* at a node */
void plant_set_load(plant *p, double torque_Nm);
/* The shaft at t_ns, not before the node. */
plant_shaft plant_at(const plant *p, int64_t t_ns);
/* The motor's torque at a shaft angle, Nm. */
double plant_motor_torque_Nm(const plant *p, double rev);
/* What a step of h_ns, shorter than a whole one, is multiplied with. */
const plant_rate *plant_part(plant *p, int64_t h_ns);

#endif
