#include "batch.h"

#include <math.h>

#include "batch_any.h"
#include "batch_avx2.h"
#include "batch_avx512.h"
#include "group.h"
#include "hil_core.h"
#include "law/servo.h"

/* Code for lanes. */
typedef struct path {
    int seats; /* 0: none on this kind of processor */
    batch_run *simple, *full;
} path;

static const path PATHS[HIL_LANES_MOST] = {
    [HIL_LANES_ANY] = {ROWS * 4, simple_batch_any, full_batch_any},
#ifdef __x86_64__
    [HIL_LANES_AVX2] = {ROWS * 4, simple_batch_avx2, full_batch_avx2},
    [HIL_LANES_AVX512] = {ROWS * 8, simple_batch_avx512, full_batch_avx512},
#endif
};

/* Whether this processor has the instructions. */
static int is_there(hil_lanes lanes)
{
#ifdef __x86_64__
    if (lanes == HIL_LANES_AVX2) return __builtin_cpu_supports("avx2") != 0;
    if (lanes == HIL_LANES_AVX512)
        return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
               __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw");
#endif
    return lanes == HIL_LANES_NONE || lanes == HIL_LANES_ANY;
}

hil_lanes batch_widest(void)
{
    hil_lanes lanes = HIL_LANES_MOST - 1;
    while (!is_there(lanes)) lanes--;
    return lanes;
}

int hil_core_set_lanes(hil_core *c, hil_lanes lanes)
{
    if (!is_there(lanes)) return -1;
    c->lanes = lanes;
    return 0;
}

hil_lanes hil_core_lanes(const hil_core *c) { return c->lanes; }

#define CALL_ROUNDS 10 /* of one call of hil_groups_advance for several: between two calls signals are heard */
#define FEW 4 /* axes, for which four wide lanes take three quarters of the time of eight */
#define ROUND_NS 100000000 /* what a round counts; one that samples end counts as long as it was, and this at the least: */
#define LEAST_ROUND_NS 100000
#define AHEAD 8 /* groups that are fetched before they are needed */
#define WORTH_IT 2 /* axes: all lanes together take the time of one and a half axes alone */

/* Whether nothing but control steps is due to an axis until then: its encoder on its shaft, no step response to be
   printed, and nothing that a lane has no room for. The plant's node is at the latest control step. */
static int fits(const hil_axis *a)
{
    const servo *s = servo_of(a);
    if (!s || a->is_joined || a->encoder.script_len || a->is_faulty || a->is_telling || s->follow.n ||
        (a->encoder.previous_command & 0x3FFF) != SPI_ANGLE || !s->loop_steps)
        return 0;
    int64_t since_ns = a->is_full ? a->full.node_ns : a->plant.node_ns, length_ns = a->law_next_ns - since_ns;
    if (length_ns != STEP_NS && length_ns != STEP_NS + 1) return 0;
    if (!a->is_full) return a->plant.step_ns == PLANT_STEP_NS && fabs(a->plant.moving.rev) < 0x1p40;
    const full *p = &a->full;
    return p->step_ns == FULL_STEP_NS && !p->load_varies && !p->steps && fabs(p->moving.state.rev) < 0x1p39;
}

static int64_t least(int64_t x, int64_t y) { return x < y ? x : y; }

static void fetch(const void *from, size_t size)
{
    for (size_t at = 0; at < size + 63; at += 64) __builtin_prefetch((const char *)from + at, 1);
}

/* What a batch touches of an axis, while another batch is still being worked on. */
static void fetch_axis(const hil_core *c, int axis)
{
    const hil_axis *a = &c->axes[axis];
    fetch(&a->open, offsetof(hil_axis, plant) - offsetof(hil_axis, open));
    fetch(law_place(c, HIL_LAW_MECHADUINO, axis), sizeof(servo));
    if (a->is_full) fetch(&a->full, offsetof(full, load));
    else fetch(&a->plant, sizeof a->plant);
}

static void fetch_group(const hil_core *c, int group)
{
    if (c->groups[group].first_active >= 0) fetch_axis(c, c->groups[group].first_active);
}

/* Axes of either plant that wait for company. */
typedef struct seating {
    path path, few; /* few: for FEW axes or less */
    lane lanes[2][MOST_SEATS];
    int seated[2];
} seating;

/* As many control steps as all of a plant have to make. Who has more to do keeps a seat. */
static void run(hil_core *c, seating *s, int is_full)
{
    lane *lanes = s->lanes[is_full];
    int seated = s->seated[is_full], left = 0;
    int64_t steps = lanes[0].steps;
    for (int i = 1; i < seated; i++) steps = least(steps, lanes[i].steps);
    const path *path = seated <= FEW ? &s->few : &s->path;
    (is_full ? path->full : path->simple)(c, lanes, seated, steps);
    for (int i = 0; i < seated; i++)
        if (lanes[i].steps - steps > 1) lanes[left++] = (lane){lanes[i].axis, lanes[i].steps - steps};
    s->seated[is_full] = left;
}

static void seat(hil_core *c, seating *s, hil_axis *a, int64_t end_ns)
{
    end_ns = least(end_ns, least(a->source.next_ns, a->watch_next_ns) - 1); /* what else happens comes in its turn */
    if (a->law_next_ns > end_ns || !fits(a)) return;
    int kind = a->is_full != 0;
    /* As many as are due, or one less. */
    s->lanes[kind][s->seated[kind]++] = (lane){a, (end_ns - a->law_next_ns) / (STEP_NS + 1) + 1};
    if (s->seated[kind] == s->path.seats) run(c, s, kind);
}

static void seat_group(hil_core *c, seating *s, int group, int64_t end_ns)
{
    for (int i = c->groups[group].first_active, next; i >= 0; i = next) {
        next = c->axes[i].next_active;
        if (next >= 0) fetch_axis(c, next);
        seat(c, s, &c->axes[i], end_ns);
    }
}

/* Until the next sample of any of its axes: beyond it each would go on alone. */
static int64_t until_sample(const hil_core *c, int group, int64_t end_ns)
{
    for (int i = c->groups[group].first_active; i >= 0; i = c->axes[i].next_active)
        end_ns = least(end_ns, c->axes[i].watch_next_ns);
    return end_ns;
}

/* Answers what the longest way of a group counts of a call's. */
static int64_t advance_batch(hil_core *c, const int *groups, int n, int64_t until_ns, int ends_at_samples)
{
    seating s;
    s.path = PATHS[c->lanes];
    s.few = PATHS[c->lanes == HIL_LANES_AVX512 ? HIL_LANES_AVX2 : c->lanes];
    s.seated[0] = s.seated[1] = 0;
    int64_t end_ns[BATCH_GROUPS], longest_ns = 0;
    for (int k = 0; k < n && k < AHEAD; k++) fetch_group(c, groups[k]);
    for (int k = 0; k < n; k++) {
        if (k + AHEAD < n) fetch_group(c, groups[k + AHEAD]);
        end_ns[k] = group_begin(c, groups[k], until_ns);
        if (end_ns[k] >= 0) {
            int64_t free_ns = end_ns[k];
            if (ends_at_samples) end_ns[k] = until_sample(c, groups[k], free_ns);
            int64_t span_ns = end_ns[k] < free_ns ? end_ns[k] - hil_group_now(c, groups[k]) : ROUND_NS;
            if (span_ns > longest_ns) longest_ns = span_ns;
        }
        if (end_ns[k] >= 0 && s.path.seats) seat_group(c, &s, groups[k], end_ns[k]);
    }
    for (int kind = 0; kind < 2; kind++)
        while (s.seated[kind] >= WORTH_IT) run(c, &s, kind);
    for (int k = 0; k < n; k++)
        if (end_ns[k] >= 0) group_end(c, groups[k], end_ns[k]);
    return longest_ns;
}

void batch_advance(hil_core *c, const int *groups, int n, int64_t until_ns)
{
    (void)advance_batch(c, groups, n, until_ns, 0);
}

/* Fewer axes move than lanes are worth. */
static int is_few(const hil_core *c, int group)
{
    int n = 0;
    for (int i = c->groups[group].first_active; i >= 0 && n < WORTH_IT; i = c->axes[i].next_active) n++;
    return n < WORTH_IT;
}

static int can_go_on(const hil_core *c, int group, int64_t until_ns)
{
    const hil_group *g = &c->groups[group];
    int64_t now_ns = atomic_load_explicit(&g->now_ns, memory_order_relaxed);
    return now_ns < until_ns && now_ns < g->horizon_ns && !ring_used(&g->events);
}

void hil_groups_advance(hil_core *c, const int *groups, int n, int64_t until_ns)
{
    if (n == 1 && is_few(c, groups[0])) {
        hil_group_advance(c, groups[0], until_ns);
        return;
    }
    int goes_on = 1;
    for (int64_t left_ns = n > 1 ? CALL_ROUNDS * ROUND_NS : 1; left_ns > 0 && goes_on;) {
        int64_t longest_ns = LEAST_ROUND_NS;
        for (int i = 0; i < n; i += BATCH_GROUPS) {
            int64_t span_ns =
                advance_batch(c, groups + i, n - i < BATCH_GROUPS ? n - i : BATCH_GROUPS, until_ns, n > 1);
            if (span_ns > longest_ns) longest_ns = span_ns;
        }
        left_ns -= longest_ns;
        goes_on = 0;
        for (int i = 0; i < n && !goes_on; i++) goes_on = can_go_on(c, groups[i], until_ns);
    }
}
