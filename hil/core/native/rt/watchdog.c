/* Timers on the calling thread's CPU time and on the wall's, that raise a signal in that thread. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "../hil_core.h"

#ifndef sigev_notify_thread_id
#define sigev_notify_thread_id _sigev_un._tid
#endif

enum { CPU, WALL };

typedef struct bell {
    hil_watchdog *of;
    timer_t timer;
    atomic_int in_work; /* rung since the work was entered */
} bell;

struct hil_watchdog {
    bell bells[2];
    int signal_number;
    void (*interrupt)(int);
    _Atomic(const char *) work; /* NULL: none */
    _Atomic int64_t rung;       /* of CPU time */
    atomic_int reported;
    struct sigaction before;
    int has_signal; /* its handler is in place, and the timers are there */
    char *file;
};

static void say(int fd, const char *text)
{
    ssize_t put = write(fd, text, strlen(text));
    (void)put; /* nobody is left to tell */
}

/* The one moment in which a hung daemon can still say whose fault it is. */
static void report(hil_watchdog *w, const char *work)
{
    atomic_store(&w->reported, 1);
    say(STDERR_FILENO, "CRITICAL ");
    say(STDERR_FILENO, work);
    say(STDERR_FILENO, ": its firmware is in code that cannot be interrupted, and all devices wait\n");
    int fd = open(w->file, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (fd < 0) return;
    say(fd, work);
    close(fd);
}

static void heard(bell *b, int signal_number)
{
    hil_watchdog *w = b->of;
    const char *work = atomic_load(&w->work);
    if (b == &w->bells[CPU]) atomic_fetch_add(&w->rung, 1);
    else if (!work) return; /* an idle thread is left in peace */
    if (work) {
        int n = atomic_fetch_add(&b->in_work, 1) + 1;
        int say_at = b == &w->bells[CPU] ? HIL_WATCHDOG_SAY : HIL_WATCHDOG_SAY_WALL;
        if (n == say_at && !atomic_load(&w->reported)) report(w, work);
        if (n == HIL_WATCHDOG_END && b == &w->bells[CPU]) { /* a starved thread is late, too, and not to blame */
            say(STDERR_FILENO, "CRITICAL the bench ends\n");
            _exit(HIL_WATCHDOG_EXIT);
        }
    }
    w->interrupt(signal_number);
}

static void ring(int signal_number, siginfo_t *info, void *context)
{
    (void)context;
    /* Whoever was interrupted may be about to ask why a system call failed. */
    int before = errno;
    if (info->si_code == SI_TIMER) heard(info->si_value.sival_ptr, signal_number);
    errno = before;
}

static int add(hil_watchdog *w, int which, clockid_t clock)
{
    bell *b = &w->bells[which];
    b->of = w;
    struct sigevent e = {.sigev_notify = SIGEV_THREAD_ID, .sigev_signo = w->signal_number};
    e.sigev_notify_thread_id = (pid_t)syscall(SYS_gettid);
    e.sigev_value.sival_ptr = b;
    return timer_create(clock, &e, &b->timer);
}

hil_watchdog *hil_watchdog_new(int signal_number, void (*interrupt)(int), const char *file)
{
    hil_watchdog *w = calloc(1, sizeof *w);
    if (!w) return NULL;
    w->signal_number = signal_number;
    w->interrupt = interrupt;
    w->file = strdup(file);
    if (!w->file || add(w, CPU, CLOCK_THREAD_CPUTIME_ID)) {
        free(w->file);
        free(w);
        return NULL;
    }
    struct sigaction action = {.sa_sigaction = ring, .sa_flags = SA_SIGINFO | SA_ONSTACK};
    /* The timers are not armed yet: none rings before the handler is there. */
    if (add(w, WALL, CLOCK_MONOTONIC) || sigaction(signal_number, &action, &w->before)) {
        timer_delete(w->bells[CPU].timer);
        free(w->file);
        free(w);
        return NULL;
    }
    w->has_signal = 1;
    return w;
}

static void set(bell *b, int64_t ns)
{
    struct timespec span = {.tv_sec = ns / 1000000000, .tv_nsec = ns % 1000000000};
    struct itimerspec t = {.it_value = span, .it_interval = span};
    timer_settime(b->timer, 0, &t, NULL);
}

void hil_watchdog_arm(hil_watchdog *w, int64_t cpu_ns, int64_t wall_ns)
{
    set(&w->bells[CPU], cpu_ns);
    set(&w->bells[WALL], wall_ns);
}

void hil_watchdog_enter(hil_watchdog *w, const char *work)
{
    atomic_store_explicit(&w->bells[CPU].in_work, 0, memory_order_relaxed);
    atomic_store_explicit(&w->bells[WALL].in_work, 0, memory_order_relaxed);
    atomic_store_explicit(&w->work, work, memory_order_relaxed);
}

int hil_watchdog_leave(hil_watchdog *w)
{
    atomic_store_explicit(&w->work, NULL, memory_order_relaxed);
    return atomic_load_explicit(&w->reported, memory_order_relaxed) && atomic_exchange(&w->reported, 0);
}

void hil_watchdog_aside(hil_watchdog *w) { atomic_store_explicit(&w->work, NULL, memory_order_relaxed); }

void hil_watchdog_resume(hil_watchdog *w, const char *work)
{
    atomic_store_explicit(&w->work, work, memory_order_relaxed);
}

int64_t hil_watchdog_bells(const hil_watchdog *w) { return atomic_load(&((hil_watchdog *)w)->rung); }

int hil_watchdog_bells_in_work(const hil_watchdog *w, int wall)
{
    return atomic_load(&((hil_watchdog *)w)->bells[wall ? WALL : CPU].in_work);
}

void hil_watchdog_close(hil_watchdog *w)
{
    if (!w->has_signal) return;
    w->has_signal = 0;
    for (int which = CPU; which <= WALL; which++) timer_delete(w->bells[which].timer);
    /* A bell that was on its way when its timer went has no watchdog any more. */
    signal(w->signal_number, SIG_IGN);
    sigaction(w->signal_number, &w->before, NULL);
}

void hil_watchdog_free(hil_watchdog *w)
{
    hil_watchdog_close(w);
    free(w->file);
    free(w);
}
