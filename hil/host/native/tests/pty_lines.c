/* The library of `hil with-lines`, which is linked here: it answers this program's own calls of ioctl. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <linux/serial.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "check.h"
#include "threads.h"

enum { INPUTS = TIOCM_CTS | TIOCM_DSR | TIOCM_CD, BOTH = TIOCM_DTR | TIOCM_RTS };

static int open_pty(int *master)
{
    char path[64];
    *master = posix_openpt(O_RDWR | O_NOCTTY);
    if (*master < 0 || grantpt(*master) || unlockpt(*master) || ptsname_r(*master, path, sizeof path)) exit(2);
    return open(path, O_RDWR | O_NOCTTY);
}

static void set(int fd, unsigned long request, int lines) { CHECK_INT(ioctl(fd, request, &lines), 0); }

static int get(int fd)
{
    int lines = -1;
    CHECK_INT(ioctl(fd, TIOCMGET, &lines), 0);
    return lines;
}

static void what_was_set_is_read(void)
{
    int master, fd = open_pty(&master);
    set(fd, TIOCMSET, BOTH); /* the pty's number may have been used before */
    CHECK_INT(get(fd), INPUTS | BOTH);
    set(fd, TIOCMBIC, TIOCM_DTR | TIOCM_CTS); /* an input is not set */
    CHECK_INT(get(fd), INPUTS | TIOCM_RTS);
    set(fd, TIOCMBIS, TIOCM_DTR | TIOCM_RI);
    CHECK_INT(get(fd), INPUTS | BOTH);
    set(fd, TIOCMSET, TIOCM_DTR);
    int other = dup(fd);
    CHECK_INT(get(other), INPUTS | TIOCM_DTR);
    struct serial_icounter_struct counts;
    memset(&counts, 0xff, sizeof counts);
    CHECK_INT(ioctl(fd, TIOCGICOUNT, &counts), 0);
    CHECK_INT(counts.cts | counts.rx | counts.brk | counts.buf_overrun, 0);
    errno = 4711;
    CHECK_INT(get(fd), INPUTS | TIOCM_DTR);
    CHECK_INT(errno, 4711);
    CHECK_INT(ioctl(fd, TCSBRK, 0), 0);
    CHECK_INT(ioctl(fd, TIOCSBRK), 0);
    close(other);
    close(fd);
    close(master);
}

static void ptys_do_not_share_lines(void)
{
    int masters[2], fds[2];
    for (int i = 0; i < 2; i++) fds[i] = open_pty(&masters[i]);
    set(fds[0], TIOCMSET, TIOCM_RTS);
    set(fds[1], TIOCMSET, TIOCM_DTR);
    CHECK_INT(get(fds[0]), INPUTS | TIOCM_RTS);
    CHECK_INT(get(fds[1]), INPUTS | TIOCM_DTR);
    for (int i = 0; i < 2; i++) {
        close(fds[i]);
        close(masters[i]);
    }
}

static int error_of(int fd, unsigned long request, void *argument)
{
    errno = 0;
    CHECK_INT(ioctl(fd, request, argument), -1);
    return errno;
}

static void all_else_is_the_kernels(void)
{
    int master, fd = open_pty(&master), ends[2], lines = BOTH;
    if (pipe(ends)) exit(2);
    CHECK_INT(error_of(master, TIOCMGET, &lines), ENOTTY);
    CHECK_INT(error_of(ends[0], TIOCMGET, &lines), ENOTTY);
    CHECK_INT(error_of(ends[0], TIOCMIWAIT, NULL), ENOTTY);
    CHECK_INT(error_of(-1, TIOCMGET, &lines), EBADF);
    CHECK_INT(error_of(fd, TIOCMGET, NULL), EFAULT);
    CHECK_INT(error_of(fd, TIOCGICOUNT, NULL), EFAULT);
    CHECK_INT(error_of(fd, TIOCSERGETLSR, &lines), ENOTTY); /* a request of serial ports that is not about lines */
    CHECK_INT(error_of(ends[0], TIOCGRS485, &(struct serial_rs485){0}), ENOTTY);
    struct winsize size = {.ws_row = 7}, got = {0};
    CHECK_INT(ioctl(fd, TIOCSWINSZ, &size), 0);
    CHECK_INT(ioctl(master, TIOCGWINSZ, &got), 0);
    CHECK_INT(got.ws_row, 7);
    int waiting = -1;
    CHECK_INT(write(ends[1], "abc", 3), 3);
    CHECK_INT(ioctl(ends[0], FIONREAD, &waiting), 0);
    CHECK_INT(waiting, 3);
    close(master); /* the port is gone: the kernel says so */
    CHECK_INT(error_of(fd, TIOCMGET, &lines), EIO);
    CHECK_INT(error_of(fd, TIOCMIWAIT, NULL), EIO);
    close(fd);
    close(ends[0]);
    close(ends[1]);
}

typedef struct waiter {
    int fd, result, error;
    _Atomic int begun, ended;
} waiter;

static void *wait_for_lines(void *argument)
{
    waiter *w = argument;
    w->begun = 1;
    w->result = ioctl(w->fd, TIOCMIWAIT, TIOCM_CTS | TIOCM_CD);
    w->error = errno;
    w->ended = 1;
    return NULL;
}

static void nothing(int number) { (void)number; }

/* A signal, sent until the waiting thread has noticed one: the first may come before it waits. */
static void a_signal_or_the_ports_end_ends_a_wait(void)
{
    struct sigaction action = {.sa_handler = nothing};
    sigaction(SIGUSR1, &action, NULL);
    for (int by_signal = 0; by_signal < 2; by_signal++) {
        int master;
        waiter w = {.fd = open_pty(&master)};
        pthread_t thread = spawn(wait_for_lines, &w);
        while (!w.begun) poll(NULL, 0, 1);
        if (!by_signal) close(master);
        while (!w.ended) {
            if (by_signal) pthread_kill(thread, SIGUSR1);
            poll(NULL, 0, 1);
        }
        pthread_join(thread, NULL);
        CHECK_INT(w.result, -1);
        CHECK_INT(w.error, by_signal ? EINTR : EIO);
        close(w.fd);
        if (by_signal) close(master);
    }
}

void pty_lines_tests(void)
{
    RUN(what_was_set_is_read);
    RUN(ptys_do_not_share_lines);
    RUN(all_else_is_the_kernels);
    RUN(a_signal_or_the_ports_end_ends_a_wait);
}

typedef struct toggler {
    int fd, line;
    int64_t wrong;
} toggler;

/* A line that only this thread sets: it reads what it has set, whatever others do to the other one. */
static void *toggle(void *argument)
{
    toggler *t = argument;
    for (int i = 0; i < 20000; i++) {
        int lines = t->line, got = 0;
        ioctl(t->fd, i % 2 ? TIOCMBIS : TIOCMBIC, &lines);
        ioctl(t->fd, TIOCMGET, &got);
        t->wrong += (got & t->line) != (i % 2 ? t->line : 0);
    }
    return NULL;
}

static void threads_set_lines_of_one_port(void)
{
    int master, fd = open_pty(&master);
    toggler togglers[] = {{.fd = fd, .line = TIOCM_DTR}, {.fd = fd, .line = TIOCM_RTS}};
    pthread_t threads[2];
    for (int i = 0; i < 2; i++) threads[i] = spawn(toggle, &togglers[i]);
    for (int i = 0; i < 2; i++) pthread_join(threads[i], NULL);
    CHECK_INT(togglers[0].wrong + togglers[1].wrong, 0);
    CHECK_INT(get(fd), INPUTS | BOTH);
    close(fd);
    close(master);
}

void pty_lines_threads_tests(void) { RUN(threads_set_lines_of_one_port); }
