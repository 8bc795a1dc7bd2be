/* A core: its memory, taken at once and given back. */
#define _GNU_SOURCE
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <unistd.h>

#include "axis.h"
#include "hil_core.h"

static size_t round_up(size_t n) { return (n + 63) & ~(size_t)63; }

hil_core *hil_core_new(int max_axes, int *event_fd)
{
    if (max_axes < 1) return NULL;
    size_t axes_at = round_up(sizeof(hil_core)), groups_at = axes_at + round_up(sizeof(hil_axis) * (size_t)max_axes);
    size_t due_at = groups_at + round_up(sizeof(hil_group) * (size_t)max_axes), len = due_at + (size_t)max_axes;
    char *arena = mmap(NULL, len, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (arena == MAP_FAILED) return NULL;
    /* Refused, or too small an arena: only slower. Tables are 64 KiB apart, so with small pages each axis
       takes several translations for itself. */
    (void)madvise(arena, len, MADV_HUGEPAGE);
    hil_core *c = (hil_core *)arena;
    c->event_fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    if (c->event_fd < 0) {
        munmap(arena, len);
        return NULL;
    }
    c->arena_len = len;
    c->max_axes = max_axes;
    c->axes = (hil_axis *)(arena + axes_at);
    c->groups = (hil_group *)(arena + groups_at);
    c->due = (_Atomic uint8_t *)(arena + due_at);
    mechaduino_sine(c->sine);
    *event_fd = c->event_fd;
    return c;
}

void hil_core_free(hil_core *c)
{
    hil_rt_stop(c);
    for (int i = 0; i < c->max_axes; i++) axis_close(&c->axes[i]);
    close(c->event_fd);
    munmap(c, c->arena_len);
}
