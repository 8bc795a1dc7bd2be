/* Acceleration ramps of the SAC's motion engine: the period of each step, in microseconds.

   Harmonic: the speed changes by the same amount from step to step. Linear: Austin's recurrence for constant
   acceleration. docs/decisions/0010-motion-engine.md has both. */
#ifndef HIL_MOTION_RAMP_H
#define HIL_MOTION_RAMP_H

#include <stdint.h>

#define RAMP_MARKS 384 /* above the root of RAMP_EXACT: what is between two marks fits */
#define RAMP_EXACT 131072

/* A linear ramp downwards is the upward one's list, last value first. Of its first RAMP_EXACT values some are kept,
   from which the ones between are computed again, a window at a time: no value differs. The ones after, which no
   motor ever reaches, come from the recurrence's closed form, to a few parts in 1e16: an absurd ramp costs no more
   time and memory than a long one. */
typedef struct ramp_list {
    int64_t spacing, window; /* values between two marks; index of the window's first value */
    double marks[RAMP_MARKS], values[RAMP_MARKS];
    double far_c, far_w; /* value RAMP_EXACT, and its place in the closed form */
} ramp_list;

typedef struct ramp {
    ramp_list *list;              /* not NULL: reversed */
    int64_t index;                /* reversed: values left */
    int is_linear;
    int64_t f100, v100, slope100; /* harmonic: period = f100 / v100, then v100 += slope100 */
    double c;                     /* linear: the present value of the recurrence, us */
    int64_t n;                    /* linear: its index */
} ramp;

/* Steps from one speed to another, both above 0; no ramp (0) for acceleration 0 or 99900 and above.
   Hundredths: RPM of acceleration a step, or rad/s2. */
int64_t ramp_harmonic_steps(int64_t from_rpm, int64_t to_rpm, int64_t acc_hundredths);
int64_t ramp_linear_steps(int64_t rpm, int64_t acc_hundredths, int64_t steps_per_rev); /* from standstill, n(V) */

/* period_us * rpm = f for steps_per_rev: f = 60,000,000 / steps_per_rev. */
void ramp_harmonic(ramp *r, int64_t f, int64_t start_v100, int64_t slope100);
void ramp_linear_from_stop(ramp *r, int64_t acc_hundredths, int64_t steps_per_rev);
void ramp_linear_from(ramp *r, int64_t first_us, int64_t n1); /* from a speed at index n1 */
/* The first `length` values of a linear ramp that was set up just now, last first. */
void ramp_reverse(ramp *r, int64_t length, ramp_list *list);
int64_t ramp_next_us(ramp *r); /* the next step's period */

#endif
