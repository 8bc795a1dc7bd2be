/* A driver that steps by its pins: the translator, the pins and the heat of an Allegro A3967, with the currents that its
   outputs have in a motor. Data sheet 26184.24F; what it leaves open: device_profiles/easydriver/README.md */
#ifndef HIL_LAW_A3967_H
#define HIL_LAW_A3967_H

#include "../law.h"
#include "heat.h"
#include "slip.h"

typedef struct a3967 {
    int teeth;
    double trip_A, fast_decay, fall_a, fall_b; /* parts of the supply, 0 to 1; fall: of the present step, full.h */
    double origin_rev; /* the shaft's angle where the position is 0 */
    int32_t pins[HIL_DRIVER_INPUTS];
    int64_t position;   /* of the translator, in eighths of a full step, turns of its cycle included */
    int64_t before_rise; /* the position before the latest step, which a pulse that is too short takes back */
    int is_step_high;   /* the latest rise was a step */
    int64_t taken, taken_before, ignored, timing_errors;
    int64_t rise_ns, fall_ns, changed_ns, awake_ns; /* changed: DIR, MS1 or MS2; awake: when STEP is heard after SLEEP */
    heat heat;
    slip slip;
} a3967;

extern const law a3967_law;

/* NULL: the axis has another law. */
static inline a3967 *driver_of(const hil_axis *a) { return a->law == &a3967_law ? a->own : NULL; }

const a3967 *driver_view(const hil_axis *a); /* of another law: all zeros */
int driver_resolution(const a3967 *d);
int driver_is_on(const a3967 *d);
double driver_commanded_rev(const a3967 *d);

static inline int driver_index(const a3967 *d) { return (int)(d->position & 31); }

#endif
