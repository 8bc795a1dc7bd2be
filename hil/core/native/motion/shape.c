#include "shape.h"

#include <float.h>
#include <math.h>

/* fmax may answer either of two zeros. */
static double at_least_0(double x) { return x > 0 ? x : 0; }

static void begin(shape *s, double v) { *s = (shape){.v = v}; }

static void append(shape *s, const shape_phase *phases, int count)
{
    for (int i = 0; i < count; i++) {
        double t = phases[i].t, a = phases[i].a, j = phases[i].j;
        if (t == 0) continue;
        s->p += t * (s->v + t * (a / 2 + t * j / 6));
        s->v += t * (a + t * j / 2);
        s->t += t;
        s->phases[s->count++] = phases[i];
    }
}

/* To velocity `to`, acceleration 0: towards a peak of acceleration, hold, and back to 0. */
static void ramp(shape_phase out[3], const shape_bounds *b, double v, double a, double to)
{
    double sign = v + a * fabs(a) * b->inverse_j / 2 <= to ? 1 : -1;
    double change = sign * (to - v), from = sign * a, peak = b->a, hold;
    if (from > peak) hold = (change - from * from * b->inverse_j / 2) / peak; /* a start beyond the limit */
    else hold = (change - (peak * peak - from * from / 2) * b->inverse_j) / peak;
    if (hold < 0) {
        peak = sqrt(at_least_0(change * b->j + from * from / 2));
        hold = 0;
    }
    double towards = peak >= from ? sign * b->j : -sign * b->j;
    out[0] = (shape_phase){fabs(peak - from) * b->inverse_j, a, towards};
    out[1] = (shape_phase){hold, sign * peak, 0};
    out[2] = (shape_phase){peak * b->inverse_j, sign * peak, -sign * b->j};
}

void shape_to_velocity(shape *s, const shape_bounds *b, double v, double a, double to)
{
    shape_phase phases[3];
    ramp(phases, b, v, a, to);
    begin(s, v);
    append(s, phases, 3);
}

/* All soonest ways to positions at rest beyond where the axis stops if it stops at once: it speeds up (its
   acceleration rises to the limit and stays there) for a time u, then stops; the ones to the farthest positions cruise
   in between. Neither the end's position nor its time falls with u, so that either of them selects one. */
typedef struct family {
    const shape_bounds *b;
    double v, a, goal;
    int is_by_time;
    shape *s;
} family;

static double excess(const family *f) { return (f->is_by_time ? f->s->t : f->s->p) - f->goal; }

static double excess_at(const family *f, double u)
{
    const shape_bounds *b = f->b;
    double rise = at_least_0((b->a - f->a) * b->inverse_j), a = b->a;
    if (u < rise) {
        rise = u;
        a = f->a + u * b->j;
    }
    shape_phase up[2] = {{rise, f->a, b->j}, {u - rise, a, 0}}, stop[3];
    begin(f->s, f->v);
    append(f->s, up, 2);
    ramp(stop, b, f->s->v, a, 0);
    append(f->s, stop, 3);
    return excess(f);
}

/* Chandrupatla's method (Adv. Eng. Software 28, 1997): inverse quadratic interpolation where that is safe, else halves. */
static void solve(const family *f, double high)
{
    double a = high, b = 0, c = high, at_a = excess_at(f, a), at_c = at_a, part = 0.5;
    if (!(at_a > 0)) return;
    double at_b = excess_at(f, b);
    if (!(at_b < 0)) return;
    for (int i = 0; i < 200; i++) {
        double x = a + part * (b - a), at_x = excess_at(f, x);
        if ((at_x > 0) == (at_a > 0)) {
            c = a;
            at_c = at_a;
        } else {
            c = b;
            at_c = at_b;
            b = a;
            at_b = at_a;
        }
        a = x;
        at_a = at_x;
        double best = fabs(at_a) < fabs(at_b) ? a : b;
        double least = 2 * DBL_EPSILON * fabs(best) / fabs(b - a);
        if (at_a == 0 || !(least < 0.5)) return;
        double xi = (a - b) / (c - b), phi = (at_a - at_b) / (at_c - at_b);
        part = 0.5;
        if (phi * phi < xi && (1 - phi) * (1 - phi) < 1 - xi)
            part = at_a / (at_b - at_a) * at_c / (at_b - at_c) +
                   (c - a) / (b - a) * at_a / (at_c - at_a) * at_b / (at_c - at_b);
        part = fmin(fmax(part, least), 1 - least);
    }
}

static void select_member(const family *f)
{
    const shape_bounds *b = f->b;
    shape_phase up[3], cruise = {0}, stop[3];
    ramp(up, b, f->v, f->a, b->v);
    ramp(stop, b, b->v, 0, 0);
    begin(f->s, f->v);
    append(f->s, up, 3);
    append(f->s, stop, 3);
    if (excess(f) > 0) {
        solve(f, up[0].t + up[1].t);
        return;
    }
    cruise.t = -excess(f) / (f->is_by_time ? 1 : b->v);
    begin(f->s, f->v);
    append(f->s, up, 3);
    append(f->s, &cruise, 1);
    append(f->s, stop, 3);
}

static void mirror(shape *s)
{
    s->p = -s->p;
    s->v = -s->v;
    for (int i = 0; i < s->count; i++) {
        s->phases[i].a = -s->phases[i].a;
        s->phases[i].j = -s->phases[i].j;
    }
}

void shape_to_position(shape *s, const shape_bounds *b, double v, double a, double distance)
{
    shape_to_velocity(s, b, v, a, 0);
    double sign = distance >= s->p ? 1 : -1;
    family f = {.b = b, .v = sign * v, .a = sign * a, .goal = sign * distance, .s = s};
    select_member(&f);
    if (sign < 0) mirror(s);
}

void shape_farthest(shape *s, const shape_bounds *b, double v, double a, int direction, double t)
{
    family f = {.b = b, .v = direction * v, .a = direction * a, .goal = t, .is_by_time = 1, .s = s};
    select_member(&f);
    if (direction < 0) mirror(s);
}
