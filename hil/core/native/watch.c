/* Samples of an axis, for those who draw or record: each watch has a grid and a ring of its own. */
#include <stdlib.h>
#include <string.h>

#include "core.h"

static void find_next(hil_axis *a)
{
    a->watch_next_ns = HIL_FOREVER;
    for (int i = 0; i < HIL_WATCHES; i++)
        if (a->watches[i].ring && a->watches[i].next_ns < a->watch_next_ns) a->watch_next_ns = a->watches[i].next_ns;
}

/* The grid's first point after now_ns. */
static void begin_grid(watch *w, int64_t now_ns, int64_t num_ns, int64_t den)
{
    __int128 k = (((__int128)now_ns + 1) * den + num_ns - 1) / num_ns, at_ns = k * num_ns / den;
    w->whole_ns = num_ns / den;
    w->part = num_ns % den;
    w->den = den;
    w->rest = (int64_t)(k * num_ns % den);
    w->next_ns = at_ns < HIL_FOREVER ? (int64_t)at_ns : HIL_FOREVER;
}

static void step_grid(watch *w)
{
    if (w->next_ns > HIL_FOREVER - w->whole_ns - 1) {
        w->next_ns = HIL_FOREVER;
        return;
    }
    w->next_ns += w->whole_ns;
    w->rest += w->part;
    if (w->rest < w->den) return;
    w->rest -= w->den;
    w->next_ns++;
}

int hil_axis_watch(hil_core *c, int axis, int slot, int64_t num_ns, int64_t den, int capacity)
{
    hil_axis *a = &c->axes[axis];
    watch *w = &a->watches[slot];
    hil_snapshot *ring = num_ns ? malloc((size_t)capacity * sizeof *ring) : NULL;
    if (num_ns && !ring) return -1;
    free(w->ring);
    *w = (watch){.ring = ring, .capacity = capacity};
    core_stir(c, axis);
    if (num_ns) begin_grid(w, hil_group_now(c, a->group), num_ns, den);
    find_next(a);
    return 0;
}

void watch_end(hil_axis *a)
{
    for (int i = 0; i < HIL_WATCHES; i++) {
        free(a->watches[i].ring);
        a->watches[i] = (watch){.ring = NULL};
    }
    a->watch_next_ns = HIL_FOREVER;
}

void watch_sample(hil_axis *a)
{
    int64_t at_ns = a->watch_next_ns;
    for (int i = 0; i < HIL_WATCHES; i++) {
        watch *w = &a->watches[i];
        if (!w->ring || w->next_ns != at_ns) continue;
        step_grid(w);
        if (w->len == w->capacity) w->lost++;
        else axis_fill(a, at_ns, &w->ring[(w->first + w->len++) % w->capacity]);
    }
    find_next(a);
}

int hil_axis_take_samples(hil_core *c, int axis, int slot, hil_snapshot *out, int max)
{
    watch *w = &c->axes[axis].watches[slot];
    int n = 0;
    for (; n < max && w->len > 0; n++, w->len--) {
        out[n] = w->ring[w->first];
        w->first = (w->first + 1) % w->capacity;
    }
    return n;
}

int64_t hil_axis_lost_samples(const hil_core *c, int axis, int slot) { return c->axes[axis].watches[slot].lost; }
