#include "watch.h"

#include <stdlib.h>

int64_t watch_soonest_ns(const watch *watches)
{
    int64_t next_ns = HIL_FOREVER;
    for (int i = 0; i < HIL_WATCHES; i++)
        if (watches[i].ring && watches[i].next_ns < next_ns) next_ns = watches[i].next_ns;
    return next_ns;
}

/* The grid's first point after now_ns; answers its number. */
static int64_t begin_grid(watch *w, int64_t now_ns, int64_t num_ns, int64_t den)
{
    __int128 k = (((__int128)now_ns + 1) * den + num_ns - 1) / num_ns, at_ns = k * num_ns / den;
    w->whole_ns = num_ns / den;
    w->part = num_ns % den;
    w->den = den;
    w->rest = (int64_t)(k * num_ns % den);
    w->next_ns = at_ns < HIL_FOREVER ? (int64_t)at_ns : HIL_FOREVER;
    return (int64_t)k;
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

int watch_start(watch *w, int64_t now_ns, int64_t num_ns, int64_t den, int points, int kind, const own_cells *own, int capacity)
{
    int is_pairs = num_ns && points > 1;
    hil_snapshot *ring = num_ns ? malloc((size_t)capacity * sizeof *ring) : NULL;
    extremes *seen = is_pairs ? malloc(sizeof *seen) : NULL;
    if ((num_ns && !ring) || (is_pairs && !seen)) {
        free(ring);
        free(seen);
        return -1;
    }
    free(w->ring);
    free(w->extremes);
    *w = (watch){.ring = ring, .extremes = seen, .capacity = capacity};
    int64_t k = num_ns ? begin_grid(w, now_ns, num_ns, den) : 0;
    if (seen) *seen = (extremes){.kind = kind, .own = own, .points = points, .left = points - (int)((k - 1) % points)};
    return 0;
}

/* Where the next sample goes; NULL: there is no room, it is lost. */
static hil_snapshot *room(watch *w)
{
    int64_t made = atomic_load_explicit(&w->made, memory_order_relaxed);
    int64_t waiting = made - atomic_load_explicit(&w->taken, memory_order_acquire);
    if (waiting == 0) w->first = made; /* memory beyond what ever waits is not touched */
    if (waiting < w->capacity) return &w->ring[(made - w->first) % w->capacity];
    atomic_fetch_add_explicit(&w->lost, 1, memory_order_relaxed);
    return NULL;
}

hil_snapshot *watch_place(watch *w, int64_t at_ns)
{
    if (!w->ring || w->next_ns != at_ns) return NULL;
    step_grid(w);
    return w->extremes ? &w->extremes->now : room(w);
}

/* Put the first or the last extreme of each field into the ring. */
static void put(watch *w, int is_last)
{
    const extremes *e = w->extremes;
    hil_snapshot *place = room(w);
    if (!place) return;
    *place = e->now;
    extremes_put(e, is_last, place);
    atomic_fetch_add_explicit(&w->made, 1, memory_order_release);
}

void watch_keep(watch *w)
{
    extremes *e = w->extremes;
    if (!e) {
        atomic_fetch_add_explicit(&w->made, 1, memory_order_release);
        return;
    }
    extremes_widen(e);
    if (--e->left) return;
    put(w, 0);
    put(w, 1);
    e->left = e->points;
    e->is_begun = 0;
}

int watch_take(watch *w, hil_snapshot *out, int max)
{
    int64_t taken = atomic_load_explicit(&w->taken, memory_order_relaxed);
    int64_t waiting = atomic_load_explicit(&w->made, memory_order_acquire) - taken;
    int n = waiting < max ? (int)waiting : max;
    for (int i = 0; i < n; i++) out[i] = w->ring[(taken + i - w->first) % w->capacity];
    atomic_store_explicit(&w->taken, taken + n, memory_order_release);
    return n;
}
