/* The CPU-time watchdog: rt/watchdog.c. */
#define _GNU_SOURCE
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include "fixture.h"

static volatile sig_atomic_t rung_in;

static void ring(int signal_number)
{
    (void)signal_number;
    rung_in = (sig_atomic_t)gettid();
}

static int64_t cpu_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

/* Burns CPU until the bell or for `most_ns`; answers what it burnt. */
static int64_t burn_ns(int64_t most_ns)
{
    int64_t from_ns = cpu_ns(), spent_ns = 0;
    while (!rung_in && spent_ns < most_ns) spent_ns = cpu_ns() - from_ns;
    return spent_ns;
}

static void rings_after_cpu_time(void)
{
    struct sigaction action = {.sa_handler = ring}, before;
    sigaction(SIGUSR1, &action, &before);
    hil_watchdog *w = hil_watchdog_new(SIGUSR1);
    CHECK(w);
    if (!w) return;
    rung_in = 0;
    hil_watchdog_arm(w, 200000000);
    int64_t spent_ns = burn_ns(2000000000);
    CHECK_INT(rung_in, gettid());
    CHECK(spent_ns >= 190000000);
    CHECK(spent_ns < 400000000); /* the kernel looks at its CPU timers on its own tick */
    rung_in = 0;
    hil_watchdog_arm(w, 50000000);
    hil_watchdog_arm(w, 0);
    burn_ns(150000000);
    CHECK_INT(rung_in, 0);
    hil_watchdog_free(w);
    sigaction(SIGUSR1, &before, NULL);
}

void watchdog_tests(void) { RUN(rings_after_cpu_time); }
