/* Plans of one and several axes: limits, ends, continuity, times that can be said beforehand, and inputs that cannot
   be planned. */
#include "trajectory_fixture.h"

static void one_axis_keeps_its_limits_and_ends_exactly(void)
{
    plan *p = new_plan(TRAJ_SEGMENTS);
    uint64_t seed = 1;
    for (int i = 0; i < 20000; i++) {
        traj_kind kind = i % 2 ? TRAJ_S_CURVE : TRAJ_TRAPEZOID;
        traj_limits l = any_limits(&seed);
        traj_state start = any_start(&seed, &l, kind);
        if (i % 4 < 2) start.velocity = start.acceleration = 0;
        double target = start.position + any_distance(&seed);
        CHECK_INT(traj_joint(1, &start, &target, &l, kind, TRAJ_SOONEST, p->axes, &p->fault), TRAJ_OK);
        CHECK(p->axes->count <= 7);
        check_near_start(p->axes, &start, kind);
        check_inside(p->axes, &l, kind);
        check_continuous(p->axes, &l, kind);
        check_end(p->axes, target);
    }
    free(p);
}

/* 7 segments, by hand: 100 deg/s, 1000 deg/s2, 20000 deg/s3 over 100 deg: 0.15 s up, 0.85 s cruise, 0.15 s down. */
static void known_times(void)
{
    plan *p = new_plan(TRAJ_SEGMENTS);
    traj_limits l = {100, 1000, 20000};
    traj_state start = {0};
    double target = 100;
    CHECK_INT(traj_joint(1, &start, &target, &l, TRAJ_S_CURVE, TRAJ_SOONEST, p->axes, &p->fault), TRAJ_OK);
    CHECK_INT(p->axes->count, 7);
    CHECK_NEAR(p->axes->duration, 1.15, 1e-12);
    CHECK_NEAR(traj_at(p->axes, 150000000).position, 7.5, 1e-12);
    CHECK_NEAR(traj_at(p->axes, 150000000).velocity, 100, 1e-12);
    CHECK_NEAR(traj_at(p->axes, 575000000).position, 50, 1e-12);
    CHECK_INT(traj_joint(1, &start, &target, &l, TRAJ_TRAPEZOID, TRAJ_SOONEST, p->axes, &p->fault), TRAJ_OK);
    CHECK_INT(p->axes->count, 3);
    CHECK_NEAR(p->axes->duration, 1.1, 1e-12);
    CHECK_NEAR(traj_at(p->axes, 100000000).position, 5, 1e-12);
    target = 2.5; /* no cruise: 2 sqrt(2.5 / 1000) */
    CHECK_INT(traj_joint(1, &start, &target, &l, TRAJ_TRAPEZOID, TRAJ_SOONEST, p->axes, &p->fault), TRAJ_OK);
    CHECK_NEAR(p->axes->duration, 0.1, 1e-12);
    target = -2; /* neither: 4 cbrt(2 / (2 20000)) */
    CHECK_INT(traj_joint(1, &start, &target, &(traj_limits){1e3, 1e4, 20000}, TRAJ_S_CURVE, TRAJ_SOONEST, p->axes, &p->fault),
              TRAJ_OK);
    CHECK_NEAR(p->axes->duration, 4 * cbrt(2.0 / 40000), 1e-12);
    CHECK_INT(p->axes->count, 3);
    free(p);
}

/* A million seconds have a grain of 1e-10 s, in which this jerk changes the acceleration by a part in ten thousand. */
static void a_long_cruise_does_not_blur_its_ends(void)
{
    plan *p = new_plan(TRAJ_SEGMENTS);
    traj_limits l = {1, 1, 1e6};
    for (int i = 0; i < 200; i++) {
        double target = 1e6 + i / 7.0;
        CHECK_INT(traj_joint(1, &(traj_state){0}, &target, &l, TRAJ_S_CURVE, TRAJ_SOONEST, p->axes, &p->fault), TRAJ_OK);
        check_inside(p->axes, &l, TRAJ_S_CURVE);
        check_continuous(p->axes, &l, TRAJ_S_CURVE);
        check_end(p->axes, target);
    }
    free(p);
}

/* What rounding exceeds the limits by is not refused, and still there at the end. */
static void a_start_may_be_a_rounding_beyond_the_limits(void)
{
    plan *p = new_plan(TRAJ_SEGMENTS);
    traj_limits l = {100, 1000, 20000};
    const traj_state starts[] = {{0, 100 * (1 + 9e-10), 0}, {0, 75 * (1 + 9e-10), 1000}, {0, -75, -1000 * (1 + 4e-10)}};
    for (int i = 0; i < 30; i++) {
        traj_state start = starts[i % 3];
        double target = i < 3 ? 50 : pow(-1.7, i - 15);
        CHECK_INT(traj_joint(1, &start, &target, &l, TRAJ_S_CURVE, TRAJ_SOONEST, p->axes, &p->fault), TRAJ_OK);
        check_near_start(p->axes, &start, TRAJ_S_CURVE);
        check_continuous(p->axes, &l, TRAJ_S_CURVE);
        check_end(p->axes, target);
    }
    /* the target that it reaches when it brakes as the limits let it is that of no sooner plan */
    double stop_at = 100 * 0.15 / 2;
    CHECK_INT(traj_joint(1, starts, &stop_at, &l, TRAJ_S_CURVE, TRAJ_SOONEST, p->axes, &p->fault), TRAJ_OK);
    check_continuous(p->axes, &l, TRAJ_S_CURVE);
    free(p);
}

static void axes_end_together_when_asked_to(void)
{
    plan *p = new_plan(TRAJ_SEGMENTS);
    uint64_t seed = 2;
    for (int i = 0; i < 3000; i++) {
        enum { AXES = 4 };
        traj_kind kind = i % 2 ? TRAJ_S_CURVE : TRAJ_TRAPEZOID;
        traj_limits l[AXES];
        traj_state starts[AXES];
        double targets[AXES];
        for (int k = 0; k < AXES; k++) {
            l[k] = any_limits(&seed);
            starts[k] = any_start(&seed, &l[k], kind);
            if (chance(&seed) < 0.5) starts[k].velocity = starts[k].acceleration = 0;
            targets[k] = starts[k].position + (chance(&seed) < 0.1 ? 0 : any_distance(&seed));
        }
        CHECK_INT(traj_joint(AXES, starts, targets, l, kind, TRAJ_SOONEST, p->axes, &p->fault), TRAJ_OK);
        int64_t least_ns = p->axes->duration_ns;
        CHECK_INT(traj_joint(AXES, starts, targets, l, kind, least_ns - 1, p->axes, &p->fault), TRAJ_TOO_SHORT);
        CHECK_INT(p->fault.least_ns, least_ns);
        int64_t asked_ns = (int64_t)((double)least_ns * (i % 3 ? between(&seed, 1, 10) : 1));
        if (asked_ns < least_ns) asked_ns = least_ns;
        CHECK_INT(traj_joint(AXES, starts, targets, l, kind, asked_ns, p->axes, &p->fault), TRAJ_OK);
        for (int k = 0; k < AXES; k++) {
            CHECK_INT(p->axes[k].duration_ns, asked_ns);
            check_near_start(&p->axes[k], &starts[k], kind);
            check_inside(&p->axes[k], &l[k], kind);
            check_continuous(&p->axes[k], &l[k], kind);
            check_end(&p->axes[k], targets[k]);
        }
    }
    free(p);
}

static void a_line_is_straight_and_so_is_its_stop(void)
{
    enum { AXES = 5 };
    plan *p = new_plan(TRAJ_SEGMENTS), *stop = new_plan(TRAJ_SEGMENTS);
    uint64_t seed = 3;
    for (int i = 0; i < 3000; i++) {
        traj_kind kind = i % 2 ? TRAJ_S_CURVE : TRAJ_TRAPEZOID;
        traj_limits l[AXES];
        double from[AXES], to[AXES];
        for (int k = 0; k < AXES; k++) {
            l[k] = any_limits(&seed);
            from[k] = between(&seed, -1e3, 1e3);
            to[k] = from[k] + (chance(&seed) < 0.2 ? 0 : any_distance(&seed));
        }
        CHECK_INT(traj_line(AXES, from, to, l, kind, TRAJ_SOONEST, &p->axes[AXES], p->axes, &p->fault), TRAJ_OK);
        int64_t at_ns = (int64_t)((double)p->axes->duration_ns * between(&seed, 0, 1.1));
        CHECK_INT(traj_stop(AXES, p->axes, &p->axes[AXES], at_ns, l, kind, &stop->axes[AXES], stop->axes, &stop->fault), TRAJ_OK);
        for (int k = 0; k < AXES; k++) {
            check_inside(&p->axes[k], &l[k], kind);
            check_continuous(&p->axes[k], &l[k], kind);
            check_end(&p->axes[k], to[k]);
            check_inside(&stop->axes[k], &l[k], kind);
            CHECK(stop->axes[k].duration_ns == stop->axes->duration_ns);
        }
        for (int n = 0; n <= 20; n++) {
            double part = traj_at(&p->axes[AXES], p->axes->duration_ns * n / 20).position / p->axes[AXES].to;
            double part_stop = traj_at(&stop->axes[AXES], stop->axes->duration_ns * n / 20).position / p->axes[AXES].to;
            for (int k = 0; k < AXES && p->axes[AXES].to > 0; k++) {
                double small = 1e-12 * (fabs(from[k]) + fabs(to[k]));
                CHECK_NEAR(traj_at(&p->axes[k], p->axes->duration_ns * n / 20).position, from[k] + part * (to[k] - from[k]), small);
                CHECK_NEAR(traj_at(&stop->axes[k], stop->axes->duration_ns * n / 20).position,
                           from[k] + part_stop * (to[k] - from[k]), small);
            }
        }
    }
    free(p);
    free(stop);
}

static void a_stop_is_smooth_and_within_limits(void)
{
    plan *p = new_plan(TRAJ_SEGMENTS), *stop = new_plan(TRAJ_SEGMENTS);
    uint64_t seed = 4;
    for (int i = 0; i < 5000; i++) {
        traj_kind kind = i % 2 ? TRAJ_S_CURVE : TRAJ_TRAPEZOID;
        traj_limits l = any_limits(&seed);
        traj_state start = any_start(&seed, &l, kind);
        double target = start.position + any_distance(&seed);
        CHECK_INT(traj_joint(1, &start, &target, &l, kind, TRAJ_SOONEST, p->axes, &p->fault), TRAJ_OK);
        int64_t at_ns = (int64_t)((double)p->axes->duration_ns * chance(&seed));
        traj_state now = traj_at(p->axes, at_ns);
        CHECK_INT(traj_stop(1, p->axes, NULL, at_ns, &l, kind, NULL, stop->axes, &stop->fault), TRAJ_OK);
        check_near_start(stop->axes, &now, kind);
        check_inside(stop->axes, &l, kind);
        check_continuous(stop->axes, &l, kind);
        check_end(stop->axes, stop->axes->to);
    }
    free(p);
    free(stop);
}

/* A start beyond the limits comes back within them: the acceleration at once, then the velocity. */
static void a_velocity_is_reached_from_anywhere(void)
{
    plan *p = new_plan(TRAJ_SEGMENTS);
    traj_limits l = {100, 1000, 20000};
    traj_state start = {10, 500, 3000};
    double velocity = -50;
    CHECK_INT(traj_velocity(1, &start, &velocity, &l, TRAJ_S_CURVE, p->axes, &p->fault), TRAJ_OK);
    check_continuous(p->axes, &(traj_limits){1000, 3000, 20000}, TRAJ_S_CURVE);
    traj_state end = traj_at(p->axes, p->axes->duration_ns), later = traj_at(p->axes, p->axes->duration_ns + 2000000000);
    CHECK(end.velocity == -50 && end.acceleration == 0);
    CHECK_NEAR(later.position, end.position - 100, 1e-9);
    /* to 0 in 150 ms, gaining 225 deg/s; then 725 + 50 at 1000 deg/s2, with 50 ms of it for the jerk */
    CHECK_NEAR(p->axes->duration, 0.15 + 0.775 + 0.05, 1e-12);
    start = (traj_state){0, 95, 3000}; /* as above, but to more than the jerk alone leads to */
    velocity = 100;
    l.jerk = 1e6;
    CHECK_INT(traj_velocity(1, &start, &velocity, &l, TRAJ_S_CURVE, p->axes, &p->fault), TRAJ_OK);
    CHECK_NEAR(p->axes->duration, 0.003 + 0.0005, 1e-12);
    check_continuous(p->axes, &(traj_limits){1000, 3000, 1e6}, TRAJ_S_CURVE);
    free(p);
}

static void what_cannot_be_planned_is_named(void)
{
    plan *p = new_plan(TRAJ_SEGMENTS);
    const traj_limits good = {100, 1000, 20000};
    struct {
        traj_state start;
        double target;
        traj_limits limits;
        int64_t duration_ns;
        traj_error want;
    } cases[] = {
        {{NAN, 0, 0}, 1, good, TRAJ_SOONEST, TRAJ_NOT_FINITE},
        {{0, INFINITY, 0}, 1, good, TRAJ_SOONEST, TRAJ_NOT_FINITE},
        {{0, 0, -INFINITY}, 1, good, TRAJ_SOONEST, TRAJ_NOT_FINITE},
        {{0, 0, 0}, NAN, good, TRAJ_SOONEST, TRAJ_NOT_FINITE},
        {{0, 0, 0}, 1, {INFINITY, 1, 1}, TRAJ_SOONEST, TRAJ_NOT_FINITE},
        {{0, 0, 0}, 1, {1, NAN, 1}, TRAJ_SOONEST, TRAJ_NOT_FINITE},
        {{0, 0, 0}, 1, {0, 1, 1}, TRAJ_SOONEST, TRAJ_LIMIT_NOT_POSITIVE},
        {{0, 0, 0}, 1, {1, -1, 1}, TRAJ_SOONEST, TRAJ_LIMIT_NOT_POSITIVE},
        {{0, 0, 0}, 1, {1, 1, 0}, TRAJ_SOONEST, TRAJ_LIMIT_NOT_POSITIVE},
        {{0, 101, 0}, 1, good, TRAJ_SOONEST, TRAJ_START_BEYOND_LIMITS},
        {{0, 0, 1001}, 1, good, TRAJ_SOONEST, TRAJ_START_BEYOND_LIMITS},
        {{0, 99, 1000}, 1, good, TRAJ_SOONEST, TRAJ_START_BEYOND_LIMITS},
        {{0, 0, 0}, 1, good, 1000, TRAJ_TOO_SHORT},
        {{0, 0, 0}, 1, good, -5, TRAJ_TOO_SHORT},
        {{0, 0, 0}, 0, good, -1, TRAJ_TOO_SHORT},
        {{0, 0, 0}, 0, good, 0, TRAJ_OK},
        {{0, 0, 0}, 0, good, 1000, TRAJ_OK},
        {{0, 0, 0}, 1, good, INT64_MAX, TRAJ_OUT_OF_RANGE},
        {{0, 0, 0}, 1e308, good, TRAJ_SOONEST, TRAJ_OUT_OF_RANGE},
        {{-1e308, 0, 0}, 1e308, good, TRAJ_SOONEST, TRAJ_OUT_OF_RANGE},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        traj_state starts[2] = {{0, 0, 0}, cases[i].start};
        double targets[2] = {0, cases[i].target};
        traj_limits limits[2] = {good, cases[i].limits};
        traj_error error = traj_joint(2, starts, targets, limits, TRAJ_S_CURVE, cases[i].duration_ns, p->axes, &p->fault);
        if (error != cases[i].want) CHECK_FAILED("case %zu: %d, not %d", i, (int)error, (int)cases[i].want);
    }
    CHECK_INT(traj_joint(0, NULL, NULL, NULL, TRAJ_S_CURVE, TRAJ_SOONEST, p->axes, &p->fault), TRAJ_NO_AXES);
    CHECK_INT(traj_joint(65, NULL, NULL, NULL, TRAJ_S_CURVE, TRAJ_SOONEST, p->axes, &p->fault), TRAJ_TOO_MANY_AXES);
    CHECK_INT(traj_line(65, NULL, NULL, NULL, TRAJ_S_CURVE, TRAJ_SOONEST, p->axes, p->axes, &p->fault), TRAJ_TOO_MANY_AXES);
    CHECK_INT(traj_velocity(1, &(traj_state){0}, &(double){101}, &good, TRAJ_S_CURVE, p->axes, &p->fault), TRAJ_TARGET_BEYOND_LIMIT);
    CHECK_INT(traj_line(1, &(double){0}, &(double){NAN}, &good, TRAJ_S_CURVE, TRAJ_SOONEST, &p->axes[1], p->axes, &p->fault),
              TRAJ_NOT_FINITE);
    CHECK_INT(p->fault.axis, 0);
    p->axes->room = 2;
    CHECK_INT(traj_joint(1, &(traj_state){0}, &(double){1}, &good, TRAJ_S_CURVE, TRAJ_SOONEST, p->axes, &p->fault), TRAJ_NO_ROOM);
    free(p);
}

/* Whatever the bits: an answer or a named error, and with an answer everything in it finite. */
static void no_bits_crash_it(void)
{
    plan *p = new_plan(TRAJ_SEGMENTS), *stop = new_plan(TRAJ_SEGMENTS);
    uint64_t seed = 6;
    int planned = 0;
    for (int i = 0; i < 100000; i++) {
        double x[14];
        for (int k = 0; k < 14; k++) {
            int is_limit = k >= 8, is_wild = chance(&seed) < 0.05;
            x[k] = pow(10, is_wild ? between(&seed, -320, 309) : between(&seed, -3, 5));
            if ((!is_limit || is_wild) && chance(&seed) < 0.5) x[k] = -x[k];
            if (!is_limit && chance(&seed) < 0.3) x[k] = 0;
        }
        traj_state starts[2] = {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}};
        traj_limits l[2] = {{x[8], x[9], x[10]}, {x[11], x[12], x[13]}};
        traj_kind kind = i % 2 ? TRAJ_S_CURVE : TRAJ_TRAPEZOID;
        traj_error error = i % 4 < 2 ? traj_joint(2, starts, &x[6], l, kind, TRAJ_SOONEST, p->axes, &p->fault)
                                     : traj_line(2, x, &x[6], l, kind, TRAJ_SOONEST, &p->axes[2], p->axes, &p->fault);
        CHECK(error >= TRAJ_OK && error <= TRAJ_OUT_OF_RANGE);
        if (error) continue;
        planned++;
        for (int n = 0; n <= 10; n++) {
            int64_t at_ns = (int64_t)((double)p->axes->duration_ns * n / 10);
            traj_state s = traj_at(&p->axes[n % 2], at_ns);
            CHECK(isfinite(s.position) && isfinite(s.velocity) && isfinite(s.acceleration));
            error = traj_stop(2, p->axes, i % 4 < 2 ? NULL : &p->axes[2], at_ns, l, kind, &stop->axes[2], stop->axes, &stop->fault);
            CHECK(error == TRAJ_OK || error == TRAJ_OUT_OF_RANGE);
        }
    }
    CHECK(planned > 10000);
    free(p);
    free(stop);
}

void trajectory_tests(void)
{
    RUN(one_axis_keeps_its_limits_and_ends_exactly);
    RUN(known_times);
    RUN(a_long_cruise_does_not_blur_its_ends);
    RUN(a_start_may_be_a_rounding_beyond_the_limits);
    RUN(axes_end_together_when_asked_to);
    RUN(a_line_is_straight_and_so_is_its_stop);
    RUN(a_stop_is_smooth_and_within_limits);
    RUN(a_velocity_is_reached_from_anywhere);
    RUN(what_cannot_be_planned_is_named);
    RUN(no_bits_crash_it);
}
