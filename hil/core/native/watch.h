/* Samples of an axis that is watched: a grid of times, and a ring for what is seen then, or for the extremes of it. */
#ifndef HIL_WATCH_H
#define HIL_WATCH_H

#include <stdatomic.h>

#include "extremes.h"
#include "types.h"

/* Whoever owns the axis's group makes the samples, the loop thread takes them without owning it. */
typedef struct watch {
    hil_snapshot *ring; /* NULL: nobody watches here */
    extremes *extremes; /* NULL: samples are what is seen */
    int capacity;
    int64_t first;                /* number of the sample at the ring's begin; changed while none waits */
    _Atomic int64_t made, taken;  /* numbers of the samples to come */
    int64_t whole_ns, part, den, rest; /* interval = whole + part / den; rest / den: what the floor of next_ns left out */
    int64_t next_ns;
    _Atomic int64_t lost;
} watch;

/* At each floor(k * num_ns / den) after now_ns, instead of the watch before; num_ns = 0 ends it. points above 1: a pair of
   samples at each k that is a multiple of it, for an axis of this kind with these cells, or NULL. -1: no memory. */
int watch_start(watch *w, int64_t now_ns, int64_t num_ns, int64_t den, int points, int kind, const own_cells *own, int capacity);
int64_t watch_soonest_ns(const watch *watches);      /* of HIL_WATCHES: of the sample to come, HIL_FOREVER: none */
hil_snapshot *watch_place(watch *w, int64_t at_ns); /* where what is seen at that time goes; NULL: nowhere */
void watch_keep(watch *w);                          /* it is there */
int watch_take(watch *w, hil_snapshot *out, int max); /* how many */

#endif
