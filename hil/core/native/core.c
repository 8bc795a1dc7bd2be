/* Cores and groups: who owns what, how far time has come, events. */
#define _GNU_SOURCE
#include <sched.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <unistd.h>

#include "core.h"

/* What one call of hil_group_advance does at the most: events and plant steps, each some 50 ns. It is looked at
   after each slice of simulated time, in which a board can do only so much. */
#define CALL_WORK 100000
#define SLICE_NS 4000000

static size_t round_up(size_t n) { return (n + 63) & ~(size_t)63; }

hil_core *hil_core_new(int max_axes, int *event_fd)
{
    if (max_axes < 1) return NULL;
    size_t axes_at = round_up(sizeof(hil_core)), groups_at = axes_at + round_up(sizeof(hil_axis) * (size_t)max_axes);
    size_t due_at = groups_at + round_up(sizeof(hil_group) * (size_t)max_axes), len = due_at + (size_t)max_axes;
    char *arena = mmap(NULL, len, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (arena == MAP_FAILED) return NULL;
    /* Refused, or too small an arena: only slower. Tables are 64 KiB apart, so with small pages each axis
       takes several translations for itself. */
    (void)madvise(arena, len, MADV_HUGEPAGE);
    hil_core *c = (hil_core *)arena;
    c->event_fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    if (c->event_fd < 0) {
        munmap(arena, len);
        return NULL;
    }
    c->arena_len = len;
    c->max_axes = max_axes;
    c->axes = (hil_axis *)(arena + axes_at);
    c->groups = (hil_group *)(arena + groups_at);
    c->due = (_Atomic uint8_t *)(arena + due_at);
    mechaduino_sine(c->sine);
    *event_fd = c->event_fd;
    return c;
}

void hil_core_free(hil_core *c)
{
    hil_rt_stop(c);
    for (int i = 0; i < c->max_axes; i++) {
        free(c->axes[i].encoder.script_ns);
        free(c->axes[i].source.rows);
        free(c->axes[i].follow.pieces);
        watch_end(&c->axes[i]);
        stepper_close(&c->axes[i]);
    }
    close(c->event_fd);
    munmap(c, c->arena_len);
}

int hil_group_open(hil_core *c, int64_t now_ns)
{
    int group = 0;
    while (group < c->max_axes && c->groups[group].open) group++;
    if (group == c->max_axes) return -1;
    hil_group *g = &c->groups[group];
    atomic_store(&g->owner, GROUP_LOOP_THREAD);
    atomic_store(&g->now_ns, now_ns);
    atomic_store(&g->failed, 0);
    g->stops = 0;
    atomic_store(&g->events.head, 0);
    atomic_store(&g->events.tail, 0);
    g->horizon_ns = now_ns; /* nothing runs before its firmware has said how far */
    g->reported = 1;
    g->open = 1;
    g->first_axis = g->first_active = -1;
    if (atomic_load(&c->rt.running)) (void)rt_lock_group(c, group); /* what was refused was said at the start */
    if (group >= atomic_load(&c->groups_used)) atomic_store(&c->groups_used, group + 1);
    return group;
}

void hil_group_close(hil_core *c, int group)
{
    hil_group *g = &c->groups[group];
    /* A closed group stays with the loop thread for good, so that the real-time thread, this one or the
       next, never enters it. It is free here if it was released before the thread stopped. */
    if (atomic_load(&g->owner) != GROUP_LOOP_THREAD) hil_group_acquire(c, group);
    for (int i = g->first_axis; i >= 0; i = c->axes[i].next_in_group) {
        hil_axis_script_encoder(c, i, 0, NULL, NULL, 0);
        hil_axis_drive(c, i, 0, NULL);
        hil_axis_follow(c, i, 0, 0, NULL);
        watch_end(&c->axes[i]);
        stepper_close(&c->axes[i]);
        c->axes[i].open = 0;
    }
    g->first_axis = g->first_active = -1;
    g->open = 0;
    atomic_store(&c->due[group], 0);
}

void core_post(hil_core *c, int axis, int64_t at_ns, int kind, double value)
{
    hil_group *g = &c->groups[c->axes[axis].group];
    hil_event e = {.at_ns = at_ns, .axis = axis, .kind = kind, .value = value};
    if (!ring_put(&g->events, &e)) atomic_store_explicit(&g->failed, 1, memory_order_relaxed);
    /* What a board sends then may reach another one of its group: time waits until the firmware has run. */
    g->stops |= kind == HIL_EVENT_COMMAND_BEGUN || kind == HIL_EVENT_COMMAND_ENDED;
}

/* Idle axes are left where they are, however many a group has: a plant at rest stands on the same grid of nodes
   whenever it is asked, and whoever asks names the time. */
void core_stir(hil_core *c, int axis)
{
    hil_axis *a = &c->axes[axis];
    hil_group *g = &c->groups[a->group];
    a->is_shown = 0;
    if (a->is_active) return;
    a->is_active = 1;
    a->next_active = g->first_active;
    g->first_active = axis;
}

/* How many steps the plant makes in so much time, about. */
static int64_t plant_work(const hil_axis *a, int64_t span_ns)
{
    if (a->is_full) return a->full.at_rest ? 0 : span_ns / a->full.step_ns;
    return a->plant.at_rest ? 0 : span_ns / a->plant.step_ns;
}

/* Answers how much that was. */
static int64_t run_active(hil_core *c, hil_group *g, int64_t span_ns, int64_t until_ns)
{
    int64_t work = 0;
    for (int *link = &g->first_active; *link >= 0;) {
        hil_axis *a = &c->axes[*link];
        work += 1 + plant_work(a, span_ns);
        work += axis_advance(c, a, *link, until_ns);
        a->is_active = !axis_is_idle(a);
        if (a->is_active) link = &a->next_active;
        else *link = a->next_active;
    }
    return work;
}

/* The axis to which something happens next, -1 when nothing does up to and at until_ns; *at_ns is when. Of
   several at the same time, the one that was opened first. */
static int next_axis(const hil_core *c, int group, int64_t until_ns, int64_t *at_ns)
{
    int next = -1;
    *at_ns = until_ns;
    for (int i = c->groups[group].first_active; i >= 0; i = c->axes[i].next_active) {
        int64_t axis_ns = axis_next_ns(&c->axes[i]);
        if (axis_ns > *at_ns || axis_ns == HIL_FOREVER) continue;
        if (next >= 0 && axis_ns == *at_ns && c->axes[next].order < c->axes[i].order) continue;
        next = i;
        *at_ns = axis_ns;
    }
    return next;
}

/* A group of one axis that will post no event. */
static int is_quiet(const hil_core *c, const hil_group *g, int64_t until_ns)
{
    if (g->first_axis < 0) return 1;
    const hil_axis *a = &c->axes[g->first_axis];
    if (a->stepper && a->stepper->is_reported) return 0;
    return a->next_in_group < 0 && !a->law.print_yw && a->source.next_ns > until_ns;
}

/* Whether events are waiting that time does not go past. */
static int has_to_wait(const hil_group *g) { return g->stops || ring_used(&g->events) >= RING_LEN / 2; }

/* Less far where events are waiting. */
static int64_t advance_slice(hil_core *c, int group, int64_t now_ns, int64_t until_ns, int64_t *work)
{
    hil_group *g = &c->groups[group];
    int64_t at_ns, span_ns = until_ns - now_ns;
    for (int axis; !is_quiet(c, g, until_ns) && (axis = next_axis(c, group, until_ns, &at_ns)) >= 0;) {
        *work += axis_advance(c, &c->axes[axis], axis, at_ns);
        if (has_to_wait(g)) until_ns = at_ns; /* what happens to the others at this time happens too */
    }
    *work += run_active(c, g, span_ns, until_ns);
    atomic_store_explicit(&g->now_ns, until_ns, memory_order_release);
    return until_ns;
}

/* Whoever asks for years gets them in parts: between two calls signals are heard, and others have their turn. */
int64_t hil_group_advance(hil_core *c, int group, int64_t until_ns)
{
    hil_group *g = &c->groups[group];
    int64_t now_ns = atomic_load_explicit(&g->now_ns, memory_order_relaxed);
    if (until_ns > g->horizon_ns) until_ns = g->horizon_ns;
    if (until_ns <= now_ns || ring_used(&g->events) >= (g->stops ? 1 : RING_LEN / 2)) return now_ns;
    g->stops = 0;
    for (int64_t work = 0; now_ns < until_ns && work < CALL_WORK && !has_to_wait(g);) {
        int is_short = until_ns - now_ns <= SLICE_NS || g->first_active < 0; /* nothing happens to idle axes */
        now_ns = advance_slice(c, group, now_ns, is_short ? until_ns : now_ns + SLICE_NS, &work);
    }
    return now_ns;
}

int64_t hil_group_now(const hil_core *c, int group)
{
    return atomic_load_explicit(&c->groups[group].now_ns, memory_order_acquire);
}

void hil_group_set_horizon(hil_core *c, int group, int64_t horizon_ns)
{
    c->groups[group].horizon_ns = horizon_ns;
    c->groups[group].reported = 0;
}

int hil_group_failed(const hil_core *c, int group)
{
    return atomic_load_explicit(&c->groups[group].failed, memory_order_relaxed);
}

int hil_group_has_news(const hil_core *c, int group)
{
    return ring_used(&c->groups[group].events) > 0 || hil_group_failed(c, group);
}

int hil_group_take_event(hil_core *c, int group, hil_event *out) { return ring_take(&c->groups[group].events, out); }

void hil_group_acquire(hil_core *c, int group)
{
    int free_group = GROUP_FREE;
    while (!atomic_compare_exchange_weak_explicit(&c->groups[group].owner, &free_group, GROUP_LOOP_THREAD,
                                                  memory_order_acquire, memory_order_relaxed)) {
        free_group = GROUP_FREE;
        sched_yield();
    }
}

void group_publish(hil_core *c, int group)
{
    hil_group *g = &c->groups[group];
    g->published_ns = atomic_load_explicit(&g->now_ns, memory_order_relaxed);
    for (int i = g->first_axis; i >= 0; i = c->axes[i].next_in_group) axis_publish(&c->axes[i], g->published_ns);
}

void hil_group_release(hil_core *c, int group)
{
    group_publish(c, group);
    atomic_store_explicit(&c->groups[group].owner, GROUP_FREE, memory_order_release);
}
