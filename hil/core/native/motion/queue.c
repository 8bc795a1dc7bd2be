#include "queue.h"

#include <string.h>

static int wrap(int slot) { return slot == MOTION_QUEUE ? 1 : slot + 1; }

/* A pass of a loop has ended; 0: it was the last. */
static int next_pass(motion_loop *loop)
{
    if (loop->passes == 0 || --loop->passes > 0) return 1;
    memset(loop, 0, sizeof *loop);
    return 0;
}

static int next_of_array(motion *m)
{
    if (m->array.at > MOTION_QUEUE || m->xref[m->array.at] == 0) {
        m->array.at = 0;
        if (m->xref[0] == 0) memset(&m->array, 0, sizeof m->array);
        if (!m->array.is_on || !next_pass(&m->array)) return -1;
    }
    return m->xref[m->array.at++];
}

static int next_of_loop(motion *m)
{
    if (m->loop.at == 0) { /* the finish has run */
        if (!next_pass(&m->loop)) return -1;
        m->loop.at = m->loop.start;
    }
    int slot = m->loop.at;
    m->loop.at = slot == m->loop.finish ? 0 : wrap(slot);
    return slot;
}

int queue_next(motion *m)
{
    int slot = -1;
    if (m->array.is_on) slot = next_of_array(m);
    if (slot < 0 && m->loop.is_on) slot = next_of_loop(m);
    if (slot < 0 && m->pending_len > 0) {
        slot = m->pending[m->pending_first];
        m->pending_first = (m->pending_first + 1) % MOTION_QUEUE;
        m->pending_len--;
    }
    return slot;
}

int queue_add(motion *m, int slot)
{
    if (m->pending_len == MOTION_QUEUE) return 0;
    m->pending[(m->pending_first + m->pending_len++) % MOTION_QUEUE] = (uint8_t)slot;
    return 1;
}

void queue_drop(motion *m)
{
    m->pending_len = 0;
    memset(&m->loop, 0, sizeof m->loop);
    memset(&m->array, 0, sizeof m->array);
}
