#include "trajectory.h"

#include <math.h>

#include "shape.h"

static traj_error check_axes(int axes, traj_fault *fault)
{
    *fault = (traj_fault){.axis = -1};
    return axes < 1 ? TRAJ_NO_AXES : axes > TRAJ_AXES ? TRAJ_TOO_MANY_AXES : TRAJ_OK;
}

static traj_error failed(traj_error error, int axis, traj_fault *fault)
{
    if (error) fault->axis = axis;
    return error;
}

static traj_error check_limits(const traj_limits *l, traj_kind kind)
{
    double jerk = kind == TRAJ_S_CURVE ? l->jerk : 1;
    if (!isfinite(l->velocity) || !isfinite(l->acceleration) || !isfinite(jerk)) return TRAJ_NOT_FINITE;
    return l->velocity > 0 && l->acceleration > 0 && jerk > 0 ? TRAJ_OK : TRAJ_LIMIT_NOT_POSITIVE;
}

traj_error traj_check_limits(int axes, const traj_limits *limits, traj_kind kind, traj_fault *fault)
{
    traj_error error = check_axes(axes, fault);
    for (int i = 0; i < axes && !error; i++) error = failed(check_limits(&limits[i], kind), i, fault);
    return error;
}

static shape_bounds bounds_of(const traj_limits *l, traj_kind kind)
{
    shape_bounds b = {.v = l->velocity, .a = l->acceleration};
    if (kind == TRAJ_S_CURVE) {
        b.j = l->jerk;
        b.inverse_j = 1 / l->jerk;
    }
    return b;
}

/* Phases into segments, from (from, v) on; the slope is kept. */
static traj_error lay(traj_profile *p, double from, double v, const shape_phase *phases, int count)
{
    double t = 0, at = 0;
    if (count > p->room) return TRAJ_NO_ROOM;
    p->from = from;
    p->start_v = v;
    p->count = count;
    for (int i = 0; i < count; i++) {
        double d = phases[i].t, a = phases[i].a, j = phases[i].j;
        p->segments[i] = (traj_segment){t, d, at, v, a, j};
        at += d * (v + d * (a / 2 + d * j / 6));
        v += d * (a + d * j / 2);
        t += d;
    }
    if (!isfinite(at) || !isfinite(from + at) || !isfinite(v)) return TRAJ_OUT_OF_RANGE;
    return traj_set_duration(p, t);
}

static int is_at_rest(const traj_state *s, traj_kind kind)
{
    return s->velocity == 0 && (kind == TRAJ_TRAPEZOID || s->acceleration == 0);
}

static int is_within(const shape_bounds *b, double v, double a)
{
    double most_v = fmax(fabs(v), fabs(v + a * fabs(a) * b->inverse_j / 2));
    return fabs(a) <= b->a * (1 + TRAJ_TOLERANCE) && most_v <= b->v * (1 + TRAJ_TOLERANCE);
}

static traj_error soonest(const traj_state *start, double target, const traj_limits *limits, traj_kind kind,
                          traj_profile *out)
{
    traj_error error = check_limits(limits, kind);
    if (error) return error;
    if (!isfinite(start->position) || !isfinite(start->velocity) || !isfinite(start->acceleration) || !isfinite(target))
        return TRAJ_NOT_FINITE;
    shape_bounds b = bounds_of(limits, kind);
    double v = start->velocity, a = kind == TRAJ_S_CURVE ? start->acceleration : 0;
    if (!is_within(&b, v, a)) return TRAJ_START_BEYOND_LIMITS;
    shape s;
    shape_to_position(&s, &b, v, a, target - start->position);
    out->to = target;
    out->end_v = 0;
    out->slope = 0;
    return lay(out, start->position, v, s.phases, s.count);
}

/* After its end, which rounding may put a little before the other's, a shape stands. */
static shape_phase phase_at(const shape *s, int i) { return i < s->count ? s->phases[i] : (shape_phase){.t = INFINITY}; }

/* share of x and the rest of y, which end together: within all limits that both keep, as these are convex. */
static int mean(const shape *x, const shape *y, double share, shape_phase *out)
{
    int i = 0, k = 0, count = 0;
    double in_x = 0, in_y = 0; /* how far into phase i of x, k of y */
    while (i < x->count || k < y->count) {
        shape_phase p = phase_at(x, i), q = phase_at(y, k);
        double left_x = p.t - in_x, left_y = q.t - in_y, t = fmin(left_x, left_y);
        double a = p.a + p.j * in_x, b = q.a + q.j * in_y;
        if (t > 0) out[count++] = (shape_phase){t, b + share * (a - b), q.j + share * (p.j - q.j)};
        in_x += t;
        in_y += t;
        if (left_x <= left_y) in_x = 0, i++;
        if (left_y <= left_x) in_y = 0, k++;
    }
    return count;
}

/* A soonest profile made to take longer. */
static traj_error lengthen(traj_profile *p, const traj_state *start, const traj_limits *limits, traj_kind kind, double duration)
{
    if (p->count == 0) return traj_set_duration(p, duration);
    if (is_at_rest(start, kind)) return traj_stretch(p, duration / p->duration);
    shape_bounds b = bounds_of(limits, kind);
    double v = start->velocity, a = kind == TRAJ_S_CURVE ? start->acceleration : 0, distance = p->to - p->from;
    int forward = v > 0 || (v == 0 && a > 0) ? 1 : -1; /* a mirrored move is the mirrored profile, to the bit */
    shape far, near;
    shape_phase phases[2 * SHAPE_PHASES];
    shape_farthest(&far, &b, v, a, forward, duration);
    shape_farthest(&near, &b, v, a, -forward, duration);
    double share = far.p != near.p ? (distance - near.p) / (far.p - near.p) : 1;
    share = share > 0 ? fmin(share, 1) : 0;
    return lay(p, p->from, v, phases, mean(&far, &near, share, phases));
}

/* Which duration all take, and in whole ns. */
static traj_error choose_duration(int axes, const traj_profile *profiles, int64_t asked_ns, double *duration,
                                  int64_t *duration_ns, traj_fault *fault)
{
    int slowest = 0;
    for (int i = 1; i < axes; i++)
        if (profiles[i].duration > profiles[slowest].duration) slowest = i;
    *duration = profiles[slowest].duration;
    *duration_ns = profiles[slowest].duration_ns;
    if (asked_ns == TRAJ_SOONEST) return TRAJ_OK;
    if (asked_ns < *duration_ns) {
        fault->least_ns = *duration_ns;
        return failed(TRAJ_TOO_SHORT, slowest, fault);
    }
    *duration = (double)asked_ns / 1e9;
    *duration_ns = asked_ns;
    return *duration <= TRAJ_LONGEST_S ? TRAJ_OK : TRAJ_OUT_OF_RANGE;
}

traj_error traj_joint(int axes, const traj_state *starts, const double *targets, const traj_limits *limits,
                      traj_kind kind, int64_t duration_ns, traj_profile *out, traj_fault *fault)
{
    double duration;
    traj_error error = check_axes(axes, fault);
    for (int i = 0; i < axes && !error; i++)
        error = failed(soonest(&starts[i], targets[i], &limits[i], kind, &out[i]), i, fault);
    if (!error) error = choose_duration(axes, out, duration_ns, &duration, &duration_ns, fault);
    for (int i = 0; i < axes && !error; i++) {
        if (out[i].duration < duration)
            error = failed(lengthen(&out[i], &starts[i], &limits[i], kind, duration), i, fault);
        out[i].duration = duration;
        out[i].duration_ns = duration_ns;
    }
    return error;
}

/* An axis of a line: everything of the path, times its slope. */
static traj_error project(const traj_profile *path, double from, double to, double slope, traj_profile *out)
{
    if (path->count > out->room) return TRAJ_NO_ROOM;
    traj_segment *segments = out->segments;
    int room = out->room;
    *out = *path;
    out->segments = segments;
    out->room = room;
    out->from = from;
    out->to = to;
    out->slope = slope;
    out->start_v *= slope;
    out->end_v *= slope;
    for (int i = 0; i < path->count; i++) {
        traj_segment s = path->segments[i];
        segments[i] = (traj_segment){s.t, s.length, s.p * slope, s.v * slope, s.a * slope, s.j * slope};
    }
    return TRAJ_OK;
}

/* Limits of the path that keep those of the axes. An axis that stands has none to keep. */
static traj_limits along(int axes, const double *slopes, const traj_limits *limits)
{
    traj_limits least = {INFINITY, INFINITY, INFINITY};
    for (int i = 0; i < axes; i++) {
        double slope = fabs(slopes[i]);
        if (slope == 0) continue;
        least.velocity = fmin(least.velocity, limits[i].velocity / slope);
        least.acceleration = fmin(least.acceleration, limits[i].acceleration / slope);
        least.jerk = fmin(least.jerk, limits[i].jerk / slope);
    }
    return isinf(least.velocity) ? limits[0] : least;
}

traj_error traj_line(int axes, const double *starts, const double *targets, const traj_limits *limits, traj_kind kind,
                     int64_t duration_ns, traj_profile *path, traj_profile *out, traj_fault *fault)
{
    double slopes[TRAJ_AXES], length = 0;
    traj_error error = check_axes(axes, fault);
    for (int i = 0; i < axes && !error; i++) {
        error = check_limits(&limits[i], kind);
        if (!error && !(isfinite(starts[i]) && isfinite(targets[i]))) error = TRAJ_NOT_FINITE;
        if (!error && !isfinite(targets[i] - starts[i])) error = TRAJ_OUT_OF_RANGE;
        failed(error, i, fault);
        length = fmax(length, fabs(targets[i] - starts[i]));
    }
    if (error) return error;
    for (int i = 0; i < axes; i++) slopes[i] = length > 0 ? (targets[i] - starts[i]) / length : 0;
    traj_limits least = along(axes, slopes, limits);
    error = traj_joint(1, &(traj_state){0}, &length, &least, kind, duration_ns, path, fault);
    for (int i = 0; i < axes && !error; i++) error = project(path, starts[i], targets[i], slopes[i], &out[i]);
    return error;
}

static traj_error to_velocity(const traj_state *start, double velocity, const traj_limits *limits, traj_kind kind,
                              traj_profile *out)
{
    traj_error error = check_limits(limits, kind);
    if (error) return error;
    if (!isfinite(start->position) || !isfinite(start->velocity) || !isfinite(start->acceleration) || !isfinite(velocity))
        return TRAJ_NOT_FINITE;
    if (!(fabs(velocity) <= limits->velocity * (1 + TRAJ_TOLERANCE))) return TRAJ_TARGET_BEYOND_LIMIT;
    shape_bounds b = bounds_of(limits, kind);
    shape s;
    shape_to_velocity(&s, &b, start->velocity, kind == TRAJ_S_CURVE ? start->acceleration : 0, velocity);
    out->to = start->position + s.p;
    out->end_v = velocity;
    out->slope = 0;
    return lay(out, start->position, start->velocity, s.phases, s.count);
}

traj_error traj_velocity(int axes, const traj_state *starts, const double *velocities, const traj_limits *limits,
                         traj_kind kind, traj_profile *out, traj_fault *fault)
{
    traj_error error = check_axes(axes, fault);
    for (int i = 0; i < axes && !error; i++)
        error = failed(to_velocity(&starts[i], velocities[i], &limits[i], kind, &out[i]), i, fault);
    return error;
}

traj_error traj_stop(int axes, const traj_profile *running, const traj_profile *path, int64_t at_ns,
                     const traj_limits *limits, traj_kind kind, traj_profile *out_path, traj_profile *out,
                     traj_fault *fault)
{
    traj_error error = check_axes(axes, fault);
    double slopes[TRAJ_AXES];
    for (int i = 0; i < axes && !error; i++) {
        traj_state now = traj_at(&running[i], at_ns);
        error = failed(to_velocity(&now, 0, &limits[i], kind, &out[i]), i, fault);
        slopes[i] = running[i].slope;
    }
    if (error || !path) return error;
    traj_limits least = along(axes, slopes, limits);
    traj_state now = traj_at(path, at_ns);
    error = to_velocity(&now, 0, &least, kind, out_path);
    for (int i = 0; i < axes && !error; i++) {
        double from = out[i].from, to = from + slopes[i] * (out_path->to - out_path->from);
        error = project(out_path, from, to, slopes[i], &out[i]);
    }
    return error;
}
