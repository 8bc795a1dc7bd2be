/* Cubic splines with continuous acceleration, which is 0, as the velocity is, at both ends.

   Rest at both ends is four conditions, two more than a cubic spline has to give. So the first and last intervals have
   a knot each besides (Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and Robots, 4.4.4), whose
   position follows from its acceleration: p = q + c a, with q that of the end and c = h^2 / 6. */
#include <math.h>

#include "spline.h"

typedef struct points {
    int count;
    const int64_t *times_ns;
    const double *positions;
} points;

typedef struct knot {
    double t, q, c; /* s and position from the first point's; c is 0 at the points */
} knot;

static double seconds(const points *p, int i) { return (double)((uint64_t)p->times_ns[i] - (uint64_t)p->times_ns[0]) / 1e9; }

/* Knots 0 and count + 1 are the ends, 1 and count the ones besides. */
static knot knot_at(const points *p, int i)
{
    int n = p->count;
    double parts = n == 2 ? 3 : 2; /* both in one interval, or each in the middle of its own */
    if (i == 0) return (knot){0};
    if (i == 1) {
        double h = seconds(p, 1) / parts;
        return (knot){h, 0, h * h / 6};
    }
    double end_q = p->positions[n - 1] - p->positions[0], end = seconds(p, n - 1);
    if (i == n) {
        double h = (end - seconds(p, n - 2)) / parts;
        return (knot){end - h, end_q, h * h / 6};
    }
    if (i == n + 1) return (knot){end, end_q, 0};
    return (knot){seconds(p, i - 1), p->positions[i - 1] - p->positions[0], 0};
}

/* The accelerations at knots 1 to count into s[1..count].a: velocities are continuous, which is a tridiagonal system
   that Thomas's algorithm solves. On the way v and p of the segments hold its upper diagonal and right side. */
static void solve(const points *p, traj_segment *s)
{
    knot left = knot_at(p, 0), here = knot_at(p, 1);
    s[0].v = s[0].p = 0;
    for (int i = 1; i <= p->count; i++) {
        knot right = knot_at(p, i + 1);
        double h0 = here.t - left.t, h1 = right.t - here.t;
        double lower = i > 1 ? h0 / 6 - left.c / h0 : 0, upper = h1 / 6 - right.c / h1;
        double diagonal = (h0 + h1) / 3 + here.c / h0 + here.c / h1;
        double side = (right.q - here.q) / h1 - (here.q - left.q) / h0;
        double pivot = diagonal - lower * s[i - 1].v;
        s[i].v = upper / pivot;
        s[i].p = (side - lower * s[i - 1].p) / pivot;
        left = here;
        here = right;
    }
    s[p->count].a = s[p->count].p;
    for (int i = p->count - 1; i >= 1; i--) s[i].a = s[i].p - s[i].v * s[i + 1].a;
    s[0].a = 0;
}

traj_error traj_spline(int count, const int64_t *times_ns, const double *positions, traj_profile *out)
{
    points p = {count, times_ns, positions};
    traj_segment *s = out->segments;
    if (count < 2) return TRAJ_TOO_FEW_POINTS;
    if (out->room < count + 1) return TRAJ_NO_ROOM;
    for (int i = 0; i < count; i++) {
        if (!isfinite(positions[i])) return TRAJ_NOT_FINITE;
        if (i > 0 && times_ns[i] <= times_ns[i - 1]) return TRAJ_POINTS_OUT_OF_ORDER;
    }
    solve(&p, s);
    double end_p = positions[count - 1] - positions[0];
    knot here = knot_at(&p, 0);
    for (int i = 0; i <= count; i++) {
        knot next = knot_at(&p, i + 1);
        double h = next.t - here.t, a = s[i].a, next_a = i < count ? s[i + 1].a : 0;
        double at = here.q + here.c * a, next_p = i < count ? next.q + next.c * next_a : end_p;
        double v = i == 0 ? 0 : (next_p - at) / h - h * (2 * a + next_a) / 6;
        s[i] = (traj_segment){here.t, h, at, v, a, (next_a - a) / h};
        if (!isfinite(at) || !isfinite(v) || !isfinite(a) || !isfinite(s[i].j)) return TRAJ_OUT_OF_RANGE;
        here = next;
    }
    out->count = count + 1;
    out->from = positions[0];
    out->to = positions[count - 1];
    out->start_v = out->end_v = out->slope = 0;
    traj_error error = traj_set_duration(out, here.t);
    out->duration_ns = error ? 0 : times_ns[count - 1] - times_ns[0];
    return error;
}
