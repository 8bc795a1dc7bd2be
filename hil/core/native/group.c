/* Groups: who owns what, how far time has come, events. */
#include "group.h"

#include <sched.h>

#include "axis.h"
#include "hil_core.h"
#include "law.h"
#include "rt/lock.h"
#include "view.h"

/* What one call of hil_group_advance does at the most: events and plant steps, each some 50 ns. It is looked at
   after each slice of simulated time, in which a board can do only so much. */
#define CALL_WORK 100000
#define SLICE_NS 4000000
#define MOST_NS 100000000 /* where it is not looked at */

/* How far one processor goes ahead of the others of its group: less than a character of a line at 1 Mbaud takes from its
   beginning to where a program can know of it. A cycle, where they are wired. */
#define AHEAD_NS 8000
#define AHEAD_WIRED_NS 62

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
    g->events.len = RING_LEAST;
    g->events.slot = c->events + (size_t)group * RING_MOST;
    g->horizon_ns = now_ns; /* nothing runs before its firmware has said how far */
    g->reported = 1;
    g->open = 1;
    g->first_axis = g->first_active = g->first_joined = -1;
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
    for (int i = g->first_axis; i >= 0; i = c->axes[i].next_in_group) axis_close(&c->axes[i]);
    g->first_axis = g->first_active = g->first_joined = -1;
    g->open = 0;
    atomic_store(&c->due[group], 0);
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

/* Axes that time has to be kept with, because they tell events or do something to others: all that are joined, and
   those that tell something up to until_ns. */
static void find_bound(hil_core *c, hil_group *g, int64_t until_ns)
{
    int *link = &g->first_bound;
    for (int i = g->first_joined; i >= 0; i = c->axes[i].next_joined) {
        *link = i;
        link = &c->axes[i].next_bound;
    }
    for (int i = g->first_active; i >= 0; i = c->axes[i].next_active) {
        hil_axis *a = &c->axes[i];
        if (a->is_joined || !(a->is_telling || a->source.next_ns <= until_ns)) continue;
        *link = i;
        link = &a->next_bound;
    }
    *link = -1;
}

/* The bound axis, no processor, that others could hear of next, -1 when they hear of none up to and at until_ns; *at_ns is when, at the
   earliest. Of several at the same time, the one that was opened first. */
static int next_bound(const hil_core *c, const hil_group *g, int64_t until_ns, int64_t *at_ns)
{
    int next = -1;
    *at_ns = until_ns;
    for (int i = g->first_bound; i >= 0; i = c->axes[i].next_bound) {
        if (c->axes[i].is_processor) continue;
        int64_t axis_ns = axis_tells_ns(&c->axes[i]);
        if (axis_ns > *at_ns || axis_ns == HIL_FOREVER) continue;
        if (next >= 0 && axis_ns == *at_ns && c->axes[next].order < c->axes[i].order) continue;
        next = i;
        *at_ns = axis_ns;
    }
    return next;
}

/* Whether events are waiting that time does not go past. */
static int has_to_wait(const hil_group *g) { return g->stops | ring_is_filling(&g->events); }

static int next_processor(const hil_core *c, int axis)
{
    while (axis >= 0 && !c->axes[axis].is_processor) axis = c->axes[axis].next_bound;
    return axis;
}

/* The first wire from an axis's outputs, from wire k on, that ends at another axis with outputs than one; -1: none does. */
static int next_wire(const hil_core *c, int axis, int k, int than)
{
    hil_axis *a = &c->axes[axis];
    const outputs *o = a->law->outputs(a);
    for (; k < o->n_wires; k++)
        if (o->wires[k].to_axis != than && c->axes[o->wires[k].to_axis].law->outputs) return k;
    return -1;
}

/* What one of several processors does by its pins may come back to one of them later, by an axis that has outputs. One that is
   passive, and the processor's alone, answers it at once. */
static int is_wired_back(const hil_core *c, const hil_group *g)
{
    for (int i = next_processor(c, g->first_bound); i >= 0; i = next_processor(c, c->axes[i].next_bound)) {
        const outputs *o = c->axes[i].law->outputs(&c->axes[i]);
        for (int k = 0; (k = next_wire(c, i, k, -1)) >= 0; k++) {
            int to = o->wires[k].to_axis;
            if (!c->axes[to].law->is_passive || next_wire(c, to, 0, i) >= 0) return 1;
        }
    }
    return 0;
}

static int64_t step_of_processors(const hil_core *c, const hil_group *g)
{
    int first = next_processor(c, g->first_bound);
    if (first < 0 || next_processor(c, c->axes[first].next_bound) < 0) return HIL_FOREVER;
    return is_wired_back(c, g) ? AHEAD_WIRED_NS : AHEAD_NS;
}

/* Where all processors are asleep, time goes to the first that wakes. */
static int64_t processors_next_ns(const hil_core *c, const hil_group *g)
{
    int64_t next_ns = HIL_FOREVER;
    for (int i = next_processor(c, g->first_bound); i >= 0; i = next_processor(c, c->axes[i].next_bound))
        if (axis_next_ns(&c->axes[i]) < next_ns) next_ns = axis_next_ns(&c->axes[i]);
    return next_ns;
}

/* Processors from now_ns on, up to until_ns, which is where another axis does something. A single one goes to where it has
   done something that others may hear of; several go on together, step by step. Answers how far that was. */
static int64_t run_processors(hil_core *c, const hil_group *g, int64_t now_ns, int64_t until_ns, int64_t step_ns, int64_t *work)
{
    int has_stopped = 0;
    while (now_ns < until_ns && !has_stopped && *work < CALL_WORK) {
        int64_t next_ns = processors_next_ns(c, g), end_ns = until_ns;
        if (next_ns > until_ns) return until_ns;
        if (next_ns > now_ns) now_ns = next_ns;
        if (end_ns - now_ns > step_ns) end_ns = now_ns + step_ns;
        for (int i = next_processor(c, g->first_bound); i >= 0; i = next_processor(c, c->axes[i].next_bound)) {
            hil_axis *a = &c->axes[i];
            do {
                a->has_stopped = 0;
                *work += axis_advance(c, a, i, end_ns);
                has_stopped |= a->has_stopped;
                if (a->has_stopped && step_ns == HIL_FOREVER) return a->stopped_ns;
            } while (a->has_stopped);
        }
        now_ns = end_ns;
    }
    return now_ns;
}

/* All that happens to bound axes, in time's order: what is left is each axis's own. Processors run last: what they do next
   is not known before. Answers how far that was: less where events are waiting, or where it was as much as one call does. */
static int64_t run_bound(hil_core *c, hil_group *g, int64_t until_ns, int64_t *work)
{
    int64_t at_ns, come_ns = atomic_load_explicit(&g->now_ns, memory_order_relaxed);
    find_bound(c, g, until_ns);
    if (g->first_bound < 0) return until_ns;
    int64_t step_ns = step_of_processors(c, g);
    int has_processors = next_processor(c, g->first_bound) >= 0;
    for (;;) {
        int axis = next_bound(c, g, until_ns, &at_ns);
        if (has_processors && come_ns < at_ns) {
            come_ns = run_processors(c, g, come_ns, at_ns, step_ns, work);
            if (has_to_wait(g) || *work >= CALL_WORK) until_ns = come_ns;
            if (come_ns < at_ns) continue;
        }
        if (axis < 0) return until_ns;
        *work += axis_advance(c, &c->axes[axis], axis, at_ns);
        /* What happens to the others at this time happens too. */
        if (has_to_wait(g) || *work >= CALL_WORK) until_ns = at_ns;
    }
}

/* Less far where events are waiting. */
static int64_t advance_slice(hil_core *c, int group, int64_t now_ns, int64_t until_ns, int64_t *work)
{
    hil_group *g = &c->groups[group];
    int64_t span_ns = until_ns - now_ns;
    until_ns = run_bound(c, g, until_ns, work);
    *work += run_active(c, g, span_ns, until_ns);
    atomic_store_explicit(&g->now_ns, until_ns, memory_order_release);
    return until_ns;
}

/* Makes a group ready to go on from now_ns; 0: it may not, up to *until_ns or because events are waiting. */
static int may_go_on(hil_group *g, int64_t now_ns, int64_t *until_ns)
{
    if (*until_ns > g->horizon_ns) *until_ns = g->horizon_ns;
    if (*until_ns <= now_ns || ring_used(&g->events) >= (g->stops ? 1 : g->events.len / 2)) return 0;
    g->stops = 0;
    return 1;
}

int64_t group_begin(hil_core *c, int group, int64_t until_ns)
{
    hil_group *g = &c->groups[group];
    int64_t now_ns = atomic_load_explicit(&g->now_ns, memory_order_relaxed), work = 0;
    if (!may_go_on(g, now_ns, &until_ns)) return -1;
    if (g->first_active < 0) return until_ns;
    if (until_ns - now_ns > MOST_NS) until_ns = now_ns + MOST_NS;
    int64_t span_ns = until_ns - now_ns;
    for (int i = g->first_active; i >= 0; i = c->axes[i].next_active) work += plant_work(&c->axes[i], span_ns);
    if (work > CALL_WORK && span_ns > SLICE_NS) {
        int64_t less_ns = span_ns / (work / CALL_WORK + 1);
        until_ns = now_ns + (less_ns < SLICE_NS ? SLICE_NS : less_ns);
    }
    work = 0;
    return run_bound(c, g, until_ns, &work);
}

void group_end(hil_core *c, int group, int64_t until_ns)
{
    hil_group *g = &c->groups[group];
    (void)run_active(c, g, 0, until_ns);
    atomic_store_explicit(&g->now_ns, until_ns, memory_order_release);
}

/* Whoever asks for years gets them in parts: between two calls signals are heard, and others have their turn. */
int64_t hil_group_advance(hil_core *c, int group, int64_t until_ns)
{
    hil_group *g = &c->groups[group];
    int64_t now_ns = atomic_load_explicit(&g->now_ns, memory_order_relaxed);
    if (!may_go_on(g, now_ns, &until_ns)) return now_ns;
    for (int64_t work = 0; now_ns < until_ns && work < CALL_WORK && !has_to_wait(g);) {
        int is_short = until_ns - now_ns <= SLICE_NS || g->first_active < 0; /* nothing happens to idle axes */
        now_ns = advance_slice(c, group, now_ns, is_short ? until_ns : now_ns + SLICE_NS, &work);
    }
    return now_ns;
}

void hil_group_set_horizon(hil_core *c, int group, int64_t horizon_ns)
{
    c->groups[group].horizon_ns = horizon_ns;
    c->groups[group].reported = 0;
}

int hil_group_is_quiet(const hil_core *c, int group)
{
    const hil_group *g = &c->groups[group];
    for (int i = g->first_active; i >= 0; i = c->axes[i].next_active) {
        const hil_axis *a = &c->axes[i];
        if (a->is_telling || a->is_joined || a->source.next_ns < HIL_FOREVER) return 0;
    }
    return 1;
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
    for (int i = g->first_axis; i >= 0; i = c->axes[i].next_in_group) view_publish(&c->axes[i], g->published_ns);
}

void hil_group_release(hil_core *c, int group)
{
    group_publish(c, group);
    atomic_store_explicit(&c->groups[group].owner, GROUP_FREE, memory_order_release);
}
