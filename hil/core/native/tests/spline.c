/* Splines: points, smoothness, rest at the ends, and how they stand to limits. */
#include "trajectory_fixture.h"

static void any_points(uint64_t *seed, int points, int64_t *times_ns, double *positions)
{
    times_ns[0] = (int64_t)between(seed, -1e12, 1e12);
    for (int i = 0; i < points; i++) {
        positions[i] = between(seed, -180, 180);
        if (i > 0) times_ns[i] = times_ns[i - 1] + (int64_t)pow(10, between(seed, 6, 10));
    }
}

static void a_spline_passes_its_points_smoothly_from_rest_to_rest(void)
{
    plan *p = new_plan(MOST_POINTS + 1);
    uint64_t seed = 5;
    for (int i = 0; i < 2000; i++) {
        int64_t times_ns[MOST_POINTS];
        double positions[MOST_POINTS];
        int points = 2 + (int)(chance(&seed) * (MOST_POINTS - 2));
        any_points(&seed, points, times_ns, positions);
        CHECK_INT(traj_spline(points, times_ns, positions, p->axes), TRAJ_OK);
        traj_violation_found found;
        traj_limits l = {1, 1, 1};
        double factor = traj_fit(1, p->axes, &l, TRAJ_S_CURVE), most_v = 0, most_a = 0;
        CHECK(factor > 1 && traj_violation(1, p->axes, &l, TRAJ_S_CURVE, &found));
        for (int k = 0; k < p->axes->count; k++) {
            most_v = fmax(most_v, fabs(p->axes->segments[k].v));
            most_a = fmax(most_a, fabs(p->axes->segments[k].a));
        }
        for (int k = 0; k < points; k++)
            CHECK_NEAR(traj_at(p->axes, times_ns[k] - times_ns[0]).position, positions[k], 1e-9 * scale_of(p->axes));
        check_continuous(p->axes, &(traj_limits){most_v, most_a, 1}, TRAJ_S_CURVE);
        CHECK_INT(p->axes->duration_ns, times_ns[points - 1] - times_ns[0]);
        check_near_start(p->axes, &(traj_state){positions[0], 0, 0}, TRAJ_S_CURVE);
        check_end(p->axes, positions[points - 1]);
        CHECK_INT(traj_stretch(p->axes, factor), TRAJ_OK);
        check_inside(p->axes, &l, TRAJ_S_CURVE);
        CHECK_NEAR(traj_fit(1, p->axes, &l, TRAJ_S_CURVE), 1, 1e-9);
    }
    free(p);
}

/* Two points 1 deg and 3 s apart: accelerations 0, 1, -1, 0 deg/s2 at whole seconds, by hand. */
static void a_known_spline(void)
{
    plan *p = new_plan(3);
    traj_violation_found found;
    CHECK_INT(traj_spline(2, (int64_t[]){5, 3000000005}, (double[]){1, 2}, p->axes), TRAJ_OK);
    CHECK_INT(p->axes->count, 3);
    CHECK_NEAR(traj_at(p->axes, 1000000000).acceleration, 1, 1e-12);
    CHECK_NEAR(traj_at(p->axes, 1000000000).position, 1 + 1.0 / 6, 1e-12);
    CHECK_NEAR(traj_at(p->axes, 1500000000).velocity, 0.75, 1e-12);
    CHECK(!traj_violation(1, p->axes, &(traj_limits){0.75, 1, 2}, TRAJ_S_CURVE, &found));
    CHECK(traj_violation(1, p->axes, &(traj_limits){0.7, 1, 2}, TRAJ_S_CURVE, &found));
    CHECK(found.quantity == TRAJ_VELOCITY && found.limit == 0.7);
    CHECK_INT(found.at_ns, 1500000000);
    CHECK_NEAR(found.value, 0.75, 1e-12);
    CHECK(traj_violation(1, p->axes, &(traj_limits){0.7, 0.9, 2}, TRAJ_S_CURVE, &found));
    CHECK(found.quantity == TRAJ_ACCELERATION);
    CHECK_INT(found.at_ns, 1000000000);
    CHECK_INT(traj_spline(2, (int64_t[]){INT64_MIN, INT64_MAX}, (double[]){1, 2}, p->axes), TRAJ_OUT_OF_RANGE);
    CHECK_INT(traj_spline(2, (int64_t[]){1, 1}, (double[]){1, 2}, p->axes), TRAJ_POINTS_OUT_OF_ORDER);
    CHECK_INT(traj_spline(2, (int64_t[]){2, 1}, (double[]){1, 2}, p->axes), TRAJ_POINTS_OUT_OF_ORDER);
    CHECK_INT(traj_spline(1, (int64_t[]){1}, (double[]){1}, p->axes), TRAJ_TOO_FEW_POINTS);
    CHECK_INT(traj_spline(3, (int64_t[]){1, 2, 3}, (double[]){1, 2, 3}, p->axes), TRAJ_NO_ROOM);
    CHECK_INT(traj_spline(2, (int64_t[]){1, 2}, (double[]){1, NAN}, p->axes), TRAJ_NOT_FINITE);
    CHECK_INT(traj_spline(2, (int64_t[]){1, 2}, (double[]){-1e308, 1e308}, p->axes), TRAJ_OUT_OF_RANGE);
    free(p);
}

void spline_tests(void)
{
    RUN(a_spline_passes_its_points_smoothly_from_rest_to_rest);
    RUN(a_known_spline);
}
