/* A timer on the calling thread's CPU time that raises a signal in that thread. */
#define _GNU_SOURCE
#include <signal.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "../hil_core.h"

#ifndef sigev_notify_thread_id
#define sigev_notify_thread_id _sigev_un._tid
#endif

struct hil_watchdog {
    timer_t timer;
};

hil_watchdog *hil_watchdog_new(int signal_number)
{
    hil_watchdog *w = malloc(sizeof *w);
    if (!w) return NULL;
    struct sigevent e = {.sigev_notify = SIGEV_THREAD_ID, .sigev_signo = signal_number};
    e.sigev_notify_thread_id = (pid_t)syscall(SYS_gettid);
    if (timer_create(CLOCK_THREAD_CPUTIME_ID, &e, &w->timer)) {
        free(w);
        return NULL;
    }
    return w;
}

void hil_watchdog_arm(hil_watchdog *w, int64_t ns)
{
    struct timespec span = {.tv_sec = ns / 1000000000, .tv_nsec = ns % 1000000000};
    struct itimerspec t = {.it_value = span, .it_interval = span};
    timer_settime(w->timer, 0, &t, NULL);
}

void hil_watchdog_free(hil_watchdog *w)
{
    timer_delete(w->timer);
    free(w);
}
