/* The set-point at each control step is the path's, to the last bit, whatever is going on around it. */
#include "../batch.h"

#include "fixture.h"

#define PIECES 4
#define AXES 9

/* With jerk, a piece of no length and one that is no whole number of control steps. */
static const hil_path_piece PATH[PIECES] = {
    {.duration_ns = 10000001, .r = 3.25, .per_s = 0, .per_s2 = 0, .per_s3 = 6e5},
    {.duration_ns = 0, .r = 3.35, .per_s = 30, .per_s2 = 6000},
    {.duration_ns = 25000000, .r = 3.35, .per_s = 30, .per_s2 = 600, .per_s3 = -12345.678},
    {.duration_ns = 33333333, .r = 4.2, .per_s = 40, .per_s2 = -1200},
};
static const int64_t LENGTH_NS = 68333334;

/* What the path says so long after its beginning. */
static float wanted_r(int64_t into_ns)
{
    int i = 0;
    for (; i < PIECES - 1 && into_ns > PATH[i].duration_ns; i++) into_ns -= PATH[i].duration_ns;
    if (into_ns > PATH[i].duration_ns) into_ns = PATH[i].duration_ns;
    const hil_path_piece *p = &PATH[i];
    double t = (double)into_ns * 1e-9;
    return (float)(p->r + t * (p->per_s + t * (p->per_s2 / 2 + t * p->per_s3 / 6)));
}

static float get_r(hil_core *c, int axis) { return (float)hil_axis_get(c, axis, HIL_FIELD_r); }
static int is_following(hil_core *c, int axis) { return (int)hil_axis_get(c, axis, HIL_FIELD_following); }

/* A core whose only axis holds its angle, at a time between two control steps. */
static hil_core *holding(int64_t *now_ns)
{
    hil_core *c = new_bench();
    hil_axis_set(c, 0, HIL_FIELD_mode, 'x');
    hil_axis_loop(c, 0, 1);
    *now_ns = step_ns(3) + 4321;
    hil_group_advance(c, 0, *now_ns);
    return c;
}

static void each_step_has_the_paths_set_point(void)
{
    int64_t since_ns;
    hil_core *c = holding(&since_ns);
    CHECK_INT(hil_axis_follow(c, 0, 0, PIECES, PATH), 0);
    CHECK_INT(is_following(c, 0), 1);
    CHECK(get_r(c, 0) == 0); /* until the next control step */
    int64_t k = 4;
    for (; step_ns(k) - since_ns < LENGTH_NS; k++) {
        hil_group_advance(c, 0, step_ns(k) - 1);
        CHECK(k == 4 || get_r(c, 0) == wanted_r(step_ns(k - 1) - since_ns));
        hil_group_advance(c, 0, step_ns(k));
        CHECK(get_r(c, 0) == wanted_r(step_ns(k) - since_ns));
        CHECK_INT(is_following(c, 0), 1);
    }
    CHECK_INT(k, 448);
    hil_group_advance(c, 0, step_ns(k));
    CHECK(get_r(c, 0) == wanted_r(LENGTH_NS));
    CHECK_INT(is_following(c, 0), 0);
    hil_group_advance(c, 0, step_ns(k) + 1000000000);
    CHECK(get_r(c, 0) == wanted_r(LENGTH_NS));
    hil_core_free(c);
}

/* What is to begin later leaves the set-point alone until then, and begins at that very time. */
static void a_later_start_is_kept(void)
{
    int64_t now_ns;
    hil_core *c = holding(&now_ns);
    int64_t start_ns = step_ns(40) + 12345;
    hil_axis_set(c, 0, HIL_FIELD_r, 7);
    CHECK_INT(hil_axis_follow(c, 0, start_ns, PIECES, PATH), 0);
    hil_group_advance(c, 0, step_ns(40));
    CHECK(get_r(c, 0) == 7);
    CHECK_INT(is_following(c, 0), 1);
    for (int64_t k = 41; k < 400; k++) {
        hil_group_advance(c, 0, step_ns(k));
        CHECK(get_r(c, 0) == wanted_r(step_ns(k) - start_ns));
    }
    hil_core_free(c);
}

/* However time is cut, and with a look at it in between. */
static void cuts_do_not_matter(void)
{
    hil_snapshot whole, cut;
    for (uint64_t seed = 0; seed < 12; seed++) {
        int64_t since_ns;
        hil_core *c = holding(&since_ns);
        hil_axis_follow(c, 0, 0, PIECES, PATH);
        uint64_t random = seed + 1;
        int64_t end_ns = since_ns + 90000000;
        for (int64_t now_ns = since_ns; seed && now_ns < end_ns;) {
            now_ns += 1 + random_below(&random, seed % 3 ? 400000 : 5000);
            if (now_ns > end_ns) now_ns = end_ns;
            hil_group_advance(c, 0, now_ns);
            hil_axis_snapshot(c, 0, &cut);
        }
        hil_group_advance(c, 0, end_ns);
        hil_axis_snapshot(c, 0, seed ? &cut : &whole);
        CHECK(!seed || !memcmp(&whole, &cut, sizeof whole));
        hil_core_free(c);
    }
}

/* Alone, and as one or several of nine whose others go in lanes. */
static void company_does_not_matter(void)
{
    int groups[AXES];
    for (int i = 0; i < AXES; i++) groups[i] = i;
    for (int followers = 1; followers <= AXES; followers += 4) {
        hil_core *batched = new_core(AXES), *alone = new_core(AXES);
        hil_core *both[] = {batched, alone};
        for (int which = 0; which < 2; which++)
            for (int i = 0; i < AXES; i++) {
                open_axis(both[which], open_group(both[which], 0));
                hil_axis_set(both[which], i, HIL_FIELD_mode, 'x');
                hil_axis_set(both[which], i, HIL_FIELD_r, i);
                hil_axis_loop(both[which], i, 1);
                hil_group_advance(both[which], i, 2000000 + i * 31);
                if (i < followers) CHECK_INT(hil_axis_follow(both[which], i, 0, PIECES, PATH), 0);
            }
        uint64_t random = (uint64_t)followers;
        for (int64_t now_ns = 3000000; now_ns < 100000000; now_ns += random_below(&random, 3000000)) {
            batch_advance(batched, groups, AXES, now_ns);
            for (int i = 0; i < AXES; i++) {
                hil_snapshot a, b;
                hil_group_advance(alone, i, now_ns);
                hil_axis_snapshot(batched, i, &a);
                hil_axis_snapshot(alone, i, &b);
                CHECK(!memcmp(&a, &b, sizeof a));
            }
        }
        for (int i = 0; i < AXES; i++) CHECK(get_r(batched, i) == (i < followers ? wanted_r(LENGTH_NS) : (float)i));
        hil_core_free(batched);
        hil_core_free(alone);
    }
}

static void set_r(hil_core *c) { hil_axis_set(c, 0, HIL_FIELD_r, 7); }
static void set_mode(hil_core *c) { hil_axis_set(c, 0, HIL_FIELD_mode, 'x'); }
static void loop_off(hil_core *c) { hil_axis_loop(c, 0, 0); }
static void power_up(hil_core *c) { hil_axis_power_up(c, 0); }
static void enable_pin(hil_core *c) { hil_axis_pin(c, 0, 2, 1); }
static void no_path(hil_core *c) { hil_axis_follow(c, 0, 0, 0, NULL); }
static void set_gain(hil_core *c) { hil_axis_set(c, 0, HIL_FIELD_pKp, 3); }
static void set_load(hil_core *c) { hil_axis_set(c, 0, HIL_FIELD_load_torque_Nm, 0.01); }

static void what_ends_a_path(void)
{
    static void (*const ENDS[])(hil_core *) = {set_r, set_mode, loop_off, power_up, enable_pin, no_path};
    static void (*const LEAVES[])(hil_core *) = {set_gain, set_load};
    int64_t now_ns;
    for (size_t i = 0; i < sizeof ENDS / sizeof *ENDS; i++) {
        hil_core *c = holding(&now_ns);
        hil_axis_follow(c, 0, 0, PIECES, PATH);
        hil_group_advance(c, 0, now_ns + 20000000);
        float before = get_r(c, 0);
        ENDS[i](c);
        CHECK_INT(is_following(c, 0), 0);
        float after = get_r(c, 0);
        CHECK(after == (ENDS[i] == set_r ? 7.0f : ENDS[i] == power_up ? 0.0f : before));
        hil_axis_loop(c, 0, 1);
        hil_group_advance(c, 0, now_ns + 200000000);
        CHECK(get_r(c, 0) == after);
        hil_core_free(c);
    }
    for (size_t i = 0; i < sizeof LEAVES / sizeof *LEAVES; i++) {
        hil_core *c = holding(&now_ns);
        hil_axis_follow(c, 0, 0, PIECES, PATH);
        hil_group_advance(c, 0, now_ns + 20000000);
        LEAVES[i](c);
        hil_group_advance(c, 0, now_ns + 200000000);
        CHECK(get_r(c, 0) == wanted_r(LENGTH_NS));
        hil_core_free(c);
    }
}

/* A path begins when it is asked for, in place of the one before. */
static void a_path_takes_the_place_of_another(void)
{
    int64_t now_ns;
    hil_core *c = holding(&now_ns);
    const hil_path_piece up[] = {{.duration_ns = 1000000000, .r = 0, .per_s = 100}, {.r = 100}};
    hil_axis_follow(c, 0, 0, 2, up);
    for (int turn = 0; turn < 5; turn++) {
        now_ns += 3000000;
        hil_group_advance(c, 0, now_ns);
        CHECK_INT(hil_axis_follow(c, 0, 0, PIECES, PATH), 0);
    }
    hil_group_advance(c, 0, step_ns(200));
    CHECK(get_r(c, 0) == wanted_r(step_ns(200) - now_ns));
    const hil_path_piece point = {.r = -2.5};
    hil_axis_follow(c, 0, 0, 1, &point); /* of no length: at the next control step */
    hil_group_advance(c, 0, step_ns(201) - 1);
    CHECK(get_r(c, 0) == wanted_r(step_ns(200) - now_ns));
    hil_group_advance(c, 0, step_ns(201));
    CHECK(get_r(c, 0) == -2.5f);
    CHECK_INT(is_following(c, 0), 0);
    hil_core_free(c);
}

/* A control step at the very end of a piece, before the next one begins. */
static void a_path_goes_on_behind_a_piece_that_ends_with_a_step(void)
{
    int64_t since_ns;
    hil_core *c = holding(&since_ns);
    const int64_t first_ns = step_ns(100) - since_ns;
    const double end = (double)first_ns * 1e-9 * 100;
    const hil_path_piece pieces[] = {
        {.duration_ns = first_ns, .r = 0, .per_s = 100}, {.duration_ns = 1000000000, .r = end, .per_s = -50}, {.r = end - 50}};
    CHECK_INT(hil_axis_follow(c, 0, 0, 3, pieces), 0);
    hil_group_advance(c, 0, step_ns(100));
    CHECK(get_r(c, 0) == (float)end);
    CHECK_INT(is_following(c, 0), 1);
    hil_group_advance(c, 0, step_ns(110));
    CHECK(get_r(c, 0) == (float)(end + (double)(step_ns(110) - step_ns(100)) * 1e-9 * -50));
    hil_core_free(c);
}

static void what_is_no_path_is_refused_and_the_one_before_goes_on(void)
{
    int64_t since_ns;
    hil_core *c = holding(&since_ns);
    CHECK_INT(hil_axis_follow(c, 0, 0, PIECES, PATH), 0);
    hil_group_advance(c, 0, since_ns + 5000000);
    const double BAD[] = {NAN, INFINITY, -INFINITY};
    for (int i = 0; i < 12; i++) {
        hil_path_piece pieces[2] = {{.duration_ns = 1000, .r = 1}, {.duration_ns = 1000, .r = 1}};
        double *fields[] = {&pieces[1].r, &pieces[1].per_s, &pieces[1].per_s2, &pieces[1].per_s3};
        *fields[i % 4] = BAD[i / 4];
        CHECK_INT(hil_axis_follow(c, 0, 0, 2, pieces), -2);
    }
    const hil_path_piece backwards = {.duration_ns = -1}, too_long = {.duration_ns = HIL_PATH_NS + 1};
    const hil_path_piece half[] = {{.duration_ns = HIL_PATH_NS / 2}, {.duration_ns = HIL_PATH_NS / 2 + 1}};
    const hil_path_piece ages[] = {{.duration_ns = INT64_MAX}, {.duration_ns = INT64_MAX}};
    CHECK_INT(hil_axis_follow(c, 0, 0, 1, &backwards), -2);
    CHECK_INT(hil_axis_follow(c, 0, 0, 1, &too_long), -2);
    CHECK_INT(hil_axis_follow(c, 0, 0, 2, half), -2);
    CHECK_INT(hil_axis_follow(c, 0, 0, 2, ages), -2);
    hil_group_advance(c, 0, step_ns(100));
    CHECK(get_r(c, 0) == wanted_r(step_ns(100) - since_ns));
    const hil_path_piece longest = {.duration_ns = HIL_PATH_NS, .r = 1};
    CHECK_INT(hil_axis_follow(c, 0, 0, 1, &longest), 0);
    hil_group_advance(c, 0, step_ns(200));
    CHECK(get_r(c, 0) == 1 && is_following(c, 0));
    hil_core_free(c);
}

/* ASan tells of what is left behind. */
static void closed_groups_leave_nothing(void)
{
    hil_core *c = new_core(2);
    for (int turn = 0; turn < 10; turn++) {
        int group = open_group(c, 0);
        int axis = open_axis(c, group);
        hil_axis_set(c, axis, HIL_FIELD_mode, 'x');
        hil_axis_loop(c, axis, 1);
        CHECK_INT(is_following(c, axis), 0);
        CHECK_INT(hil_axis_follow(c, axis, 0, PIECES, PATH), 0);
        hil_group_advance(c, group, 5000000);
        CHECK_INT(is_following(c, axis), 1);
        hil_group_close(c, group);
    }
    int axis = open_axis(c, open_group(c, 0)); /* and it goes with the core */
    hil_axis_follow(c, axis, 0, PIECES, PATH);
    hil_core_free(c);
}

void follow_tests(void)
{
    RUN(each_step_has_the_paths_set_point);
    RUN(a_later_start_is_kept);
    RUN(cuts_do_not_matter);
    RUN(company_does_not_matter);
    RUN(what_ends_a_path);
    RUN(a_path_goes_on_behind_a_piece_that_ends_with_a_step);
    RUN(a_path_takes_the_place_of_another);
    RUN(what_is_no_path_is_refused_and_the_one_before_goes_on);
    RUN(closed_groups_leave_nothing);
}
