/* A plan of one axis through points at times. */
#ifndef HIL_MOTION_SPLINE_H
#define HIL_MOTION_SPLINE_H

#include "course.h"

/* One axis through points at times, at rest with acceleration 0 at both ends, with continuous acceleration. It knows no
   limits: see course.h: traj_violation, traj_fit. The start is at times_ns[0]. */
traj_error traj_spline(int points, const int64_t *times_ns, const double *positions, traj_profile *out);

#endif
