/* The course of one axis under limits of velocity, acceleration and jerk, as phases of constant jerk.

   All of it is relative: position 0 at time 0. Only + - * / and sqrt, which are exact to the bit everywhere. */
#ifndef HIL_MOTION_SHAPE_H
#define HIL_MOTION_SHAPE_H

enum { SHAPE_PHASES = 8 }; /* seven of a way to a position; one to spare */

/* Without a limit of jerk (a trapezoid) j and inverse_j are both 0, and the acceleration jumps. */
typedef struct shape_bounds {
    double v, a, j, inverse_j;
} shape_bounds;

typedef struct shape_phase {
    double t, a, j; /* duration, acceleration at its start, jerk */
} shape_phase;

typedef struct shape {
    int count;
    double t, p, v; /* at its end */
    shape_phase phases[SHAPE_PHASES];
} shape;

/* The soonest way from (v, a) to a velocity and acceleration 0, from any start. */
void shape_to_velocity(shape *s, const shape_bounds *b, double v, double a, double to);

/* The soonest way to a position at rest; the start is within the bounds, and so is what it leads to: v + a |a| / 2 j. */
void shape_to_position(shape *s, const shape_bounds *b, double v, double a, double distance);

/* The way to the farthest position, in direction 1 or -1, where the axis can be at rest at time t, which is not
   sooner than it can stop. */
void shape_farthest(shape *s, const shape_bounds *b, double v, double a, int direction, double t);

#endif
