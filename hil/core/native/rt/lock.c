#include "lock.h"

#include <errno.h>
#include <sys/mman.h>

#include "../law.h"

/* Only what is open: half of the slots are spare. */
int rt_lock_axis(const hil_core *c, int axis)
{
    const hil_axis *a = &c->axes[axis];
    return mlock(a, sizeof *a) || mlock(a->own, a->law->bytes) ? errno : 0;
}

int rt_lock_group(const hil_core *c, int group)
{
    const hil_group *g = &c->groups[group];
    return mlock(g, sizeof *g) || mlock(g->events.slot, g->events.len * sizeof *g->events.slot) ? errno : 0;
}
