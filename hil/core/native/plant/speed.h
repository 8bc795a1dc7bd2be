/* The speed of a shaft, one axis at a time, and its limit. */
#ifndef HIL_PLANT_SPEED_H
#define HIL_PLANT_SPEED_H

#include <math.h>

#include "../abi.h"

#define REAL_LANES 1
#include "real.h"
#undef REAL_LANES
#include "speed_kernel.h"

/* Beyond it the plants' steps do not resolve the coils: with one electrical turn in a step they would see a
   standing rotor. hil/core/axis_kind.py reckons the same in rpm. */
static inline double plant_limit_rev_per_s(int teeth) { return fmin(HIL_LIMIT_RPM, (double)HIL_LIMIT_TEETH_RPM / teeth) / 60; }

#endif
