/* What a profile does at a time, how it stands to limits, and the same in other time. */
#include <math.h>

#include "course.h"

traj_error traj_set_duration(traj_profile *p, double duration)
{
    if (!(duration <= TRAJ_LONGEST_S)) return TRAJ_OUT_OF_RANGE;
    p->duration = duration;
    p->duration_ns = (int64_t)ceil(duration * 1e9);
    return TRAJ_OK;
}

/* Of a segment, dt after its start. */
static traj_state in_segment(const traj_segment *s, double dt)
{
    return (traj_state){s->p + dt * (s->v + dt * (s->a / 2 + dt * s->j / 6)), s->v + dt * (s->a + dt * s->j / 2),
                        s->a + dt * s->j};
}

traj_state traj_at(const traj_profile *p, int64_t at_ns)
{
    if (at_ns >= p->duration_ns)
        return (traj_state){p->to + p->end_v * ((double)(at_ns - p->duration_ns) / 1e9), p->end_v, 0};
    if (p->count == 0) return (traj_state){p->from, p->start_v, 0};
    double t = at_ns > 0 ? (double)at_ns / 1e9 : 0;
    int low = 0, high = p->count; /* segments[low] has begun, segments[high] has not */
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (p->segments[middle].t <= t) low = middle;
        else high = middle;
    }
    traj_state s = in_segment(&p->segments[low], t - p->segments[low].t);
    s.position += p->from;
    return s;
}

/* The ends of segment i and, between them, where its velocity turns; answers how many. */
static int marks_of(const traj_profile *p, int i, double dt[3])
{
    const traj_segment *s = &p->segments[i];
    double turn = s->j == 0 ? -1 : -s->a / s->j;
    int count = 0;
    dt[count++] = 0;
    if (turn > 0 && turn < s->length) dt[count++] = turn;
    if (s->length > 0) dt[count++] = s->length;
    return count;
}

/* How a value of a state or of a segment stands to its limit. */
typedef struct measure {
    double value, limit;
} measure;

static measure measure_of(const traj_segment *s, double dt, const traj_limits *l, traj_quantity quantity)
{
    traj_state at = in_segment(s, dt);
    if (quantity == TRAJ_VELOCITY) return (measure){at.velocity, l->velocity};
    if (quantity == TRAJ_ACCELERATION) return (measure){at.acceleration, l->acceleration};
    return (measure){s->j, l->jerk};
}

static int violation_of(const traj_profile *p, const traj_limits *l, traj_kind kind, traj_violation_found *found)
{
    double dt[3];
    traj_quantity last = kind == TRAJ_S_CURVE ? TRAJ_JERK : TRAJ_ACCELERATION;
    for (int i = 0; i < p->count; i++)
        for (int k = 0, marks = marks_of(p, i, dt); k < marks; k++)
            for (traj_quantity q = TRAJ_VELOCITY; q <= last; q++) {
                measure m = measure_of(&p->segments[i], dt[k], l, q);
                if (fabs(m.value) <= m.limit * (1 + TRAJ_TOLERANCE)) continue;
                int64_t at_ns = (int64_t)((p->segments[i].t + dt[k]) * 1e9 + 0.5);
                *found = (traj_violation_found){.quantity = q, .at_ns = at_ns, .value = m.value, .limit = m.limit};
                return 1;
            }
    return 0;
}

int traj_violation(int axes, const traj_profile *profiles, const traj_limits *limits, traj_kind kind,
                   traj_violation_found *found)
{
    int is_any = 0;
    traj_violation_found one;
    for (int axis = 0; axis < axes; axis++) {
        if (!violation_of(&profiles[axis], &limits[axis], kind, &one)) continue;
        if (is_any && one.at_ns >= found->at_ns) continue;
        *found = one;
        found->axis = axis;
        is_any = 1;
    }
    return is_any;
}

/* Newton's iteration from above; libm's cbrt is not the same everywhere. */
static double cube_root(double x)
{
    double y = fmax(x, 1), next;
    if (x == 0 || !isfinite(x)) return x;
    while ((next = y - (y - x / (y * y)) / 3) < y) y = next;
    return y;
}

double traj_fit(int axes, const traj_profile *profiles, const traj_limits *limits, traj_kind kind)
{
    double most[TRAJ_JERK + 1] = {0}, dt[3];
    for (int axis = 0; axis < axes; axis++)
        for (int i = 0; i < profiles[axis].count; i++)
            for (int k = 0, marks = marks_of(&profiles[axis], i, dt); k < marks; k++)
                for (traj_quantity q = TRAJ_VELOCITY; q <= TRAJ_JERK; q++) {
                    measure m = measure_of(&profiles[axis].segments[i], dt[k], &limits[axis], q);
                    most[q] = fmax(most[q], fabs(m.value) / m.limit);
                }
    double factor = fmax(most[TRAJ_VELOCITY], sqrt(most[TRAJ_ACCELERATION]));
    return kind == TRAJ_S_CURVE ? fmax(factor, cube_root(most[TRAJ_JERK])) : factor;
}

traj_error traj_stretch(traj_profile *p, double factor)
{
    if (!(factor > 0 && isfinite(factor))) return TRAJ_OUT_OF_RANGE;
    double by = 1 / factor;
    for (int i = 0; i < p->count; i++) {
        traj_segment *s = &p->segments[i];
        s->t *= factor;
        s->length *= factor;
        s->v *= by;
        s->a *= by * by;
        s->j *= by * by * by;
    }
    p->start_v *= by;
    p->end_v *= by;
    return traj_set_duration(p, p->duration * factor);
}
