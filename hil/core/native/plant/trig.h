/* Sine and cosine for the plants. */
#ifndef HIL_PLANT_TRIG_H
#define HIL_PLANT_TRIG_H

#include <math.h>
#include <stdint.h>

static const double TWO_PI = 6.28318530717958647692;

/* sin and cos of an angle in turns, to about 1e-15, of plain operations only: the same bits on every
   machine, whatever its libm. From 2^50 turns on (a rotor that an absurd load has run away with) NaN. */
static inline void sincos_turns(double turns, double *s, double *c)
{
    if (!(fabs(turns) < 0x1p50)) {
        *s = *c = NAN;
        return;
    }
    int64_t quarter = (int64_t)(4 * turns + (turns < 0 ? -0.5 : 0.5));
    double x = (turns - (double)quarter * 0.25) * TWO_PI, xx = x * x; /* |x| <= pi/4 */
    double sine = x + x * xx * (-1.0 / 6 + xx * (1.0 / 120 + xx * (-1.0 / 5040 + xx * (1.0 / 362880 +
                  xx * (-1.0 / 39916800 + xx * (1.0 / 6227020800.0 + xx * (-1.0 / 1307674368000.0)))))));
    double cosine = 1 + xx * (-0.5 + xx * (1.0 / 24 + xx * (-1.0 / 720 + xx * (1.0 / 40320 +
                    xx * (-1.0 / 3628800 + xx * (1.0 / 479001600.0 + xx * (-1.0 / 87178291200.0)))))));
    switch (quarter & 3) {
    case 0: *s = sine; *c = cosine; break;
    case 1: *s = cosine; *c = -sine; break;
    case 2: *s = -sine; *c = -cosine; break;
    default: *s = -cosine; *c = sine; break;
    }
}

#endif
