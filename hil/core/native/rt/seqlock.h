/* A sequence-locked latest value: the writer never waits, a reader copies until it gets an untorn one.
   The payload is copied as relaxed atomic words, so that the race is one the memory model allows. */
#ifndef HIL_RT_SEQLOCK_H
#define HIL_RT_SEQLOCK_H

#include <stdatomic.h>
#include <stdint.h>

typedef _Atomic uint32_t seqlock;

static inline void seqlock_write(seqlock *lock, _Atomic uint64_t *words, const uint64_t *from, int n)
{
    uint32_t s = atomic_load_explicit(lock, memory_order_relaxed);
    atomic_store_explicit(lock, s + 1, memory_order_relaxed);
    /* No word may be seen before the odd number is. */
    atomic_thread_fence(memory_order_release);
    for (int i = 0; i < n; i++) atomic_store_explicit(&words[i], from[i], memory_order_relaxed);
    atomic_store_explicit(lock, s + 2, memory_order_release);
}

static inline void seqlock_read(const seqlock *lock, const _Atomic uint64_t *words, uint64_t *to, int n)
{
    uint32_t before, after;
    do {
        before = atomic_load_explicit((seqlock *)lock, memory_order_acquire);
        for (int i = 0; i < n; i++) to[i] = atomic_load_explicit((_Atomic uint64_t *)&words[i], memory_order_relaxed);
        /* Nor may the second look be before the words. */
        atomic_thread_fence(memory_order_acquire);
        after = atomic_load_explicit((seqlock *)lock, memory_order_relaxed);
    } while (before != after || (before & 1));
}

#endif
