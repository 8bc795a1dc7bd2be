/* A single-producer single-consumer ring of events. The producer is whoever owns the group; ownership
   is handed over with release/acquire, so there is one producer at a time. */
#ifndef HIL_RT_RING_H
#define HIL_RT_RING_H

#include <stdatomic.h>

#include "../types.h"

/* Events of 24 bytes, locked for each group: as many as its laws want. Powers of two. */
enum { RING_LEAST = 64, RING_MOST = 1024 };

typedef struct event_ring {
    _Atomic uint32_t head, tail; /* head: next to write, tail: next to read; both run on and wrap at 2^32 */
    uint32_t len;                /* changed by who is producer and consumer at once */
    hil_event *slot;
} event_ring;

static inline uint32_t ring_used(const event_ring *r)
{
    return atomic_load_explicit(&r->head, memory_order_relaxed) - atomic_load_explicit(&r->tail, memory_order_acquire);
}

/* Half full, a group waits. */
static inline int ring_is_filling(const event_ring *r) { return ring_used(r) >= r->len / 2; }

static inline int ring_put(event_ring *r, const hil_event *e)
{
    if (ring_used(r) == r->len) return 0;
    uint32_t head = atomic_load_explicit(&r->head, memory_order_relaxed);
    r->slot[head & (r->len - 1)] = *e;
    atomic_store_explicit(&r->head, head + 1, memory_order_release);
    return 1;
}

static inline int ring_take(event_ring *r, hil_event *out)
{
    uint32_t tail = atomic_load_explicit(&r->tail, memory_order_relaxed);
    if (tail == atomic_load_explicit(&r->head, memory_order_acquire)) return 0;
    *out = r->slot[tail & (r->len - 1)];
    atomic_store_explicit(&r->tail, tail + 1, memory_order_release);
    return 1;
}

/* Room for at least so many, or for RING_MOST; what waits stays. */
static inline void ring_grow(event_ring *r, uint32_t len)
{
    uint32_t before = r->len, head = atomic_load_explicit(&r->head, memory_order_relaxed);
    while (r->len < len && r->len < RING_MOST) r->len *= 2;
    /* An event stays where it is, or goes beyond all that were there. */
    for (uint32_t at = head - ring_used(r); at != head; at++) r->slot[at & (r->len - 1)] = r->slot[at & (before - 1)];
}

#endif
