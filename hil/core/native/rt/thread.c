/* The real-time thread: wakes at a fixed rate and takes every free group to the wall's time. */
#define _GNU_SOURCE
#include <errno.h>
#include <link.h>
#include <math.h>
#include <sched.h>
#include <signal.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include "../batch.h"
#include "../group.h"
#include "../hil_core.h"
#include "lock.h"

#ifndef STACK_LEN /* the thread sanitizer needs more */
#define STACK_LEN (256 * 1024)
#endif
/* A wake that works longer leaves the rest to the next one, so that a core that has fallen far behind
   (a stopped process) does not take its CPU for long at a FIFO priority. */
#define BUDGET_NS 20000000
#define REST_NS 5000000   /* left to others after such a wake */
#define SLICE_NS 10000000 /* of simulated time, between two looks at the budget */
/* Snapshots are for people and for status: a group's is written so often, each in turn, and where it stops. */
#define PUBLISH_NS 20000000
#define STATS_WORDS ((int)(sizeof(hil_rt_stats) / 8))

static int64_t monotonic_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

/* Stops at half of what an int64_t holds (146 years), so that times a step later still fit. */
static int64_t sim_ns(const rt_state *rt, int64_t wall_ns)
{
    int64_t elapsed = wall_ns - rt->anchor_ns;
    if (rt->options.speed == 1.0) return rt->begin_ns + elapsed;
    double sim = (double)elapsed * rt->options.speed;
    return sim < 0x1p62 - (double)rt->begin_ns ? rt->begin_ns + (int64_t)sim : INT64_C(1) << 62;
}

int64_t hil_rt_now(const hil_core *c) { return sim_ns(&c->rt, monotonic_ns()); }

static int bucket(int64_t ns)
{
    if (ns < 8) return ns < 0 ? 0 : (int)ns;
    int octave = 60 - __builtin_clzll((unsigned long long)ns); /* of 8 to 15: 0 */
    int b = 8 * octave + (int)(ns >> octave);
    return b < HIL_HISTOGRAM_LEN ? b : HIL_HISTOGRAM_LEN - 1;
}

static void publish_stats(rt_state *rt)
{
    uint64_t words[STATS_WORDS];
    memcpy(words, &rt->live, sizeof rt->live);
    seqlock_write(&rt->stats_lock, rt->stats, words, STATS_WORDS);
}

void hil_rt_stats_read(const hil_core *c, hil_rt_stats *out)
{
    uint64_t words[STATS_WORDS];
    seqlock_read(&c->rt.stats_lock, c->rt.stats, words, STATS_WORDS);
    memcpy(out, words, sizeof *out);
    out->running = atomic_load(&((hil_core *)c)->rt.running);
}

static int enter(hil_group *g)
{
    int free_group = GROUP_FREE;
    return atomic_compare_exchange_strong_explicit(&g->owner, &free_group, GROUP_RT_THREAD, memory_order_acquire,
                                                   memory_order_relaxed);
}

/* Returns 1 when the loop thread has something to do in this group. It is told before the group is
   released: whoever closes the group then finds the last word already said. */
static int leave(hil_core *c, int group)
{
    hil_group *g = &c->groups[group];
    int tell = ring_used(&g->events) > 0;
    int64_t now_ns = hil_group_now(c, group), turns = PUBLISH_NS / c->rt.options.period_ns;
    int stopped = now_ns >= g->horizon_ns;
    if (stopped && !g->reported) tell = g->reported = 1;
    int its_turn = turns < 1 || (c->rt.wakes + group) % turns == 0;
    if (its_turn || (stopped && g->published_ns != now_ns)) group_publish(c, group);
    if (tell) atomic_store_explicit(&c->due[group], 1, memory_order_release);
    atomic_store_explicit(&g->owner, GROUP_FREE, memory_order_release);
    return tell;
}

/* Groups that this thread is in. Those behind come first, in slices. */
static void run_groups(hil_core *c, const int *groups, int n, int64_t target_ns, int64_t give_up_ns)
{
    int64_t slice_ns = target_ns;
    for (int i = 0; i < n; i++) {
        int64_t now_ns = hil_group_now(c, groups[i]);
        if (now_ns < slice_ns && now_ns < c->groups[groups[i]].horizon_ns) slice_ns = now_ns;
    }
    do {
        slice_ns = target_ns - slice_ns > SLICE_NS ? slice_ns + SLICE_NS : target_ns;
        batch_advance(c, groups, n, slice_ns);
    } while (slice_ns < target_ns && monotonic_ns() < give_up_ns);
}

/* Returns 1 when the budget ran out; the next wake then begins with the group after the last one. */
static int wake(hil_core *c)
{
    int64_t started_ns = monotonic_ns(), target_ns = sim_ns(&c->rt, started_ns), give_up_ns = started_ns + BUDGET_NS;
    int tell = 0, overrun = 0, groups = atomic_load_explicit(&c->groups_used, memory_order_acquire);
    for (int i = 0; i < groups && !overrun;) {
        int entered[BATCH_GROUPS], n = 0;
        for (int k = 0; k < BATCH_GROUPS; k++) __builtin_prefetch(&c->groups[(c->rt.next_group + k) % groups], 1);
        for (; i < groups && n < BATCH_GROUPS; i++) {
            int group = c->rt.next_group;
            c->rt.next_group = (group + 1) % groups;
            /* Not entered: the loop thread has it, and catches it up itself. */
            if (enter(&c->groups[group])) entered[n++] = group;
        }
        run_groups(c, entered, n, target_ns, give_up_ns);
        for (int k = 0; k < n; k++) tell |= leave(c, entered[k]);
        overrun = monotonic_ns() >= give_up_ns;
    }
    c->rt.wakes++;
    if (tell) {
        uint64_t one = 1;
        /* Full only after 2^64 wakes: nothing to handle. */
        ssize_t put = write(c->event_fd, &one, sizeof one);
        (void)put;
    }
    return overrun;
}

static int pin(int cpu)
{
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(cpu, &set);
    return sched_setaffinity(0, sizeof set, &set) ? errno : 0;
}

static void *run(void *argument)
{
    hil_core *c = argument;
    rt_state *rt = &c->rt;
    struct sched_param fifo = {.sched_priority = rt->options.priority};
    rt->live.fifo_errno = pthread_setschedparam(pthread_self(), SCHED_FIFO, &fifo);
    if (rt->options.cpu >= 0) rt->live.pin_errno = pin(rt->options.cpu);
    publish_stats(rt);
    atomic_store(&rt->running, 1);
    int64_t period_ns = rt->options.period_ns, done = 0, k = 1; /* periods accounted for, period to wake at */
    while (!atomic_load_explicit(&rt->stop, memory_order_relaxed)) {
        int64_t deadline_ns = rt->anchor_ns + k * period_ns;
        struct timespec t = {.tv_sec = deadline_ns / 1000000000, .tv_nsec = deadline_ns % 1000000000};
        while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL) == EINTR) {
        }
        int64_t now_ns = monotonic_ns(), n = (now_ns - rt->anchor_ns) / period_ns;
        rt->live.wake_latency[bucket(now_ns - deadline_ns)]++;
        rt->live.latency_total_ns += now_ns - deadline_ns;
        if (now_ns - deadline_ns > rt->live.longest_latency_ns) rt->live.longest_latency_ns = now_ns - deadline_ns;
        rt->live.ticks++;
        rt->live.missed += n - done - 1;
        rt->live.elapsed_ns = now_ns - rt->anchor_ns;
        done = n;
        k = n + 1;
        if (wake(c)) {
            rt->live.overruns++;
            k = (monotonic_ns() + REST_NS - rt->anchor_ns) / period_ns + 1;
        }
        publish_stats(rt);
    }
    return NULL;
}

typedef struct lock_result {
    int error, object;
} lock_result;

/* The text and data that the thread runs: this extension (or test program), libc and libm. */
static int lock_object(struct dl_phdr_info *info, size_t size, void *argument)
{
    (void)size;
    lock_result *result = argument;
    const char *name = info->dlpi_name;
    int ours = 0;
    for (int i = 0; i < info->dlpi_phnum; i++) {
        const ElfW(Phdr) *p = &info->dlpi_phdr[i];
        uintptr_t from = info->dlpi_addr + p->p_vaddr;
        if (p->p_type == PT_LOAD && (uintptr_t)&lock_object - from < p->p_memsz) ours = 1;
    }
    if (!ours && !strstr(name, "/libc.so") && !strstr(name, "/libm.so")) return 0;
    for (int i = 0; i < info->dlpi_phnum; i++) {
        const ElfW(Phdr) *p = &info->dlpi_phdr[i];
        if (p->p_type == PT_LOAD && mlock((void *)(info->dlpi_addr + p->p_vaddr), p->p_memsz) && !result->error)
            result->error = errno;
    }
    return 0;
}

static int lock_memory(hil_core *c)
{
    lock_result result = {0, 0};
    if (mlock(c, sizeof *c) || mlock(c->due, (size_t)c->max_axes) || mlock(c->rt.stack, c->rt.stack_len)) return errno;
    for (int i = 0; i < c->max_axes && !result.error; i++) {
        if (c->axes[i].open) result.error = rt_lock_axis(c, i);
        if (c->groups[i].open && !result.error) result.error = rt_lock_group(c, i);
    }
    if (!result.error) dl_iterate_phdr(lock_object, &result);
    return result.error;
}

/* No signal is handled in it: they are the other threads'. */
static int spawn(hil_core *c)
{
    rt_state *rt = &c->rt;
    pthread_attr_t attr;
    int error = pthread_attr_init(&attr);
    if (error) return error;
    pthread_attr_setstack(&attr, rt->stack, rt->stack_len);
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    error = pthread_create(&rt->thread, &attr, run, c);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    pthread_attr_destroy(&attr);
    return error;
}

/* Time goes on from where it was left, or from where groups were taken without the thread. */
static void begin(hil_core *c)
{
    for (int i = 0; i < atomic_load(&c->groups_used); i++)
        if (c->groups[i].open && hil_group_now(c, i) > c->rt.begin_ns) c->rt.begin_ns = hil_group_now(c, i);
}

int hil_rt_start(hil_core *c, const hil_rt_options *options)
{
    rt_state *rt = &c->rt;
    if (atomic_load(&rt->running)) return EALREADY;
    if (options->period_ns < 1 || options->period_ns > 1000000000 || !(options->speed >= 0)) return EINVAL;
    rt->stack = mmap(NULL, STACK_LEN, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_STACK, -1, 0);
    if (rt->stack == MAP_FAILED) return errno;
    rt->stack_len = STACK_LEN;
    rt->options = *options;
    memset(&rt->live, 0, sizeof rt->live);
    rt->live.lock_errno = lock_memory(c);
    /* Not before: to lock the memory takes its time, and no period is missed by it. */
    begin(c);
    rt->anchor_ns = monotonic_ns();
    atomic_store(&rt->stop, 0);
    int error = spawn(c);
    if (error) {
        munmap(rt->stack, rt->stack_len);
        return error;
    }
    while (!atomic_load(&rt->running)) sched_yield(); /* the stats now say what was refused */
    return 0;
}

void hil_rt_stop(hil_core *c)
{
    rt_state *rt = &c->rt;
    if (!atomic_load(&rt->running)) return;
    atomic_store(&rt->stop, 1);
    pthread_join(rt->thread, NULL);
    rt->begin_ns = hil_rt_now(c);
    rt->anchor_ns = monotonic_ns();
    munmap(rt->stack, rt->stack_len);
    atomic_store(&rt->running, 0);
}

int hil_rt_take_due(hil_core *c, int *groups, int max)
{
    uint64_t count;
    ssize_t got = read(c->event_fd, &count, sizeof count); /* clears it; empty is fine */
    (void)got;
    int n = 0;
    for (int group = 0; group < atomic_load(&c->groups_used) && n < max; group++)
        if (atomic_exchange_explicit(&c->due[group], 0, memory_order_acquire)) groups[n++] = group;
    return n;
}
