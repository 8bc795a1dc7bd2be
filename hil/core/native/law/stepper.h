/* A stepper: the SAC's motion engine with its driver and its pins, and what its pulses do to a motor. */
#ifndef HIL_LAW_STEPPER_H
#define HIL_LAW_STEPPER_H

#include "../law.h"
#include "../motion/engine.h"
#include "slip.h"

#define MICROSTEPS 128 /* positions of the driver in a full step, in which every driver's step is whole */

typedef struct stepper {
    motion motion;
    int driver, teeth;
    int is_set_up;   /* the firmware has got past its cold start */
    int is_pulsing;  /* it is in the middle of a pulse's edges */
    double phase_current_A, origin_rev; /* the shaft's angle where the driver's position is 0 */
    int64_t position; /* of the driver, in microsteps: how far its currents have turned */
    int64_t fall_ns;  /* of clk's latest pulse */
    slip slip;
    outputs out; /* clk's level may stay high after fall_ns while nobody looks at it */
    int32_t ena, enb, quadrature, rst_is_low;
} stepper;

extern const law sac_law;

/* NULL: the axis has another law. */
static inline stepper *stepper_of(const hil_axis *a) { return a->law == &sac_law ? a->own : NULL; }

static inline int is_clk_watched(const stepper *s) { return (s->out.watched & 1 << HIL_OUT_CLK) != 0; }

double stepper_commanded_rev(const stepper *s);
int stepper_out(const hil_axis *a, int pin, int64_t now_ns);

static inline int stepper_rst(const hil_axis *a) { return stepper_of(a) && !stepper_of(a)->rst_is_low; }

static inline int stepper_mode_pins(const hil_axis *a) { return stepper_of(a) ? stepper_of(a)->motion.setup.mode_pins & 7 : 0; }

#endif
