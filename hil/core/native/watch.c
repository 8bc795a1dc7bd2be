/* Samples of an axis, for those who draw or record. */
#include <stdlib.h>
#include <string.h>

#include "core.h"

int hil_axis_watch(hil_core *c, int axis, int64_t interval_ns, int capacity)
{
    hil_axis *a = &c->axes[axis];
    hil_snapshot *ring = interval_ns ? malloc((size_t)capacity * sizeof *ring) : NULL;
    if (interval_ns && !ring) return -1;
    free(a->watch.ring);
    a->watch = (watch){.ring = ring, .capacity = capacity, .interval_ns = interval_ns, .next_ns = HIL_FOREVER};
    int64_t now_ns = hil_group_now(c, a->group);
    core_stir(c, axis);
    if (interval_ns) a->watch.next_ns = (now_ns / interval_ns + 1) * interval_ns;
    return 0;
}

void watch_sample(hil_axis *a)
{
    watch *w = &a->watch;
    int64_t at_ns = w->next_ns;
    w->next_ns += w->interval_ns;
    if (w->len == w->capacity) {
        w->lost++;
        return;
    }
    axis_fill(a, at_ns, &w->ring[(w->first + w->len++) % w->capacity]);
}

int hil_axis_take_samples(hil_core *c, int axis, hil_snapshot *out, int max)
{
    watch *w = &c->axes[axis].watch;
    int n = 0;
    for (; n < max && w->len > 0; n++, w->len--) {
        out[n] = w->ring[w->first];
        w->first = (w->first + 1) % w->capacity;
    }
    return n;
}

int64_t hil_axis_lost_samples(const hil_core *c, int axis) { return c->axes[axis].watch.lost; }
