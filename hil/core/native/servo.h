/* A servo: the Mechaduino's law, its driver and its inputs, with a motor and an encoder. */
#ifndef HIL_SERVO_H
#define HIL_SERVO_H

#include "state.h"

/* A4954: current command = Vref / (10 Rsense), 255 counts = 3.3 V; direction by the IN pins. */
static inline void servo_currents(const hil_axis *a, double *a_A, double *b_A)
{
    const mechaduino_pins *p = &a->law.pins;
    *a_A = p->vref1 * a->amps_per_count * (p->in2 - p->in1);
    *b_A = p->vref2 * a->amps_per_count * (p->in4 - p->in3);
}

void servo_power_up(hil_axis *a, int64_t now_ns);
void servo_step(hil_core *c, hil_axis *a, int axis); /* the control step at next_step_ns */
void servo_drive(hil_axis *a);                       /* the law's currents, at a node */
void servo_pin(hil_core *c, hil_axis *a, int axis, int pin, int level, int64_t at_ns); /* a level, which may be as it was */
int servo_set(mechaduino *law, hil_field field, double value); /* -1: no field of the law's, or read-only */
int32_t servo_i32(double x); /* the nearest that fits, toward 0; NaN: 0. C leaves both undefined */

#endif
