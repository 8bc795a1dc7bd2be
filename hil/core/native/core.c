#include "core.h"

#include "hil_core.h"

int64_t hil_group_now(const hil_core *c, int group)
{
    return atomic_load_explicit(&c->groups[group].now_ns, memory_order_acquire);
}

void core_post(hil_core *c, int axis, int64_t at_ns, int kind, double value)
{
    hil_group *g = &c->groups[c->axes[axis].group];
    hil_event e = {.at_ns = at_ns, .axis = axis, .kind = kind, .value = value};
    if (!ring_put(&g->events, &e)) atomic_store_explicit(&g->failed, 1, memory_order_relaxed);
    /* What a board sends then may reach another one of its group: time waits until the firmware has run. */
    g->stops |= kind == HIL_EVENT_COMMAND_BEGUN || kind == HIL_EVENT_COMMAND_ENDED || kind >= HIL_EVENT_PULSES_ENDED;
}

/* Idle axes are left where they are, however many a group has: a plant at rest stands on the same grid of nodes
   whenever it is asked, and whoever asks names the time. */
void core_stir(hil_core *c, int axis)
{
    hil_axis *a = &c->axes[axis];
    hil_group *g = &c->groups[a->group];
    a->is_shown = 0;
    if (a->is_active) return;
    a->is_active = 1;
    a->next_active = g->first_active;
    g->first_active = axis;
}

void core_join(hil_core *c, int axis)
{
    hil_axis *a = &c->axes[axis];
    hil_group *g = &c->groups[a->group];
    if (a->is_joined) return;
    a->is_joined = 1;
    a->next_joined = g->first_joined;
    g->first_joined = axis;
}
