/* What plans are made of, profiles of segments of constant jerk; what a profile does at a time, how it stands to limits,
   and the same in other time.

   Positions are in degrees (or any other unit, the same throughout an axis), their derivatives by seconds. Memory is
   the caller's: every traj_profile is handed in with room for its segments. Every answer is the same to the bit on
   every machine. docs/decisions/0013-trajectories.md says why it is done so. */
#ifndef HIL_MOTION_COURSE_H
#define HIL_MOTION_COURSE_H

#include <stdint.h>

#define TRAJ_AXES 64
#define TRAJ_SEGMENTS 16  /* room that any plan but a spline fits in; a spline of n points takes n + 1 */
#define TRAJ_TOLERANCE 1e-9 /* of a limit: what rounding may exceed it by */
#define TRAJ_LONGEST_S 3.2e9 /* 101 years; 2^63 ns are 292 */
#define TRAJ_SOONEST INT64_MIN /* as a duration */

typedef enum traj_error {
    TRAJ_OK,
    TRAJ_NOT_FINITE,          /* an input is infinite or not a number */
    TRAJ_LIMIT_NOT_POSITIVE,
    TRAJ_NO_AXES,
    TRAJ_TOO_MANY_AXES,       /* more than TRAJ_AXES */
    TRAJ_START_BEYOND_LIMITS, /* at once, or later, when the acceleration has been brought to 0 */
    TRAJ_TARGET_BEYOND_LIMIT, /* a velocity */
    TRAJ_TOO_SHORT,           /* the duration asked for; the fault says the least */
    TRAJ_TOO_FEW_POINTS,      /* of a spline: two are needed */
    TRAJ_POINTS_OUT_OF_ORDER, /* each needs a later time than the one before it */
    TRAJ_NO_ROOM,             /* for the segments */
    TRAJ_OUT_OF_RANGE,        /* the numbers are too far apart: some result overflows, or takes over 100 years */
} traj_error;

typedef enum traj_kind { TRAJ_TRAPEZOID, TRAJ_S_CURVE } traj_kind;

typedef struct traj_limits {
    double velocity, acceleration, jerk; /* all above 0; a trapezoid has no limit of jerk */
} traj_limits;

typedef struct traj_state {
    double position, velocity, acceleration; /* a trapezoid starts with any acceleration */
} traj_state;

typedef struct traj_segment {
    double t, length;  /* when it starts, in seconds from the start of the profile; how long it is */
    double p, v, a, j; /* there; p from the start's position */
} traj_segment;

typedef struct traj_profile {
    traj_segment *segments; /* the caller's, with `room` */
    int room, count;
    double from, to;        /* positions at start and end, exact */
    double start_v, end_v;
    double duration;        /* s */
    int64_t duration_ns;    /* rounded up; from there on the axis is exactly at `to`, or goes on at end_v */
    double slope;           /* on a line: degrees of this axis for one of the path */
} traj_profile;

typedef struct traj_fault {
    int axis;               /* of the error; -1: of none */
    int64_t least_ns;       /* TRAJ_TOO_SHORT */
} traj_fault;

traj_state traj_at(const traj_profile *profile, int64_t at_ns);

typedef enum traj_quantity { TRAJ_VELOCITY, TRAJ_ACCELERATION, TRAJ_JERK } traj_quantity;

typedef struct traj_violation_found {
    int axis;
    traj_quantity quantity;
    int64_t at_ns;
    double value, limit; /* the value has a sign */
} traj_violation_found;

/* The first end or turning point of a segment where a limit is exceeded by more than TRAJ_TOLERANCE; 0: none. */
int traj_violation(int axes, const traj_profile *profiles, const traj_limits *limits, traj_kind kind,
                   traj_violation_found *found);

/* By what to multiply the time so that the axes just keep their limits: above 1 if they do not, 0 if nothing moves. */
double traj_fit(int axes, const traj_profile *profiles, const traj_limits *limits, traj_kind kind);

/* The same way in `factor` times the time. The profile must start at rest with acceleration 0 to go on smoothly. */
traj_error traj_stretch(traj_profile *profile, double factor);

/* For whoever has laid segments: sets duration and duration_ns. */
traj_error traj_set_duration(traj_profile *profile, double duration);

#endif
