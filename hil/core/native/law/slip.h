/* Whether a rotor follows the currents of its driver, step by step: what has lost steps has stalled. */
#ifndef HIL_LAW_SLIP_H
#define HIL_LAW_SLIP_H

#include "../shaft.h"

typedef struct slip {
    double teeth_off;       /* how far the rotor is behind where it was told to be, in whole teeth */
    int64_t stalls, at_ns, last_ns; /* since power-up; at: of the latest, last: of the latest tooth that was lost */
} slip;

/* Beyond half a tooth, two full steps, the currents pull a rotor on to the next tooth: a quarter more is one that has gone.
   Teeth that are lost one after the other, as on the way to a stop, are one stall. */
#define SLIP_TEETH 0.75
#define SLIP_APART_NS 200000000

static inline double slip_now(const hil_axis *a, double commanded_rev, int teeth)
{
    return (commanded_rev - (a->is_full ? a->full.moving.state.rev : a->plant.moving.rev)) * teeth;
}

/* At a step of the driver; the plant is no more than a step of its own behind. */
static inline void slip_look(slip *s, const hil_axis *a, double commanded_rev, int teeth, int64_t at_ns)
{
    double off = slip_now(a, commanded_rev, teeth);
    if (fabs(off - s->teeth_off) <= SLIP_TEETH) return;
    if (s->stalls == 0 || at_ns - s->last_ns > SLIP_APART_NS) {
        s->stalls++;
        s->at_ns = at_ns;
    }
    s->last_ns = at_ns;
    s->teeth_off = nearbyint(off);
}

/* At a power-up: the rotor is where it is. */
static inline void slip_clear(slip *s, const hil_axis *a, double commanded_rev, int teeth)
{
    *s = (slip){.teeth_off = nearbyint(slip_now(a, commanded_rev, teeth))};
}

#endif
