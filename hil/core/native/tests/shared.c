/* What several threads share without a lock: rt/ring.h and rt/seqlock.h, under the thread sanitizer. */
#define _GNU_SOURCE
#include <sched.h>
#include <signal.h>

#include "fixture.h"
#include "threads.h"

/* ---- the event ring ---- */

enum { EVENTS = 300000 };

static void *produce(void *argument)
{
    event_ring *r = argument;
    for (int i = 0; i < EVENTS;) {
        hil_event e = {.at_ns = i, .axis = i % 7, .kind = i % 3, .value = i * 0.5};
        if (ring_put(r, &e)) i++;
        else sched_yield();
    }
    return NULL;
}

static void ring_keeps_order(void)
{
    static hil_event slots[RING_MOST];
    static event_ring r = {.len = RING_MOST, .slot = slots};
    /* Starts a little before the counters wrap. */
    atomic_store(&r.head, UINT32_MAX - 1000);
    atomic_store(&r.tail, UINT32_MAX - 1000);
    pthread_t producer = spawn(produce, &r);
    hil_event e;
    for (int i = 0; i < EVENTS;) {
        if (!ring_take(&r, &e)) {
            sched_yield();
            continue;
        }
        CHECK(e.at_ns == i && e.axis == i % 7 && e.kind == i % 3 && e.value == i * 0.5);
        i++;
    }
    pthread_join(producer, NULL);
    CHECK_INT(ring_used(&r), 0);
}

/* ---- the sequence-locked value ---- */

enum { WORDS = 48 };

typedef struct shared_value {
    seqlock lock;
    _Atomic uint64_t words[WORDS];
    _Atomic int stop;
} shared_value;

static void *write_values(void *argument)
{
    shared_value *v = argument;
    uint64_t words[WORDS];
    for (uint64_t n = 1; !atomic_load(&v->stop); n++) {
        for (uint64_t i = 0; i < WORDS; i++) words[i] = n * (i + 1);
        seqlock_write(&v->lock, v->words, words, WORDS);
        if (n % 64 == 0) sched_yield();
    }
    return NULL;
}

/* Holds the writer up where the signal finds it, in the middle of a write most often. */
static void stall(int signal_number)
{
    (void)signal_number;
    for (int64_t end_ns = wall_ns() + 20000; wall_ns() < end_ns;) {
    }
}

static void seqlock_is_never_torn(void)
{
    static shared_value v;
    struct sigaction action = {.sa_handler = stall};
    sigaction(SIGUSR1, &action, NULL);
    pthread_t writer = spawn(write_values, &v);
    uint64_t words[WORDS], last = 0;
    for (int reads = 0; reads < 100000; reads++) {
        seqlock_read(&v.lock, v.words, words, WORDS);
        for (uint64_t i = 0; i < WORDS; i++) CHECK(words[i] == words[0] * (i + 1));
        CHECK(words[0] >= last);
        if (reads % 64 == 0) pthread_kill(writer, SIGUSR1);
        last = words[0];
    }
    atomic_store(&v.stop, 1);
    pthread_join(writer, NULL);
    CHECK(last > 0);
}

void shared_tests(void)
{
    RUN(ring_keeps_order);
    RUN(seqlock_is_never_torn);
}
