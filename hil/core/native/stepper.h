/* A stepper: the SAC's motion engine with its driver and its pins, and what its pulses do to a motor. */
#ifndef HIL_STEPPER_H
#define HIL_STEPPER_H

#include "motion/engine.h"
#include "state.h"

#define STEPPER_WIRES 16
#define MICROSTEPS 128 /* positions of the driver in a full step, in which every driver's step is whole */

/* From an output to an input, which `set` sets. */
typedef struct stepper_wire {
    int out, to_axis, to_pin;
    void (*set)(hil_core *c, int to_axis, int to_pin, int level, int64_t at_ns);
} stepper_wire;

struct stepper {
    motion motion;
    int driver, teeth, is_reported;
    int is_set_up;   /* the firmware has got past its cold start */
    int32_t watched; /* outputs that somebody looks at, a bit each: recorded or wired */
    double phase_current_A, origin_rev; /* the shaft's angle where the driver's position is 0 */
    int64_t position; /* of the driver, in microsteps: how far its currents have turned */
    int is_turned;    /* since the plant's last node, so its currents are those of an earlier position */
    int64_t fall_ns;  /* of clk, if anybody looks at it; HIL_FOREVER: not high */
    int32_t levels[HIL_OUTPUTS];
    int32_t ena, enb, quadrature, rst_is_low;
    stepper_wire wires[STEPPER_WIRES];
    int n_wires;
    int32_t recorded; /* outputs, a bit each */
    hil_edge *edges;
    int edges_first, edges_len, edges_room; /* first: that nobody has taken */
};

int stepper_open(hil_axis *a, const hil_axis_params *params); /* -1: no memory */
void stepper_close(hil_axis *a);
void stepper_power_up(hil_core *c, hil_axis *a, int64_t now_ns);
int64_t stepper_next_ns(const hil_axis *a);
int64_t stepper_event(hil_core *c, hil_axis *a, int64_t until_ns); /* all that its engine does up to and at until_ns; how much */
void stepper_plant(hil_axis *a, int64_t t_ns); /* the plant's whole steps up to t_ns */
int stepper_join(stepper *s, const stepper_wire *wire); /* -1: too many */
void stepper_pin(hil_core *c, hil_axis *a, int pin, int level, int64_t at_ns);
double stepper_commanded_deg(const hil_axis *a);
double stepper_lag_steps(const hil_axis *a);
double stepper_lost_steps(const hil_axis *a);
int stepper_rst(const hil_axis *a);
int stepper_out(const hil_axis *a, int pin);
int stepper_mode_pins(const hil_axis *a);

#endif
