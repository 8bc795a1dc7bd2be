/* A servo: the Mechaduino's law, its driver and its inputs, with a motor and an encoder. */
#ifndef HIL_LAW_SERVO_H
#define HIL_LAW_SERVO_H

#include "../control/mechaduino.h"
#include "../follow.h"
#include "../law.h"
#include "heat.h"

typedef struct servo {
    mechaduino law;
    int32_t loop_on;
    struct { int32_t dir, step, enable, d3; } pins;
    double amps_per_count;
    int64_t loop_since_ns, loop_steps, control_steps; /* control step k is at since + k * 7385 / 48 MHz */
    follow follow;
    int32_t is_own_law, is_own_step; /* the firmware has a controller, or a step interrupt, of its own: it is told */
    heat heat; /* of its driver */
    float table[];
} servo;

extern const law mechaduino_law;

/* NULL: the axis has another law. */
static inline servo *servo_of(const hil_axis *a) { return a->law == &mechaduino_law ? a->own : NULL; }

/* A4954: current command = Vref / (10 Rsense), 255 counts = 3.3 V; direction by the IN pins. */
static inline void servo_currents(const servo *s, double *a_A, double *b_A)
{
    const mechaduino_pins *p = &s->law.pins;
    *a_A = p->vref1 * s->amps_per_count * (p->in2 - p->in1);
    *b_A = p->vref2 * s->amps_per_count * (p->in4 - p->in3);
}

const servo *servo_view(const hil_axis *a); /* of another law: all zeros, without a table */
int servo_set(mechaduino *law, hil_field field, double value); /* -1: no field of the law's, or read-only */

#endif
