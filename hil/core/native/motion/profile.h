/* How many pulses of a command accelerate, cruise and decelerate. */
#ifndef HIL_MOTION_PROFILE_H
#define HIL_MOTION_PROFILE_H

#include "engine.h"

void profile_begin(motion *m, int64_t from_rpm); /* m->now from this speed on */
int profile_stop(motion *m, int64_t from_rpm);   /* only the ramp down, with the command's dec; 0: no step of it */
void profile_decel(motion *m);                   /* its ramp down to a stop, decel_steps long */
int64_t profile_rpm(const motion *m);            /* the present speed */

/* A driver takes no pulse period shorter than 2 us (manual, slow speed). */
static inline int64_t profile_period(const motion *m, int64_t period_us)
{
    int64_t least_us = 2 << m->setup.microstep_exponent;
    return period_us < least_us ? least_us : period_us;
}

#endif
