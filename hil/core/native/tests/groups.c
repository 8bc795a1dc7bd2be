/* Groups, their time and their events: core.c. */
#define _GNU_SOURCE
#include <sys/resource.h>
#include <time.h>

#include "fixture.h"

static void stops_at_the_horizon(void)
{
    hil_core *c = new_core(1);
    int group = hil_group_open(c, 500);
    open_axis(c, group);
    hil_axis_loop(c, 0, 1);
    CHECK_INT(hil_group_now(c, group), 500);
    CHECK_INT(hil_group_advance(c, group, 1000000), 500); /* no firmware has said how far yet */
    hil_group_set_horizon(c, group, 500 + step_ns(3));
    CHECK_INT(hil_group_advance(c, group, HIL_FOREVER), 500 + step_ns(3));
    CHECK_INT(hil_axis_get(c, 0, HIL_FIELD_control_steps), 3);
    CHECK_INT(hil_axis_get(c, 0, HIL_FIELD_at_ns), 500 + step_ns(3));
    hil_group_set_horizon(c, group, HIL_FOREVER);
    CHECK_INT(hil_group_advance(c, group, 500 + step_ns(4) - 1), 500 + step_ns(4) - 1);
    CHECK_INT(hil_axis_get(c, 0, HIL_FIELD_control_steps), 3);
    CHECK_INT(hil_group_advance(c, group, 100), 500 + step_ns(4) - 1); /* never back */
    hil_core_free(c);
}

static void no_horizon_and_no_loop(void)
{
    hil_core *c = new_core(2);
    int group = open_group(c, 0);
    CHECK_INT(hil_group_advance(c, group, HIL_FOREVER), HIL_FOREVER); /* a group without an axis */
    group = open_group(c, 0);
    open_axis(c, group);
    CHECK_INT(hil_group_advance(c, group, HIL_FOREVER), HIL_FOREVER); /* the rotor comes to rest on the way */
    hil_core_free(c);
}

static void half_full_ring_holds_time(void)
{
    hil_core *c = new_bench();
    hil_event e;
    hil_axis_set(c, 0, HIL_FIELD_print_yw, 1);
    hil_axis_loop(c, 0, 1);
    int64_t half_ns = step_ns(5 * RING_MOST / 2);
    CHECK_INT(hil_group_advance(c, 0, 2 * half_ns), half_ns);
    CHECK_INT(hil_group_advance(c, 0, 2 * half_ns), half_ns);
    CHECK_INT(hil_axis_get(c, 0, HIL_FIELD_control_steps), 5 * RING_MOST / 2);
    for (int i = 1; i <= RING_MOST / 2; i++) {
        CHECK_INT(hil_group_take_event(c, 0, &e), 1);
        CHECK(e.at_ns == step_ns(5 * i) && e.kind == HIL_EVENT_STEP_RESPONSE && e.axis == 0);
        if (i == 1) CHECK_INT(hil_group_advance(c, 0, 2 * half_ns), step_ns(5 * (RING_MOST / 2 + 1)));
    }
    CHECK_INT(hil_group_take_event(c, 0, &e), 1);
    CHECK_INT(hil_group_take_event(c, 0, &e), 0);
    CHECK_INT(hil_group_advance(c, 0, 2 * half_ns), 2 * half_ns);
    CHECK_INT(hil_group_failed(c, 0), 0);
    hil_core_free(c);
}

/* Also when another axis has a step at the same time: it runs before the group stops there. */
static void half_full_ring_stops_both_axes(void)
{
    hil_core *c = new_core(2);
    hil_event e;
    open_group(c, 0);
    for (int axis = 0; axis < 2; axis++) {
        open_axis(c, 0);
        hil_axis_set(c, axis, HIL_FIELD_print_yw, axis == 0);
        hil_axis_loop(c, axis, 1);
    }
    int64_t now_ns = hil_group_advance(c, 0, 2000000000);
    CHECK_INT(now_ns, step_ns(5 * RING_MOST / 2));
    CHECK_INT(hil_axis_get(c, 0, HIL_FIELD_control_steps), 5 * RING_MOST / 2);
    CHECK_INT(hil_axis_get(c, 1, HIL_FIELD_control_steps), 5 * RING_MOST / 2);
    while (hil_group_take_event(c, 0, &e)) CHECK_INT(e.axis, 0);
    hil_core_free(c);
}

static void full_ring_fails(void)
{
    hil_core *c = new_bench();
    for (int i = 0; i < RING_MOST; i++) hil_axis_pin(c, 0, 2, !(i & 1));
    CHECK_INT(hil_group_failed(c, 0), 0);
    hil_axis_pin(c, 0, 2, 1);
    CHECK_INT(hil_group_failed(c, 0), 1);
    hil_event e;
    int n = 0;
    while (hil_group_take_event(c, 0, &e)) CHECK_INT(e.value, !(n++ & 1));
    CHECK_INT(n, RING_MOST);
    hil_group_close(c, 0);
    CHECK_INT(open_group(c, 7), 0);
    CHECK_INT(hil_group_failed(c, 0), 0);
    hil_core_free(c);
}

static void control_steps_do_not_drift(void)
{
    hil_core *c = new_bench();
    static const int64_t SINCE_NS = 1234567891;
    hil_group_advance(c, 0, SINCE_NS);
    hil_axis_loop(c, 0, 1);
    for (int64_t k = 1; k <= 10000000; k = k < 1000 ? k + 1 : k * 10) {
        CHECK_INT(advance_to(c, 0, SINCE_NS + step_ns(k) - 1), SINCE_NS + step_ns(k) - 1);
        CHECK_INT(hil_axis_get(c, 0, HIL_FIELD_control_steps), k - 1);
        hil_group_advance(c, 0, SINCE_NS + step_ns(k));
        CHECK_INT(hil_axis_get(c, 0, HIL_FIELD_control_steps), k);
    }
    hil_axis_loop(c, 0, 0); /* again: from the new time */
    int64_t again_ns = hil_group_advance(c, 0, hil_group_now(c, 0) + 1000);
    hil_axis_loop(c, 0, 1);
    hil_axis_loop(c, 0, 1);
    hil_group_advance(c, 0, again_ns + step_ns(1) - 1);
    CHECK_INT(hil_axis_get(c, 0, HIL_FIELD_control_steps), 10000000);
    hil_group_advance(c, 0, again_ns + step_ns(1));
    CHECK_INT(hil_axis_get(c, 0, HIL_FIELD_control_steps), 10000001);
    hil_core_free(c);
}

static void slots_are_used_again(void)
{
    hil_core *c = new_core(3);
    static const int64_t at_ns[] = {0}, raw[] = {99};
    for (int round = 0; round < 5; round++) {
        int group = open_group(c, round);
        for (int i = 0; i < 3; i++) CHECK_INT(open_axis(c, group), i);
        hil_axis_script_encoder(c, 1, 1, at_ns, raw, 0);
        hil_axis_set(c, 1, HIL_FIELD_r, 5);
        hil_axis_pin(c, 1, 2, 1);
        CHECK_INT(open_axis(c, group), -1);
        CHECK_INT(open_group(c, 0), 1);
        CHECK_INT(open_group(c, 0), 2);
        CHECK_INT(open_group(c, 0), -1);
        hil_group_close(c, 1);
        hil_group_close(c, group);
        CHECK_INT(open_group(c, 1000), 0);
        CHECK_INT(open_axis(c, 0), 0);
        CHECK_INT(open_axis(c, 0), 1);
        hil_event e;
        CHECK_INT(hil_group_take_event(c, 0, &e), 0);
        hil_snapshot s;
        hil_axis_published(c, 1, &s); /* opening publishes: none of the axis before */
        CHECK(s.at_ns == 1000 && s.r == 0 && s.raw == 0 && s.pin_enable == 0);
        hil_group_close(c, 0);
        hil_group_close(c, 2);
    }
    hil_core_free(c);
}

static void two_axes_in_time_order(void)
{
    hil_core *c = new_core(2);
    hil_event e, before = {0};
    int seen[2] = {0, 0};
    open_group(c, 0);
    for (int axis = 0; axis < 2; axis++) {
        open_axis(c, 0);
        hil_axis_set(c, axis, HIL_FIELD_print_yw, 1);
        hil_axis_loop(c, axis, 1);
    }
    hil_group_advance(c, 0, 100000000);
    while (hil_group_take_event(c, 0, &e)) { /* in step: at each time axis 0 and then axis 1 */
        int n = seen[0] + seen[1];
        CHECK_INT(e.axis, n % 2);
        CHECK_INT(e.at_ns, step_ns(5 * (n / 2 + 1)));
        seen[e.axis]++;
        before = e;
    }
    CHECK_INT(seen[0], 129);
    CHECK_INT(seen[1], 129);
    hil_axis_loop(c, 0, 0);
    hil_axis_loop(c, 0, 1); /* from now on out of step */
    hil_group_advance(c, 0, 200000000);
    for (seen[0] = seen[1] = 0; hil_group_take_event(c, 0, &e); before = e) {
        CHECK(e.at_ns > before.at_ns);
        seen[e.axis]++;
    }
    CHECK(seen[0] >= 129 && seen[1] >= 129);
    hil_core_free(c);
}

static void hundred_cores(void)
{
    enum { CORES = 100 };
    hil_core *c[CORES];
    hil_snapshot s, alone;
    for (int i = 0; i < CORES; i++) {
        c[i] = new_bench();
        hil_axis_set(c[i], 0, HIL_FIELD_mode, 'x');
        hil_axis_set(c[i], 0, HIL_FIELD_r, i % 10);
        hil_axis_loop(c[i], 0, 1);
    }
    for (int64_t t_ns = 0; t_ns <= 20000000; t_ns += 1000000)
        for (int i = 0; i < CORES; i++) hil_group_advance(c[i], 0, t_ns);
    for (int i = 0; i < 10; i++) {
        hil_axis_snapshot(c[i], 0, &alone);
        CHECK_INT(alone.control_steps, 129);
        for (int j = i; j < CORES; j += 10) {
            hil_axis_snapshot(c[j], 0, &s);
            CHECK(!memcmp(&s, &alone, sizeof s));
        }
    }
    for (int i = 0; i < CORES; i++) hil_core_free(c[i]);
}

static void refuses_no_axes(void)
{
    int fd;
    CHECK(!hil_core_new(0, &fd));
    CHECK(!hil_core_new(-1, &fd));
}

static void refuses_without_memory_or_descriptor(void)
{
    struct rlimit before, no_descriptor;
    int fd;
    getrlimit(RLIMIT_NOFILE, &before);
    no_descriptor = before;
    no_descriptor.rlim_cur = 0;
    setrlimit(RLIMIT_NOFILE, &no_descriptor);
    CHECK(!hil_core_new(1, &fd));
    setrlimit(RLIMIT_NOFILE, &before);
    CHECK(!hil_core_new(INT32_MAX, &fd)); /* 250 TB */
}

/* ---- one run, advanced whole or in random chunks ---- */

enum { ACTIONS = 300, MOST_EVENTS = 20000 };

typedef struct record {
    hil_snapshot snapshot[ACTIONS][2];
    hil_event event[MOST_EVENTS];
    int events;
} record;

static void drain(hil_core *c, record *r)
{
    while (r->events < MOST_EVENTS && hil_group_take_event(c, 0, &r->event[r->events])) r->events++;
}

static void reach(hil_core *c, record *r, int64_t t_ns, uint64_t *chunks)
{
    hil_snapshot s;
    while (hil_group_now(c, 0) < t_ns) {
        int64_t now_ns = hil_group_now(c, 0), until_ns = t_ns;
        if (*chunks) {
            static const int64_t LENGTHS[] = {2, 1000, 154000, 1000000, 40000000};
            until_ns = now_ns + 1 + random_below(chunks, LENGTHS[random_below(chunks, 5)]);
            if (until_ns > t_ns) until_ns = t_ns;
            if (random_below(chunks, 3) == 0) hil_axis_snapshot(c, (int)random_below(chunks, 2), &s);
            if (random_below(chunks, 3) == 0) hil_axis_get(c, (int)random_below(chunks, 2), HIL_FIELD_position_deg);
        }
        hil_group_set_horizon(c, 0, *chunks && random_below(chunks, 2) ? until_ns : HIL_FOREVER);
        hil_group_advance(c, 0, until_ns);
        drain(c, r);
    }
}

static void act(hil_core *c, uint64_t *plan, int64_t now_ns)
{
    static const char MODES[] = {'x', 'v', 't', 'h', 0, 'x', 'v'};
    int axis = (int)random_below(plan, 2);
    double amount = (double)random_below(plan, 2001) / 10 - 100;
    int64_t at_ns[2] = {now_ns, now_ns + 30000000}, raw[2] = {random_below(plan, 30000), random_below(plan, 30000) - 15000};
    switch (random_below(plan, 12)) {
    case 0: hil_axis_loop(c, axis, 0); break;
    case 1: case 2: hil_axis_loop(c, axis, 1); break;
    case 3: hil_axis_set(c, axis, HIL_FIELD_mode, MODES[random_below(plan, 7)]); break;
    case 4: case 5: hil_axis_set(c, axis, HIL_FIELD_r, amount); break;
    case 6: hil_axis_set(c, axis, HIL_FIELD_load_torque_Nm, amount / 1000); break;
    case 7: hil_axis_pin(c, axis, (int)random_below(plan, 4), (int)random_below(plan, 2)); break;
    case 8: hil_axis_output(c, axis, (float)amount, 60); break;
    case 9: hil_axis_script_encoder(c, axis, (int)random_below(plan, 3) ? 0 : 2, at_ns, raw, 1); break;
    case 10: hil_axis_set(c, axis, HIL_FIELD_print_yw, (double)random_below(plan, 2)); break;
    default: hil_axis_spi(c, axis, 0xFFFF);
    }
}

static void scripted_run(record *r, uint64_t chunks)
{
    hil_core *c = new_core(2);
    uint64_t plan = 6;
    memset(r, 0, sizeof *r);
    open_group(c, 0);
    for (int axis = 0; axis < 2; axis++) {
        open_axis(c, 0);
        hil_axis_set(c, axis, HIL_FIELD_print_yw, 1);
        hil_axis_loop(c, axis, 1);
    }
    int64_t t_ns = 0;
    for (int i = 0; i < ACTIONS; i++) {
        t_ns += random_below(&plan, i % 50 ? 8000000 : 3000000000);
        reach(c, r, t_ns, &chunks);
        for (int axis = 0; axis < 2; axis++) hil_axis_snapshot(c, axis, &r->snapshot[i][axis]);
        act(c, &plan, t_ns);
    }
    drain(c, r);
    hil_core_free(c);
}

static void chunks_change_nothing(void)
{
    static record whole, chunked;
    scripted_run(&whole, 0);
    CHECK(whole.events > 1000 && whole.events < MOST_EVENTS);
    for (uint64_t seed = 1; seed <= 6; seed++) {
        scripted_run(&chunked, seed);
        CHECK_INT(chunked.events, whole.events);
        CHECK(!memcmp(chunked.snapshot, whole.snapshot, sizeof whole.snapshot));
        CHECK(!memcmp(chunked.event, whole.event, sizeof whole.event));
    }
}

static double wall_us(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e6 + (double)t.tv_nsec / 1e3;
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Medians, printed and not judged: the sanitizers slow them down. */
static void creation_is_timed(void)
{
    enum { RUNS = 21 };
    double creation_us[RUNS], power_up_us[RUNS];
    for (int i = 0; i < RUNS; i++) {
        double from_us = wall_us();
        hil_core *c = new_core(2);
        for (int axis = 0; axis < 2; axis++) hil_axis_open(c, hil_group_open(c, 0), &MECHADUINO);
        creation_us[i] = wall_us() - from_us;
        from_us = wall_us();
        hil_axis_power_up(c, 0);
        power_up_us[i] = wall_us() - from_us;
        hil_core_free(c);
    }
    qsort(creation_us, RUNS, sizeof *creation_us, by_size);
    qsort(power_up_us, RUNS, sizeof *power_up_us, by_size);
    printf("a core with 2 axes is made in %.0f us, an axis powered up in %.1f us (under the sanitizers)\n",
           creation_us[RUNS / 2], power_up_us[RUNS / 2]);
}

void groups_tests(void)
{
    RUN(stops_at_the_horizon);
    RUN(no_horizon_and_no_loop);
    RUN(half_full_ring_holds_time);
    RUN(half_full_ring_stops_both_axes);
    RUN(full_ring_fails);
    RUN(control_steps_do_not_drift);
    RUN(slots_are_used_again);
    RUN(two_axes_in_time_order);
    RUN(hundred_cores);
    RUN(refuses_no_axes);
    RUN(refuses_without_memory_or_descriptor);
    RUN(chunks_change_nothing);
    RUN(creation_is_timed);
}
