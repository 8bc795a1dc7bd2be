/* Room for plans, random inputs of them, and what holds of every profile. */
#ifndef HIL_TESTS_TRAJECTORY_FIXTURE_H
#define HIL_TESTS_TRAJECTORY_FIXTURE_H

#include <stdlib.h>

#include "../motion/spline.h"
#include "../motion/trajectory.h"
#include "check.h"

enum { MOST_POINTS = 40 };

typedef struct plan {
    traj_profile axes[TRAJ_AXES + 1]; /* the last for a path */
    traj_segment segments[TRAJ_AXES + 1][MOST_POINTS + 1];
    traj_fault fault;
} plan;

static inline plan *new_plan(int room)
{
    plan *p = calloc(1, sizeof *p);
    for (int i = 0; i <= TRAJ_AXES; i++) {
        p->axes[i].segments = p->segments[i];
        p->axes[i].room = room;
    }
    return p;
}

/* Uniform in [0, 1). */
static inline double chance(uint64_t *seed)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(*seed >> 11) * 0x1p-53;
}

static inline double between(uint64_t *seed, double low, double high) { return low + (high - low) * chance(seed); }

static inline traj_limits any_limits(uint64_t *seed)
{
    return (traj_limits){pow(10, between(seed, 0, 4)), pow(10, between(seed, 0, 5)), pow(10, between(seed, 1, 6))};
}

static inline traj_state any_start(uint64_t *seed, const traj_limits *l, traj_kind kind)
{
    for (;;) {
        double v = between(seed, -1, 1) * l->velocity, a = between(seed, -1, 1) * l->acceleration;
        double later = kind == TRAJ_S_CURVE ? v + a * fabs(a) / (2 * l->jerk) : v;
        if (fabs(later) <= l->velocity) return (traj_state){between(seed, -1e3, 1e3), v, a};
    }
}

static inline double scale_of(const traj_profile *p)
{
    double most = fabs(p->to - p->from);
    for (int i = 0; i < p->count; i++) most = fmax(most, fabs(p->segments[i].p));
    return most + 1e-3 * (fabs(p->from) + fabs(p->to));
}

static inline void check_near_start(const traj_profile *p, const traj_state *start, traj_kind kind)
{
    traj_state s = traj_at(p, 0);
    CHECK(s.position == start->position);
    if (p->duration_ns > 0) CHECK(s.velocity == start->velocity);
    if (p->duration_ns > 0 && kind == TRAJ_S_CURVE)
        CHECK_NEAR(s.acceleration, start->acceleration, 1e-9 * fabs(start->acceleration));
}

/* Neighbouring segments meet, and the last one meets the end. */
static inline void check_continuous(const traj_profile *p, const traj_limits *l, traj_kind kind)
{
    double small = 1e-9;
    for (int i = 0; i < p->count; i++) {
        traj_segment s = p->segments[i];
        double d = s.length;
        traj_segment next = {p->duration, 0, p->to - p->from, p->end_v, 0, 0};
        if (i + 1 < p->count) next = p->segments[i + 1];
        CHECK(d > 0);
        CHECK_NEAR(s.t + d, next.t, 1e-12 * p->duration);
        CHECK_NEAR(s.p + d * (s.v + d * (s.a / 2 + d * s.j / 6)), next.p,
                   small * scale_of(p) + 1e-14 * l->velocity * p->duration);
        CHECK_NEAR(s.v + d * (s.a + d * s.j / 2), next.v, small * l->velocity);
        if (kind == TRAJ_S_CURVE) CHECK_NEAR(s.a + d * s.j, next.a, 1e-8 * l->acceleration);
    }
}

static inline void check_end(const traj_profile *p, double target)
{
    traj_state end = traj_at(p, p->duration_ns), later = traj_at(p, p->duration_ns + 1000000000);
    CHECK(end.position == target && end.velocity == 0 && end.acceleration == 0);
    CHECK(later.position == target && later.velocity == 0);
}

/* Sampled, besides what traj_violation looks at. */
static inline void check_inside(const traj_profile *p, const traj_limits *l, traj_kind kind)
{
    traj_violation_found found;
    if (traj_violation(1, p, l, kind, &found))
        CHECK_FAILED("quantity %d is %.17g at %lld ns, limit %.17g", (int)found.quantity, found.value,
                     (long long)found.at_ns, found.limit);
    for (int i = 0; i < 51 + 3 * p->count; i++) { /* and around the ends of segments */
        int64_t near = i < 51 ? 0 : (int64_t)(p->segments[(i - 51) / 3].t * 1e9) + (i % 3 - 1);
        traj_state s = traj_at(p, i < 51 ? (int64_t)((double)p->duration_ns * i / 50) : near);
        CHECK(fabs(s.velocity) <= l->velocity * (1 + TRAJ_TOLERANCE));
        CHECK(fabs(s.acceleration) <= l->acceleration * (1 + TRAJ_TOLERANCE) ||
              (kind == TRAJ_TRAPEZOID && s.velocity == 0));
    }
}

static inline double any_distance(uint64_t *seed) { return (chance(seed) < 0.5 ? -1 : 1) * pow(10, between(seed, -4, 4)); }

#endif
