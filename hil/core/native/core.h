/* What axes ask of their core: the time of their group, to be moved again, and to tell events. */
#ifndef HIL_CORE_PRIVATE_H
#define HIL_CORE_PRIVATE_H

#include "state.h"

void core_stir(hil_core *c, int axis); /* before anything is done to it: it may be idle no more */
void core_join(hil_core *c, int axis); /* what it does may do something to another axis, or the other way round */
void core_post(hil_core *c, int axis, int64_t at_ns, int kind, double value);

/* *now_ns: its group's time. */
static inline hil_axis *core_axis(hil_core *c, int axis, int64_t *now_ns)
{
    hil_axis *a = &c->axes[axis];
    *now_ns = atomic_load_explicit(&c->groups[a->group].now_ns, memory_order_relaxed);
    return a;
}

/* For what changes it. */
static inline hil_axis *core_axis_stirred(hil_core *c, int axis, int64_t *now_ns)
{
    core_stir(c, axis);
    return core_axis(c, axis, now_ns);
}

#endif
