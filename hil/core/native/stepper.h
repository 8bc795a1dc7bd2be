/* A stepper axis: motion engine, driver, motor, pins. For core.h and stepper.c. */
#ifndef HIL_STEPPER_H
#define HIL_STEPPER_H

#include "hil_core.h"

#define STEPPER_WIRES 16
#define MICROSTEPS 128 /* positions of the driver in a full step, in which every driver's step is whole */

typedef struct stepper_wire {
    int out, to_axis, to_pin;
} stepper_wire;

typedef struct stepper {
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
} stepper;

#endif
