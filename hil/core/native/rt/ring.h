/* A single-producer single-consumer ring of events. The producer is whoever owns the group; ownership
   is handed over with release/acquire, so there is one producer at a time. */
#ifndef HIL_RT_RING_H
#define HIL_RT_RING_H

#include <stdatomic.h>

#include "../types.h"

#define RING_LEN 1024 /* of 24 bytes, locked for each group; half full, the group waits: j posts 650 events in half a second */

typedef struct event_ring {
    _Atomic uint32_t head, tail; /* head: next to write, tail: next to read; both run on and wrap at 2^32 */
    hil_event slot[RING_LEN];
} event_ring;

static inline uint32_t ring_used(const event_ring *r)
{
    return atomic_load_explicit(&r->head, memory_order_relaxed) - atomic_load_explicit(&r->tail, memory_order_acquire);
}

static inline int ring_put(event_ring *r, const hil_event *e)
{
    if (ring_used(r) == RING_LEN) return 0;
    uint32_t head = atomic_load_explicit(&r->head, memory_order_relaxed);
    r->slot[head % RING_LEN] = *e;
    atomic_store_explicit(&r->head, head + 1, memory_order_release);
    return 1;
}

static inline int ring_take(event_ring *r, hil_event *out)
{
    uint32_t tail = atomic_load_explicit(&r->tail, memory_order_relaxed);
    if (tail == atomic_load_explicit(&r->head, memory_order_acquire)) return 0;
    *out = r->slot[tail % RING_LEN];
    atomic_store_explicit(&r->tail, tail + 1, memory_order_release);
    return 1;
}

#endif
