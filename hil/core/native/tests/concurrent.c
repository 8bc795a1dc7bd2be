/* The real-time thread and who owns a group, under the thread sanitizer. Whether the thread got
   SCHED_FIFO, a CPU and locked memory makes no difference to these tests. */
#define _GNU_SOURCE
#include <errno.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include "fixture.h"
#include "threads.h"

check_counts check_state;

void shared_tests(void);
void pty_lines_threads_tests(void);

static const hil_rt_options EVERY_MS = {.period_ns = 1000000, .speed = 1, .priority = 50, .cpu = -1};

static void start(hil_core *c, const hil_rt_options *options)
{
    errno = hil_rt_start(c, options);
    if (errno) {
        perror("hil_rt_start");
        exit(2);
    }
}

static void check_stats(const hil_core *c, int64_t period_ns)
{
    hil_rt_stats s;
    hil_rt_stats_read(c, &s);
    CHECK_INT(s.ticks + s.missed, s.elapsed_ns / period_ns);
    CHECK(s.missed >= 0 && s.overruns >= 0 && s.overruns <= s.ticks);
    uint64_t wakes = 0;
    for (int i = 0; i < HIL_HISTOGRAM_LEN; i++) wakes += s.wake_latency[i];
    CHECK_INT((int64_t)wakes, s.ticks);
}

static int64_t ticks(const hil_core *c)
{
    hil_rt_stats s;
    hil_rt_stats_read(c, &s);
    return s.ticks;
}

/* Until the thread has woken n more times; 10 s at most. */
static void wait_ticks(const hil_core *c, int64_t n)
{
    int64_t until = ticks(c) + n, deadline_ns = wall_ns() + 10000000000;
    while (ticks(c) < until && wall_ns() < deadline_ns) sched_yield();
    CHECK(ticks(c) >= until);
}

/* Control steps of a loop switched on at 0 that are due up to and at t_ns: step_ns(k) <= t_ns. */
static int64_t steps_until(int64_t t_ns) { return (48 * (t_ns + 1) + 7385000 - 1) / 7385000 - 1; }

typedef struct reader {
    const hil_core *core;
    int64_t period_ns;
    _Atomic int stop;
    int64_t looks, newest_ns, wrong;
} reader;

/* Any thread's part: published snapshots, times, stats. Axis 0's loop has run since 0. */
static void *look(void *argument)
{
    reader *r = argument;
    int64_t group_ns = 0, rt_ns = 0;
    hil_snapshot s;
    hil_rt_stats stats;
    while (!atomic_load(&r->stop)) {
        hil_axis_published(r->core, 0, &s);
        r->wrong += s.control_steps != steps_until(s.at_ns) || s.at_ns < r->newest_ns;
        r->newest_ns = s.at_ns;
        hil_axis_published(r->core, 1, &s); /* opened and closed all the time: new (or never), or with both set */
        r->wrong += s.r != (float)s.uMAX && !(s.r == 0 && s.uMAX == 115);
        hil_rt_stats_read(r->core, &stats);
        r->wrong += stats.ticks + stats.missed != stats.elapsed_ns / r->period_ns;
        int64_t now_ns = hil_group_now(r->core, 0), wanted_ns = hil_rt_now(r->core);
        r->wrong += now_ns < group_ns || wanted_ns < rt_ns || hil_group_failed(r->core, 0);
        group_ns = now_ns;
        rt_ns = wanted_ns;
        r->looks++;
    }
    return NULL;
}

/* The loop thread's work on group 0, which it owns, as a daemon does it: catch up, act, leave a horizon. */
static void work(hil_core *c, int64_t *events, int64_t *last_event_ns)
{
    hil_event e;
    int64_t now_ns = hil_group_now(c, 0), wanted_ns = hil_rt_now(c);
    CHECK(now_ns <= wanted_ns);
    hil_group_set_horizon(c, 0, HIL_FOREVER);
    while (hil_group_advance(c, 0, wanted_ns) < wanted_ns) {
        while (hil_group_take_event(c, 0, &e)) {
            CHECK(e.at_ns > *last_event_ns);
            *last_event_ns = e.at_ns;
            ++*events;
        }
    }
    hil_axis_set(c, 0, HIL_FIELD_r, (double)(wanted_ns % 100));
    hil_axis_pin(c, 0, 1, 1);
    hil_axis_pin(c, 0, 1, 0);
    hil_axis_table(c, 0)[0] = (float)(wanted_ns % 2) / 1000;
    CHECK_INT(hil_axis_get(c, 0, HIL_FIELD_at_ns), wanted_ns);
    hil_group_set_horizon(c, 0, wanted_ns + 3000000);
    hil_group_release(c, 0);
}

/* A second group comes and goes; after its opening, every snapshot of its axis has r == uMAX. */
static void come_and_go(hil_core *c, int round)
{
    int group = hil_group_open(c, hil_rt_now(c));
    CHECK_INT(group, 1);
    hil_axis_params params = MECHADUINO;
    CHECK_INT(hil_axis_open(c, group, &params), 1);
    hil_axis_set(c, 1, HIL_FIELD_uMAX, round);
    hil_axis_set(c, 1, HIL_FIELD_r, round);
    hil_axis_set(c, 1, HIL_FIELD_print_yw, 1); /* events that nobody takes: it is due at every wake */
    if (round & 1) { /* made some time before it is set going, as a reload does */
        wait_ticks(c, 1);
        int64_t now_ns = hil_rt_now(c);
        hil_group_set_horizon(c, group, now_ns);
        CHECK_INT(hil_group_advance(c, group, now_ns), now_ns);
    }
    hil_axis_loop(c, 1, 1);
    hil_group_set_horizon(c, group, HIL_FOREVER);
    hil_group_release(c, group);
    wait_ticks(c, 2);
    CHECK(hil_group_now(c, group) > 0);
    if (round & 2) hil_group_acquire(c, group); /* close takes it where the caller forgot to */
    hil_group_close(c, group);
    int64_t closed_ns = hil_group_now(c, group);
    wait_ticks(c, 1);
    CHECK_INT(hil_group_now(c, group), closed_ns);
}

static void owners_take_turns(void)
{
    enum { MS = 1500 };
    hil_rt_options options = EVERY_MS;
    options.period_ns = 300000;
    hil_core *c = new_core(2);
    int due[2], event_fd = c->event_fd, served = 0, round = 0;
    int64_t events = 0, last_event_ns = -1;
    hil_group_open(c, 0);
    open_axis(c, 0);
    hil_axis_set(c, 0, HIL_FIELD_mode, 'x');
    hil_axis_set(c, 0, HIL_FIELD_print_yw, 1);
    hil_axis_loop(c, 0, 1);
    hil_group_set_horizon(c, 0, 0);
    start(c, &options);
    reader r = {.core = c, .period_ns = options.period_ns};
    pthread_t thread = spawn(look, &r);
    work(c, &events, &last_event_ns);
    for (int64_t end_ns = wall_ns() + MS * INT64_C(1000000); wall_ns() < end_ns;) {
        struct pollfd p = {.fd = event_fd, .events = POLLIN};
        poll(&p, 1, 1000);
        for (int n = hil_rt_take_due(c, due, 2), i = 0; i < n; i++) {
            CHECK_INT(due[i], 0); /* never the group that is closed again */
            served++;
            hil_group_acquire(c, 0);
            work(c, &events, &last_event_ns);
        }
        check_stats(c, options.period_ns);
        if (served % 8 == 0) come_and_go(c, ++round);
    }
    atomic_store(&r.stop, 1);
    pthread_join(thread, NULL);
    hil_rt_stop(c);
    CHECK_INT(r.wrong, 0);
    CHECK(r.looks > 100 && r.newest_ns > 0);
    CHECK(served > 20 && round > 2 && events > 100);
    CHECK_INT(hil_axis_get(c, 0, HIL_FIELD_control_steps), steps_until(hil_group_now(c, 0)));
    hil_core_free(c);
}

static void starts_and_stops(void)
{
    hil_core *c = new_core(2);
    int64_t stopped_ns = 0;
    hil_rt_options bad = EVERY_MS;
    bad.period_ns = 0;
    CHECK_INT(hil_rt_start(c, &bad), EINVAL);
    bad.period_ns = INT64_MAX;
    CHECK_INT(hil_rt_start(c, &bad), EINVAL);
    static const double SPEEDS[] = {-1, NAN};
    for (int i = 0; i < 2; i++) {
        bad = EVERY_MS;
        bad.speed = SPEEDS[i];
        CHECK_INT(hil_rt_start(c, &bad), EINVAL);
    }
    hil_rt_stop(c); /* not running: nothing */
    open_axis(c, open_group(c, 0));
    open_axis(c, open_group(c, 0));
    hil_group_release(c, 0);
    hil_group_release(c, 1);
    for (int i = 0; i < 3; i++) {
        hil_rt_stats s;
        start(c, &EVERY_MS);
        hil_rt_stats_read(c, &s);
        CHECK_INT(s.running, 1);
        CHECK(s.ticks < 1000); /* none of the run before */
        CHECK_INT(hil_rt_start(c, &EVERY_MS), EALREADY);
        wait_ticks(c, 5);
        while (hil_rt_now(c) <= stopped_ns) sched_yield(); /* time goes on from run to run */
        wait_ticks(c, 2);
        hil_rt_stop(c);
        hil_rt_stats_read(c, &s);
        CHECK_INT(s.running, 0);
        check_stats(c, EVERY_MS.period_ns);
        CHECK(hil_group_now(c, 0) > stopped_ns);
        if (i == 0) {
            stopped_ns = hil_group_now(c, 1);
            hil_group_close(c, 1); /* free, and no thread: the next thread must not enter it */
        }
        CHECK_INT(hil_group_now(c, 1), stopped_ns);
    }
    hil_core_free(c); /* also stops it */
}

static void refused_permissions_are_known_at_start(void)
{
    hil_core *c = new_core(1);
    hil_rt_options options = EVERY_MS;
    options.priority = 1000; /* no such priority */
    options.cpu = 100000;
    hil_rt_stats s;
    start(c, &options);
    hil_rt_stats_read(c, &s);
    CHECK_INT(s.fifo_errno, EINVAL);
    CHECK_INT(s.pin_errno, EINVAL);
    hil_core_free(c);
}

/* More to do than there is time: no group starves, the books stay right, stop is prompt, and a group
   without a loop, which costs nothing, keeps up. */
static void too_much_work_is_shared(void)
{
    enum { GROUPS = 4 };
    hil_core *c = new_core(GROUPS);
    hil_rt_options options = EVERY_MS;
    options.speed = 1000;
    for (int i = 0; i < GROUPS; i++) {
        open_axis(c, open_group(c, 0));
        if (i < GROUPS - 1) hil_axis_loop(c, i, 1);
    }
    start(c, &options);
    for (int i = 0; i < GROUPS; i++) hil_group_release(c, i);
    int64_t deadline_ns = wall_ns() + 10000000000;
    hil_rt_stats s;
    int least_s = 0;
    do {
        check_stats(c, options.period_ns);
        hil_rt_stats_read(c, &s);
        least_s = 1000;
        for (int i = 0; i < GROUPS; i++)
            if (hil_group_now(c, i) / 1000000000 < least_s) least_s = (int)(hil_group_now(c, i) / 1000000000);
        sched_yield();
    } while ((s.overruns < 10 || least_s < 1) && wall_ns() < deadline_ns);
    CHECK(s.overruns >= 10);
    CHECK(least_s >= 1);
    int64_t from_ns = wall_ns();
    hil_rt_stop(c);
    CHECK(wall_ns() - from_ns < 1000000000);
    CHECK(hil_rt_now(c) > 0);
    hil_core_free(c);
}

/* Taken while the thread makes them: all of the grid, each whole, with the ring full at times and empty at others. */
static void samples_are_taken_by_who_does_not_own(void)
{
    enum { WANTED = 4000, GRID_NS = 50000, CAPACITY = 1000 };
    hil_core *c = new_core(1);
    open_axis(c, open_group(c, 0));
    hil_axis_set(c, 0, HIL_FIELD_mode, 'x');
    hil_axis_loop(c, 0, 1);
    hil_axis_watch(c, 0, 0, GRID_NS, 1, CAPACITY);
    start(c, &EVERY_MS);
    hil_group_set_horizon(c, 0, HIL_FOREVER);
    hil_group_release(c, 0);
    hil_snapshot s[7];
    int64_t at_ns = 0, deadline_ns = wall_ns() + 10000000000;
    int got = 0, wrong = 0, gaps = 0;
    while (got < WANTED && wall_ns() < deadline_ns) {
        if (got % 16 == 0) wait_ticks(c, 2);
        int n = hil_axis_take_samples(c, 0, 0, s, 1 + got % 7);
        for (int i = 0; i < n; i++) {
            wrong += s[i].control_steps != steps_until(s[i].at_ns) || (s[i].at_ns - at_ns) % GRID_NS || s[i].at_ns <= at_ns;
            gaps += s[i].at_ns - at_ns != GRID_NS;
            at_ns = s[i].at_ns;
        }
        got += n;
    }
    CHECK(got >= WANTED);
    CHECK_INT(wrong, 0);
    CHECK(hil_axis_lost_samples(c, 0, 0) ? gaps : !gaps);
    hil_rt_stop(c);
    hil_core_free(c);
}

/* A bench may have come to a time without the thread; at speed 0 its time stands, and then goes on from there. */
static void time_begins_where_groups_are(void)
{
    hil_core *c = new_core(1);
    open_axis(c, open_group(c, 0));
    const int64_t then_ns = INT64_C(5000000000);
    hil_group_set_horizon(c, 0, HIL_FOREVER);
    hil_group_advance(c, 0, then_ns);
    hil_group_release(c, 0);
    hil_rt_options still = EVERY_MS;
    still.speed = 0;
    start(c, &still);
    wait_ticks(c, 5);
    CHECK_INT(hil_rt_now(c), then_ns);
    CHECK_INT(hil_group_now(c, 0), then_ns);
    hil_rt_stop(c);
    start(c, &EVERY_MS);
    wait_ticks(c, 20);
    hil_rt_stop(c);
    int64_t now_ns = hil_group_now(c, 0);
    CHECK(now_ns > then_ns && now_ns < then_ns + 2000000000);
    start(c, &still);
    wait_ticks(c, 5);
    CHECK(hil_rt_now(c) >= now_ns && hil_rt_now(c) < now_ns + 1000000000);
    hil_core_free(c);
}

static void far_times_saturate(void)
{
    hil_core *c = new_core(1);
    hil_rt_options options = EVERY_MS;
    options.speed = 1e300;
    start(c, &options);
    wait_ticks(c, 2);
    CHECK_INT(hil_rt_now(c), INT64_C(1) << 62);
    hil_core_free(c);
}

/* With the signal blocked in this thread, only the real-time thread could take it. */
static void signals_are_the_others(void)
{
    hil_core *c = new_core(1);
    start(c, &EVERY_MS);
    sigset_t set, before, pending;
    int got;
    sigemptyset(&set);
    sigaddset(&set, SIGUSR2);
    pthread_sigmask(SIG_BLOCK, &set, &before);
    kill(getpid(), SIGUSR2);
    wait_ticks(c, 5);
    sigpending(&pending);
    CHECK(sigismember(&pending, SIGUSR2));
    sigwait(&set, &got);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    hil_core_free(c);
}

int main(int argc, char **argv)
{
    shared_tests();
    pty_lines_threads_tests();
    RUN(owners_take_turns);
    RUN(starts_and_stops);
    RUN(refused_permissions_are_known_at_start);
    RUN(too_much_work_is_shared);
    RUN(samples_are_taken_by_who_does_not_own);
    RUN(time_begins_where_groups_are);
    RUN(far_times_saturate);
    RUN(signals_are_the_others);
    return check_report("concurrent", argc > 1 ? argv[1] : NULL);
}
