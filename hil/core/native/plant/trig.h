/* Sine and cosine for the plants, one axis at a time. Of plain operations only: the same bits on every
   machine, whatever its libm. */
#ifndef HIL_PLANT_TRIG_H
#define HIL_PLANT_TRIG_H

#define REAL_LANES 1
#include "real.h"
#undef REAL_LANES
#include "trig_kernel.h"

#endif
