/* Loaded before libc: lets system calls on files below one directory fail. See test_nvm_store_calls.py.

   A failing call does what Linux does: a close has closed, a write may have written a part, the others did nothing. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static char directory[4096]; /* "": nothing fails */
static long first, last, seen;
static int code;

/* Calls first to last (from 0) on files below where fail with an errno; where "": none. */
void fail_calls(const char *where, long from, long to, int error)
{
    snprintf(directory, sizeof directory, "%s", where);
    first = from;
    last = to;
    code = error;
    seen = 0;
}

/* How many calls there were since fail_calls. */
long seen_calls(void) { return seen; }

static int is_watched(const char *path)
{
    size_t len = strlen(directory);
    return len && !strncmp(path, directory, len) && (path[len] == '/' || !path[len]);
}

static int fails(const char *path)
{
    if (!is_watched(path)) return 0;
    long number = seen++;
    if (number < first || number > last) return 0;
    errno = code;
    return 1;
}

static int fd_fails(int fd)
{
    char link[64], path[4096];
    if (!directory[0]) return 0;
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t len = readlink(link, path, sizeof path - 1);
    if (len < 0) return 0;
    path[len] = 0;
    return fails(path);
}

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

#define OPEN(name)                                          \
    int name(const char *path, int flags, ...)              \
    {                                                       \
        va_list arguments;                                  \
        va_start(arguments, flags);                         \
        mode_t mode = va_arg(arguments, mode_t);            \
        va_end(arguments);                                  \
        return fails(path) ? -1 : REAL(name)(path, flags, mode); \
    }
OPEN(open)
OPEN(open64)

#define PATHS(name)                                         \
    int name(const char *old, const char *new)              \
    {                                                       \
        return fails(old) ? -1 : REAL(name)(old, new);      \
    }
PATHS(rename)
PATHS(link)

int unlink(const char *path) { return fails(path) ? -1 : REAL(unlink)(path); }

ssize_t read(int fd, void *data, size_t len) { return fd_fails(fd) ? -1 : REAL(read)(fd, data, len); }

ssize_t write(int fd, const void *data, size_t len)
{
    if (!fd_fails(fd)) return REAL(write)(fd, data, len);
    if (REAL(write)(fd, data, len / 2) < 0) return -1;
    errno = code;
    return -1;
}

int fsync(int fd) { return fd_fails(fd) ? -1 : REAL(fsync)(fd); }

int fstat(int fd, struct stat *status) { return fd_fails(fd) ? -1 : REAL(fstat)(fd, status); }

int fstat64(int fd, struct stat64 *status) { return fd_fails(fd) ? -1 : REAL(fstat64)(fd, status); }

int close(int fd)
{
    int failed = fd_fails(fd);
    if (!failed) return REAL(close)(fd);
    REAL(close)(fd);
    errno = code;
    return -1;
}
