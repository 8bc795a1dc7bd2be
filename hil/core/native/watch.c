#include "watch.h"

#include <stdlib.h>

int64_t watch_soonest_ns(const watch *watches)
{
    int64_t next_ns = HIL_FOREVER;
    for (int i = 0; i < HIL_WATCHES; i++)
        if (watches[i].ring && watches[i].next_ns < next_ns) next_ns = watches[i].next_ns;
    return next_ns;
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

int watch_start(watch *w, int64_t now_ns, int64_t num_ns, int64_t den, int capacity)
{
    hil_snapshot *ring = num_ns ? malloc((size_t)capacity * sizeof *ring) : NULL;
    if (num_ns && !ring) return -1;
    free(w->ring);
    *w = (watch){.ring = ring, .capacity = capacity};
    if (num_ns) begin_grid(w, now_ns, num_ns, den);
    return 0;
}

hil_snapshot *watch_place(watch *w, int64_t at_ns)
{
    if (!w->ring || w->next_ns != at_ns) return NULL;
    step_grid(w);
    if (w->len < w->capacity) return &w->ring[(w->first + w->len++) % w->capacity];
    w->lost++;
    return NULL;
}

int watch_take(watch *w, hil_snapshot *out, int max)
{
    int n = 0;
    for (; n < max && w->len > 0; n++, w->len--) {
        out[n] = w->ring[w->first];
        w->first = (w->first + 1) % w->capacity;
    }
    return n;
}
