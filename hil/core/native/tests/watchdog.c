/* The watchdog: rt/watchdog.c. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "fixture.h"

static volatile sig_atomic_t rung_in, rings;

static void ring(int signal_number)
{
    (void)signal_number;
    rung_in = (sig_atomic_t)gettid();
    rings++;
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
    hil_watchdog *w = hil_watchdog_new(SIGUSR1, ring, "/nowhere/breadcrumb");
    CHECK(w);
    if (!w) return;
    rung_in = 0;
    hil_watchdog_arm(w, 200000000, 0);
    int64_t spent_ns = burn_ns(2000000000);
    CHECK_INT(rung_in, gettid());
    CHECK(spent_ns >= 190000000);
    CHECK(spent_ns < 400000000); /* the kernel looks at its CPU timers on its own tick */
    rung_in = 0;
    CHECK(hil_watchdog_bells(w) >= 1);
    CHECK_INT(hil_watchdog_bells_in_work(w, 0), 0);
    hil_watchdog_arm(w, 50000000, 0);
    hil_watchdog_arm(w, 0, 0);
    burn_ns(150000000);
    CHECK_INT(rung_in, 0);
    hil_watchdog_free(w);
}

/* Wall time counts during work alone. */
static void rings_while_work_waits(void)
{
    hil_watchdog *w = hil_watchdog_new(SIGUSR1, ring, "/nowhere/breadcrumb");
    CHECK(w);
    if (!w) return;
    rings = 0;
    hil_watchdog_arm(w, 0, 10000000);
    struct timespec pause = {.tv_nsec = 35000000};
    nanosleep(&pause, NULL);
    CHECK_INT(rings, 0);
    hil_watchdog_enter(w, "m1");
    while (hil_watchdog_bells_in_work(w, 1) < 3) nanosleep(&pause, NULL);
    CHECK(rings >= 3);
    CHECK_INT(hil_watchdog_bells(w), 0);
    CHECK_INT(hil_watchdog_leave(w), 0);
    hil_watchdog_enter(w, "m1");
    CHECK(hil_watchdog_bells_in_work(w, 1) < 3);
    hil_watchdog_leave(w);
    hil_watchdog_free(w);
}

static void forgets_errno(int signal_number)
{
    (void)signal_number;
    errno = 0; /* as Python does before it writes to its wake-up file */
    rings++;
}

/* A call that failed can still say why when a bell rings before it is asked. */
static void leaves_errno_alone(void)
{
    hil_watchdog *w = hil_watchdog_new(SIGUSR1, forgets_errno, "/nowhere/breadcrumb");
    CHECK(w);
    if (!w) return;
    rings = 0;
    hil_watchdog_enter(w, "m1");
    errno = EAGAIN;
    hil_watchdog_arm(w, 10000000, 10000000);
    for (int64_t from_ns = cpu_ns(); rings < 4 && cpu_ns() - from_ns < 1000000000;) continue;
    int left = errno;
    hil_watchdog_arm(w, 0, 0);
    CHECK(rings >= 4);
    CHECK_INT(left, EAGAIN);
    hil_watchdog_leave(w);
    hil_watchdog_free(w);
}

/* In a child: work without an end leaves its name, and the process ends. */
static void hopeless_work_is_named(void)
{
    char file[] = "/tmp/hil-watchdog-XXXXXX", name[8] = "";
    int fd = mkstemp(file), status = 0, quiet = open("/dev/null", O_WRONLY);
    pid_t child = fork();
    if (child == 0) {
        dup2(quiet, STDERR_FILENO);
        hil_watchdog *w = hil_watchdog_new(SIGUSR1, ring, file);
        hil_watchdog_arm(w, 10000000, 0);
        hil_watchdog_enter(w, "m1");
        for (;;) cpu_ns();
    }
    CHECK_INT(waitpid(child, &status, 0), child);
    CHECK(WIFEXITED(status) && WEXITSTATUS(status) == HIL_WATCHDOG_EXIT);
    CHECK_INT(read(fd, name, sizeof name), 2);
    CHECK(!strcmp(name, "m1"));
    close(fd);
    close(quiet);
    unlink(file);
}

void watchdog_tests(void)
{
    RUN(rings_after_cpu_time);
    RUN(rings_while_work_waits);
    RUN(leaves_errno_alone);
    RUN(hopeless_work_is_named);
}
