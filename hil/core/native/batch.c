#include "batch.h"

#include <math.h>

#include "batch_any.h"
#include "batch_avx2.h"
#include "hil_core.h"
#include "law/servo.h"

#ifdef __x86_64__
#define HAVE(name) (__builtin_cpu_supports("avx2") ? name##_avx2 : name##_any)
#else
#define HAVE(name) name##_any
#endif

#define WORTH_IT 4 /* axes: all lanes together take the time of three or four axes alone */

/* Whether nothing but control steps is due in a group until then: an axis alone, its encoder on its shaft, no
   step response to be printed, and nothing that a lane has no room for. The plant's node is at the latest
   control step. */
static int fits(const hil_group *g, const hil_axis *a)
{
    const servo *s = servo_of(a);
    if (!s || a->next_in_group >= 0 || a->encoder.script_len || a->is_faulty || a->is_telling || s->follow.n ||
        (a->encoder.previous_command & 0x3FFF) != SPI_ANGLE || ring_is_filling(&g->events) || !s->loop_steps)
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
    if (c->groups[group].first_axis >= 0) fetch_axis(c, c->groups[group].first_axis);
}

/* As many control steps as all have to make. */
static void run(hil_core *c, int is_full, const lane *lanes, int seated)
{
    int64_t steps = lanes[0].steps;
    for (int i = 1; i < seated; i++) steps = least(steps, lanes[i].steps);
    (is_full ? HAVE(full_batch) : HAVE(simple_batch))(c, lanes, seated, steps);
}

void batch_advance(hil_core *c, const int *groups, int n, int64_t until_ns)
{
    lane lanes[2][SEATS]; /* of either plant */
    int seated[2] = {0, 0};
    for (int k = 0; k < n && k < SEATS; k++) fetch_group(c, groups[k]);
    for (int k = 0; k < n; k++) {
        if (k + SEATS < n) fetch_group(c, groups[k + SEATS]);
        hil_group *g = &c->groups[groups[k]];
        if (g->first_axis < 0) continue;
        hil_axis *a = &c->axes[g->first_axis];
        int64_t end_ns = least(until_ns, g->horizon_ns);
        end_ns = least(end_ns, least(a->source.next_ns, a->watch_next_ns) - 1); /* what else happens comes in its turn */
        if (a->law_next_ns > end_ns || !fits(g, a)) continue;
        int kind = a->is_full != 0;
        /* As many as are due, or one less. */
        lanes[kind][seated[kind]++] = (lane){a, (end_ns - a->law_next_ns) / (STEP_NS + 1) + 1};
        if (seated[kind] < SEATS) continue;
        run(c, kind, lanes[kind], SEATS);
        seated[kind] = 0;
    }
    for (int kind = 0; kind < 2; kind++)
        if (seated[kind] >= WORTH_IT) run(c, kind, lanes[kind], seated[kind]);
    for (int k = 0; k < n; k++) hil_group_advance(c, groups[k], until_ns);
}
