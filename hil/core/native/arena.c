/* A core: its memory, taken at once and given back. */
#define _GNU_SOURCE
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <unistd.h>

#include "axis.h"
#include "batch.h"
#include "hil_core.h"
#include "laws.h"

enum { PAGE = 4096 };

static size_t round_up(size_t n) { return (n + 63) & ~(size_t)63; }

/* Where the next part of an arena goes that has come so far; *len: after it. */
static size_t put(size_t *len, size_t size)
{
    size_t at = *len;
    *len += round_up(size);
    return at;
}

hil_core *hil_core_new(int max_axes, int *event_fd)
{
    if (max_axes < 1) return NULL;
    size_t n = (size_t)max_axes, len = round_up(sizeof(hil_core)), laws_at[HIL_LAWS];
    size_t axes_at = put(&len, n * sizeof(hil_axis)), groups_at = put(&len, n * sizeof(hil_group)), due_at = put(&len, n);
    for (int i = 0; i < HIL_LAWS; i++) laws_at[i] = put(&len, n * round_up(laws[i]->bytes));
    len = (len + PAGE - 1) / PAGE * PAGE; /* the beginning of a ring takes no more pages than it has to */
    size_t events_at = put(&len, n * RING_MOST * sizeof(hil_event));
    char *arena = mmap(NULL, len, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (arena == MAP_FAILED) return NULL;
    /* Refused, or too small an arena: only slower. Tables are 64 KiB apart, so with small pages each axis
       takes several translations for itself. Rings are touched at their beginnings alone, most of them. */
    (void)madvise(arena, events_at, MADV_HUGEPAGE);
    hil_core *c = (hil_core *)arena;
    c->event_fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    if (c->event_fd < 0) {
        munmap(arena, len);
        return NULL;
    }
    c->arena_len = len;
    c->max_axes = max_axes;
    c->lanes = batch_widest();
    c->axes = (hil_axis *)(arena + axes_at);
    c->groups = (hil_group *)(arena + groups_at);
    c->due = (_Atomic uint8_t *)(arena + due_at);
    for (int i = 0; i < HIL_LAWS; i++) {
        c->laws[i].first = arena + laws_at[i];
        c->laws[i].stride = round_up(laws[i]->bytes);
    }
    c->events = (hil_event *)(arena + events_at);
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
