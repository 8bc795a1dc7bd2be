/* Plans of motions over one or several axes, from states to positions, along a line, to velocities and to a stop. */
#ifndef HIL_MOTION_TRAJECTORY_H
#define HIL_MOTION_TRAJECTORY_H

#include "course.h"

/* The axes start together and end together, after duration_ns (TRAJ_SOONEST: when the slowest one can). Those that are
   not at rest at first take a mean of two extreme ways, and so up to 14 segments; the others seven. */
traj_error traj_joint(int axes, const traj_state *starts, const double *targets, const traj_limits *limits,
                      traj_kind kind, int64_t duration_ns, traj_profile *out, traj_fault *fault);

/* From rest to rest in a straight line. The path is in degrees of the axis that moves farthest. */
traj_error traj_line(int axes, const double *starts, const double *targets, const traj_limits *limits, traj_kind kind,
                     int64_t duration_ns, traj_profile *path, traj_profile *out, traj_fault *fault);

/* Each axis, from any start, as soon as it can to its velocity, and on with it. */
traj_error traj_velocity(int axes, const traj_state *starts, const double *velocities, const traj_limits *limits,
                         traj_kind kind, traj_profile *out, traj_fault *fault);

/* Stops what runs since at_ns ago: each axis as soon as it can, or with a path (of traj_line, or of a stop on its line;
   else NULL) along the line. */
traj_error traj_stop(int axes, const traj_profile *running, const traj_profile *path, int64_t at_ns,
                     const traj_limits *limits, traj_kind kind, traj_profile *out_path, traj_profile *out,
                     traj_fault *fault);

/* For what takes limits on trust: traj_violation, traj_fit. */
traj_error traj_check_limits(int axes, const traj_limits *limits, traj_kind kind, traj_fault *fault);

#endif
