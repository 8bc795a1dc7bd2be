/* Signal sources on the inputs, and samples. */
#include "fixture.h"

static int step_level(hil_core *c, int64_t at_ns)
{
    hil_group_advance(c, 0, at_ns);
    return (int)hil_axis_get(c, 0, HIL_FIELD_pin_step);
}

static void every_edge_is_where_the_formula_has_it(void)
{
    uint64_t random = 7;
    for (int round = 0; round < 50; round++) {
        hil_core *c = new_bench();
        int64_t start_ns = random_below(&random, 1000000000);
        hil_group_advance(c, 0, start_ns);
        int64_t steps = 1 + random_below(&random, 40), duration_ns = 2 * steps + random_below(&random, 100000000);
        int64_t at_ns = random_below(&random, 1000000);
        CHECK_INT(hil_axis_drive(c, 0, 1, &(hil_edges){.at_ns = at_ns, .steps = steps, .duration_ns = duration_ns}), 0);
        CHECK_INT(step_level(c, start_ns + at_ns - 1 < start_ns ? start_ns : start_ns + at_ns - 1), at_ns == 0);
        for (int64_t j = 0; j < 2 * steps; j++) {
            int64_t edge_ns = start_ns + at_ns + (int64_t)((__int128)j * duration_ns / (2 * steps));
            if (j > 0) CHECK_INT(step_level(c, edge_ns - 1), j % 2 == 1);
            CHECK_INT(step_level(c, edge_ns), j % 2 == 0);
        }
        hil_group_advance(c, 0, start_ns + INT64_C(10000000000));
        CHECK_NEAR(hil_axis_get(c, 0, HIL_FIELD_r), (double)steps * 1.8 / 32, 1e-4);
        hil_core_free(c);
    }
}

static void two_hundred_kilohertz_lose_no_step(void)
{
    hil_core *c = new_bench();
    hil_edges rows[] = {{.at_ns = 0, .pin = 0, .level = 1}, {.at_ns = 0, .steps = 200000, .duration_ns = 1000000000}};
    hil_axis_drive(c, 0, 2, rows);
    for (int i = 1; i <= 1000; i++) hil_group_advance(c, 0, i * INT64_C(1000000) + i % 7);
    float r = 0; /* the board's r is a float32 sum too */
    for (int i = 0; i < 200000; i++) r -= 1.8f / 32;
    CHECK(hil_axis_get(c, 0, HIL_FIELD_r) == (double)r);
    CHECK_INT((int)hil_axis_get(c, 0, HIL_FIELD_pin_dir), 1);
    hil_core_free(c);
}

/* At one time the edge comes first: the control step sees the new set-point. */
static void an_edge_comes_before_the_control_step_of_its_time(void)
{
    double e[2];
    for (int late = 0; late < 2; late++) {
        hil_core *c = new_bench();
        hil_axis_set(c, 0, HIL_FIELD_mode, 'x');
        hil_axis_loop(c, 0, 1);
        hil_axis_drive(c, 0, 1, &(hil_edges){.at_ns = step_ns(1) + late, .pin = 1, .level = 1});
        hil_group_advance(c, 0, step_ns(1) + late);
        e[late] = hil_axis_get(c, 0, HIL_FIELD_e);
        CHECK_NEAR(hil_axis_get(c, 0, HIL_FIELD_r), 0.05625, 1e-6);
        hil_core_free(c);
    }
    CHECK_NEAR(e[0] - e[1], 0.05625, 1e-6);
}

static void a_new_source_ends_the_old_one(void)
{
    hil_core *c = new_bench();
    hil_axis_drive(c, 0, 1, &(hil_edges){.at_ns = 0, .steps = 1000, .duration_ns = 1000000000});
    hil_group_advance(c, 0, 99500000);
    hil_axis_drive(c, 0, 0, NULL);
    hil_group_advance(c, 0, 5000000000);
    CHECK_NEAR(hil_axis_get(c, 0, HIL_FIELD_r), 100 * 1.8 / 32, 1e-4);
    hil_core_free(c);
}

/* The same bits, however often time was cut, and whoever watched. */
static void cuts_and_watchers_change_nothing(void)
{
    uint64_t random = 3;
    hil_snapshot whole, cut;
    for (int way = 0; way < 2; way++) {
        hil_core *c = new_bench();
        hil_axis_set(c, 0, HIL_FIELD_mode, 'x');
        hil_axis_loop(c, 0, 1);
        hil_edges rows[] = {{.at_ns = 5000000, .steps = 77, .duration_ns = 31234567},
                            {.at_ns = 40000000, .pin = 2, .level = 1}, {.at_ns = 45000001, .pin = 2, .level = 0},
                            {.at_ns = 50000000, .steps = 400, .duration_ns = 100000003}};
        hil_axis_drive(c, 0, 4, rows);
        if (way) {
            hil_axis_watch(c, 0, 0, 99991, 1, 16);
            for (int64_t t = 0; t < 200000000; t += 1 + random_below(&random, 900000)) hil_group_advance(c, 0, t);
        }
        hil_group_advance(c, 0, 200000000);
        hil_axis_snapshot(c, 0, way ? &cut : &whole);
        hil_core_free(c);
    }
    CHECK(!memcmp(&whole, &cut, sizeof whole));
}

static void samples_stand_on_the_grid_and_lost_ones_are_counted(void)
{
    hil_core *c = new_bench();
    hil_snapshot s[200], now;
    hil_axis_set(c, 0, HIL_FIELD_mode, 'x');
    hil_axis_loop(c, 0, 1);
    hil_group_advance(c, 0, 1234567);
    hil_axis_watch(c, 0, 0, 1000000, 1, 100);
    hil_group_advance(c, 0, 11500000);
    CHECK_INT(hil_axis_take_samples(c, 0, 0, s, 200), 10);
    for (int i = 0; i < 10; i++) CHECK_INT(s[i].at_ns, (i + 2) * 1000000);
    hil_group_advance(c, 0, 12000000);
    hil_axis_snapshot(c, 0, &now);
    CHECK_INT(hil_axis_take_samples(c, 0, 0, s, 200), 1);
    CHECK(!memcmp(&now, &s[0], sizeof now));
    hil_group_advance(c, 0, 162000000);
    CHECK_INT(hil_axis_lost_samples(c, 0, 0), 50);
    CHECK_INT(hil_axis_take_samples(c, 0, 0, s, 200), 100);
    CHECK_INT(s[0].at_ns, 13000000);
    CHECK_INT(s[99].at_ns, 112000000);
    hil_axis_watch(c, 0, 0, 0, 1, 1);
    hil_group_advance(c, 0, 200000000);
    CHECK_INT(hil_axis_take_samples(c, 0, 0, s, 200), 0);
    hil_core_free(c);
}

/* Whatever waits when some are taken, it comes in order, also around the ring's end. */
static void a_ring_runs_around(void)
{
    hil_core *c = new_bench();
    hil_snapshot s[5];
    int64_t taken = 0;
    hil_axis_watch(c, 0, 0, 1000000, 1, 5);
    for (int64_t ms = 0; taken < 100; ms += 3) { /* three come each time: five places are enough */
        int n = hil_axis_take_samples(c, 0, 0, s, ms % 2 ? 2 : 4);
        for (int i = 0; i < n; i++) CHECK_INT(s[i].at_ns, ++taken * 1000000);
        hil_group_advance(c, 0, ms * 1000000);
    }
    CHECK_INT(hil_axis_lost_samples(c, 0, 0), 0);
    hil_core_free(c);
}

/* 30 samples a second do not stand a whole number of ns apart; 1 ms and 1.000001 ms have hardly one time in common. */
static void each_watch_has_its_own_grid(void)
{
    hil_core *c = new_bench();
    hil_snapshot s[2000];
    hil_group_advance(c, 0, 1234567);
    hil_axis_watch(c, 0, 0, 1000000, 1, 2000);
    hil_axis_watch(c, 0, 16, 1000001, 1, 2000);
    hil_axis_watch(c, 0, 3, 1000000000, 30, 2000);
    hil_group_advance(c, 0, 1000000000);
    CHECK_INT(hil_axis_take_samples(c, 0, 0, s, 2000), 999);
    for (int i = 0; i < 999; i++) CHECK_INT(s[i].at_ns, (i + 2) * INT64_C(1000000));
    CHECK_INT(hil_axis_take_samples(c, 0, 16, s, 2000), 998);
    for (int i = 0; i < 998; i++) CHECK_INT(s[i].at_ns, (i + 2) * INT64_C(1000001));
    CHECK_INT(hil_axis_take_samples(c, 0, 3, s, 2000), 30);
    for (int i = 0; i < 30; i++) CHECK_INT(s[i].at_ns, (i + 1) * INT64_C(1000000000) / 30);
    hil_axis_watch(c, 0, 16, 0, 1, 1);
    hil_group_advance(c, 0, 1002000000);
    CHECK_INT(hil_axis_take_samples(c, 0, 0, s, 2000), 2);
    CHECK_INT(hil_axis_take_samples(c, 0, 16, s, 2000), 0);
    hil_core_free(c);
}

/* Against all that was seen: of each seven times a pair with the two extremes, in their order. */
static void extremes_are_those_of_what_was_seen(void)
{
    enum { POINTS = 7, SEEN = 1400 };
    hil_core *c = new_bench();
    static hil_snapshot all[SEEN + POINTS], pairs[SEEN];
    hil_axis_set(c, 0, HIL_FIELD_mode, 'x');
    hil_axis_loop(c, 0, 1);
    hil_axis_drive(c, 0, 2, (hil_edges[]){{.at_ns = 0, .steps = 600, .duration_ns = 60000000},
                                          {.at_ns = 70000000, .pin = 2, .level = 1}});
    hil_group_advance(c, 0, 1000000); /* the first interval is cut: 10 of its 14.0 ms / 20 have gone */
    hil_axis_watch(c, 0, 0, 100000, 1, SEEN + POINTS);
    hil_axis_watch_extremes(c, 0, 1, 100000, 1, POINTS, SEEN);
    hil_group_advance(c, 0, 1000000 + (SEEN - 10 % POINTS) * INT64_C(100000));
    int n = hil_axis_take_samples(c, 0, 0, all, SEEN + POINTS), kept = hil_axis_take_samples(c, 0, 1, pairs, SEEN), pair = 0;
    CHECK_INT(kept, 2 * (SEEN / POINTS));
    for (int i = 0; i < n && pair < kept; pair += 2) {
        int first = i;
        hil_snapshot least = all[i], most = all[i];
        int is_most_last = 0;
        for (; i < n && (i == first || all[i - 1].at_ns / 100000 % POINTS); i++) {
            if (all[i].current_a_A < least.current_a_A) least = all[i], is_most_last = 0;
            if (all[i].current_a_A > most.current_a_A) most = all[i], is_most_last = 1;
        }
        CHECK_INT(pairs[pair].at_ns, all[first].at_ns);
        CHECK_INT(pairs[pair + 1].at_ns, all[i - 1].at_ns);
        CHECK(pairs[pair + is_most_last].current_a_A == most.current_a_A);
        CHECK(pairs[pair + !is_most_last].current_a_A == least.current_a_A);
        CHECK(pairs[pair].control_steps == all[first].control_steps);
    }
    CHECK_INT(pair, kept);
    hil_axis_watch_extremes(c, 0, 1, 100000, 1, POINTS, 1); /* a pair for which there is no room is lost, or its second */
    hil_group_advance(c, 0, hil_group_now(c, 0) + 2 * POINTS * 100000);
    CHECK_INT(hil_axis_take_samples(c, 0, 1, pairs, SEEN), 1);
    CHECK_INT(hil_axis_lost_samples(c, 0, 1), 3);
    hil_core_free(c);
}

static void a_grid_that_begins_late_stands_where_it_would(void)
{
    hil_core *c = new_bench();
    hil_snapshot s[10];
    int64_t later_ns = INT64_C(1) << 61;
    hil_group_advance(c, 0, later_ns);
    hil_axis_watch(c, 0, 0, 1000000000, 7, 10);
    hil_group_advance(c, 0, later_ns + 1000000000);
    CHECK_INT(hil_axis_take_samples(c, 0, 0, s, 10), 7);
    for (int i = 0; i < 7; i++) { /* by the definition */
        __int128 k = ((__int128)later_ns + 1) * 7 / 1000000000 + 1 + i;
        CHECK_INT(s[i].at_ns, (int64_t)(k * 1000000000 / 7));
    }
    hil_core_free(c);
}

/* Whoever asks for 146 years gets them in parts, and the parts are what the whole would be. */
static void one_call_does_only_so_much(void)
{
    hil_core *c = new_bench(), *other = new_bench();
    int64_t years_ns = INT64_C(1) << 62, now_ns = 0;
    CHECK_INT(hil_group_advance(c, 0, 1000000000), 1000000000);
    CHECK_INT(hil_group_advance(other, 0, 1000000000), 1000000000);
    const hil_edges fast = {.pin = 1, .steps = 1000000000, .duration_ns = INT64_C(5000000000000)};
    hil_core *both[] = {c, other};
    for (int i = 0; i < 2; i++) {
        hil_axis_set(both[i], 0, HIL_FIELD_mode, 'x');
        hil_axis_loop(both[i], 0, 1);
        CHECK_INT(hil_axis_drive(both[i], 0, 1, &fast), 0);
    }
    for (int i = 0; i < 3; i++) {
        int64_t before_ns = hil_group_now(c, 0);
        now_ns = hil_group_advance(c, 0, years_ns);
        CHECK(now_ns > before_ns + 100000000 && now_ns < before_ns + INT64_C(2000000000));
    }
    for (int64_t t = 1000000000; t < now_ns; t += 777777) hil_group_advance(other, 0, t);
    advance_to(other, 0, now_ns);
    hil_snapshot parts, whole;
    hil_axis_snapshot(c, 0, &parts);
    hil_axis_snapshot(other, 0, &whole);
    CHECK(!memcmp(&parts, &whole, sizeof parts));
    hil_core_free(c);
    hil_core_free(other);
}

/* Nothing happens to an idle axis, however long: one call takes it there. */
static void idle_axes_cost_no_time(void)
{
    hil_core *c = new_bench();
    hil_group_advance(c, 0, 1000000000);
    CHECK_INT(hil_group_advance(c, 0, INT64_C(1) << 62), INT64_C(1) << 62);
    hil_core_free(c);
}

/* First the levels that inputs have, of those that were ever set; then what changes, at the source's own times. */
static void edges_of_inputs_are_kept(void)
{
    hil_core *c = new_bench();
    hil_edge edges[8];
    const hil_edges rows[] = {{.at_ns = 5, .steps = 2, .duration_ns = 40}, {.at_ns = 50, .pin = 2, .level = 1}};
    hil_axis_pin(c, 0, 0, 1);
    hil_group_advance(c, 0, 1000);
    CHECK_INT(hil_axis_take_inputs(c, 0, edges, 8), 0);
    hil_axis_record_inputs(c, 0, 7);
    hil_axis_pin(c, 0, 0, 1); /* as it was */
    CHECK_INT(hil_axis_drive(c, 0, 2, rows), 0);
    hil_group_advance(c, 0, 2000);
    static const hil_edge expected[] = {{1000, 0, 1}, {1005, 1, 1}, {1015, 1, 0}, {1025, 1, 1}, {1035, 1, 0}, {1050, 2, 1}};
    CHECK_INT(hil_axis_take_inputs(c, 0, edges, 4), 4);
    CHECK_INT(hil_axis_take_inputs(c, 0, edges + 4, 4), 2);
    CHECK(!memcmp(edges, expected, sizeof expected));
    hil_axis_record_inputs(c, 0, 0);
    hil_axis_pin(c, 0, 2, 0);
    CHECK_INT(hil_axis_take_inputs(c, 0, edges, 8), 0);
    CHECK_INT(hil_axis_output_levels(c, 0), 0); /* it has none */
    hil_core_free(c);
}

void source_tests(void)
{
    RUN(edges_of_inputs_are_kept);
    RUN(every_edge_is_where_the_formula_has_it);
    RUN(two_hundred_kilohertz_lose_no_step);
    RUN(an_edge_comes_before_the_control_step_of_its_time);
    RUN(a_new_source_ends_the_old_one);
    RUN(cuts_and_watchers_change_nothing);
    RUN(samples_stand_on_the_grid_and_lost_ones_are_counted);
    RUN(a_ring_runs_around);
    RUN(each_watch_has_its_own_grid);
    RUN(extremes_are_those_of_what_was_seen);
    RUN(a_grid_that_begins_late_stands_where_it_would);
    RUN(one_call_does_only_so_much);
    RUN(idle_axes_cost_no_time);
}
