/* Modem lines of pseudo-terminals, for a program that loads this library before libc (LD_PRELOAD): `hil with-lines`.

   The kernel is always asked first. Only where it knows no modem lines (ENOTTY), and the file is the end of a pty that
   programs open, the answer is given here: DTR and RTS as the program set them, CTS, DSR and carrier on, no changes; the
   RS485 mode and the low latency that the program set. All else passes unchanged: other files, other requests, other
   errors. A break needs nothing: the kernel takes it on a pty.

   Threads and signal handlers may call at the same time: the state of a pty is a few atomic numbers. */
#define _GNU_SOURCE
#undef _FILE_OFFSET_BITS /* they would give `ioctl` another name in a library of 32 bits */
#undef _TIME_BITS
#include <dlfcn.h>
#include <errno.h>
#include <linux/serial.h>
#include <poll.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <string.h>
#include <sys/ioctl.h>

#ifdef __GLIBC__
typedef unsigned long request_number;
#else
typedef int request_number; /* musl, as POSIX has it */
#endif
typedef int ioctl_function(int fd, request_number request, ...);

#define EXPORTED __attribute__((visibility("default")))

enum { OUTPUTS = TIOCM_DTR | TIOCM_RTS, INPUTS = TIOCM_CTS | TIOCM_DSR | TIOCM_CD };
/* Majors of the ends that programs open: the kernel's Documentation/admin-guide/devices.txt. */
enum { FIRST_MAJOR = 136, LAST_MAJOR = 143, MINORS = 1 << 20 };

/* Outputs that are off, by the pty's number: all are on at first, as when a port is opened. Only pages in use take
   memory. */
static _Atomic unsigned char outputs_off[MINORS];
_Static_assert((OUTPUTS & ~0xff) == 0, "the outputs fit into a byte");

/* RS485 mode as the program set it: flags, and two delays in ms. On a bench the driver's direction needs no care. */
static _Atomic unsigned rs485[MINORS][3];
/* Low latency as the program set it: what hil writes to a pty is there at once, with or without it. */
static _Atomic unsigned char low_latency[MINORS];

static _Atomic(ioctl_function *) next_ioctl;

/* The ioctl that the program would have without this library: libc's, or that of another such library. */
static ioctl_function *find_ioctl(void)
{
    ioctl_function *found = atomic_load_explicit(&next_ioctl, memory_order_acquire);
    if (!found) {
        void *symbol = dlsym(RTLD_NEXT, "ioctl");
        memcpy(&found, &symbol, sizeof found); /* ISO C has no cast from a pointer to an object to one to a function */
        atomic_store_explicit(&next_ioctl, found, memory_order_release);
    }
    return found;
}

/* Early: dlsym is not for signal handlers. */
__attribute__((constructor)) static void find_early(void) { find_ioctl(); }

/* Number of the pty whose opened end `fd` is, or -1. */
static long pty_number(int fd)
{
    unsigned device = 0;
    int master = 0;
    if (find_ioctl()(fd, (request_number)TIOCGDEV, &device)) return -1;
    if (!find_ioctl()(fd, (request_number)TIOCGPTN, &master)) return -1; /* the other end, a terminal emulator's */
    /* As the kernel packs it: the low byte of the minor, 12 bits of the major, the rest of the minor. */
    unsigned major = device >> 8 & 0xfff, minor = (device & 0xff) | (device >> 12 & 0xfff00);
    return major >= FIRST_MAJOR && major <= LAST_MAJOR ? (long)minor : -1;
}

static int refuse(int error)
{
    errno = error;
    return -1;
}

/* TIOCMIWAIT: no line ever changes, so that only a signal ends it, or the end of the port. */
static int wait_for_change(int fd)
{
    struct pollfd port = {.fd = fd, .events = 0};
    if (poll(&port, 1, -1) < 0) return -1;
    return refuse(port.revents & POLLNVAL ? EBADF : EIO);
}

/* TIOCGRS485, TIOCSRS485: the kernel gives back what it has taken, too. */
static int answer_rs485(unsigned request, struct serial_rs485 *mode, _Atomic unsigned *kept)
{
    enum { KNOWN = SER_RS485_ENABLED | SER_RS485_RTS_ON_SEND | SER_RS485_RTS_AFTER_SEND | SER_RS485_RX_DURING_TX };
    if (request == TIOCSRS485) {
        atomic_store(&kept[0], mode->flags & KNOWN);
        atomic_store(&kept[1], mode->delay_rts_before_send);
        atomic_store(&kept[2], mode->delay_rts_after_send);
    }
    memset(mode, 0, sizeof *mode);
    mode->flags = atomic_load(&kept[0]);
    mode->delay_rts_before_send = atomic_load(&kept[1]);
    mode->delay_rts_after_send = atomic_load(&kept[2]);
    return 0;
}

/* TIOCGSERIAL, TIOCSSERIAL: a port without a chip that is known, of which the latency alone can be set. A divisor of its
   own (ASYNC_SPD_MASK) would be a speed that nobody hears. */
static int answer_serial(unsigned request, struct serial_struct *port, long number)
{
    if (request == TIOCSSERIAL) {
        if (port->flags & ASYNC_SPD_MASK) return refuse(EINVAL);
        atomic_store(&low_latency[number], (unsigned char)((port->flags & ASYNC_LOW_LATENCY) != 0));
        return 0;
    }
    memset(port, 0, sizeof *port);
    port->line = (int)number;
    port->flags = atomic_load(&low_latency[number]) ? ASYNC_LOW_LATENCY : 0;
    return 0;
}

static int answer(int fd, unsigned request, void *argument, long number)
{
    _Atomic unsigned char *off = &outputs_off[number];
    if (request == TIOCMIWAIT) return wait_for_change(fd); /* its argument is a mask */
    if (!argument) return refuse(EFAULT);
    switch (request) {
    case TIOCGRS485:
    case TIOCSRS485:
        return answer_rs485(request, argument, rs485[number]);
    case TIOCGSERIAL:
    case TIOCSSERIAL:
        return answer_serial(request, argument, number);
    case TIOCMGET:
        *(int *)argument = INPUTS | (OUTPUTS & ~atomic_load(off));
        break;
    case TIOCMSET:
        atomic_store(off, (unsigned char)(OUTPUTS & ~*(int *)argument));
        break;
    case TIOCMBIS:
        atomic_fetch_and(off, (unsigned char)~(OUTPUTS & *(int *)argument));
        break;
    case TIOCMBIC:
        atomic_fetch_or(off, (unsigned char)(OUTPUTS & *(int *)argument));
        break;
    case TIOCGICOUNT:
        memset(argument, 0, sizeof(struct serial_icounter_struct));
    }
    return 0;
}

static int is_about_lines(unsigned request)
{
    return request == TIOCMGET || request == TIOCMSET || request == TIOCMBIS || request == TIOCMBIC ||
           request == TIOCGICOUNT || request == TIOCMIWAIT || request == TIOCGRS485 || request == TIOCSRS485 ||
           request == TIOCGSERIAL || request == TIOCSSERIAL;
}

static int with_lines(int fd, request_number request, void *argument)
{
    int before = errno, result = find_ioctl()(fd, request, argument);
    /* 32 bits of a request count for the kernel, too. */
    if (result != -1 || errno != ENOTTY || !is_about_lines((unsigned)request)) return result;
    long number = pty_number(fd);
    if (number < 0) return refuse(ENOTTY);
    errno = before;
    return answer(fd, (unsigned)request, argument, number);
}

EXPORTED int ioctl(int fd, request_number request, ...)
{
    va_list rest;
    va_start(rest, request);
    void *argument = va_arg(rest, void *); /* whatever it is, as libc takes it */
    va_end(rest);
    return with_lines(fd, request, argument);
}

#if defined(__GLIBC__) && __SIZEOF_LONG__ == 4
/* The same where times have 64 bits in a program of 32 (_TIME_BITS=64). */
EXPORTED int __ioctl_time64(int fd, request_number request, ...)
    __attribute__((alias("ioctl"), nothrow, leaf));
#endif
