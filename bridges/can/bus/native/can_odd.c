/* Nodes with a clock of their own. */
#include "can_odd.h"

#include "can_node.h"

static int level_with_odd(const can_wire *w, int level)
{
    for (int i = 0; i < w->size; i++)
        if (w->nodes[i].rate) level &= w->nodes[i].drive;
    return level;
}

/* Let those that drive nothing begin a bit where the wire becomes dominant. */
static void synchronise(can_wire *w, int others, int64_t now_ns)
{
    int level = level_with_odd(w, others);
    if (w->odd_level == level) return;
    w->odd_level = level;
    if (level) return;
    for (int i = 0; i < w->size; i++) {
        can_node *n = &w->nodes[i];
        /* For one that drives dominant the edge may be its own. */
        if (!n->rate || !n->drive || !n->state) continue;
        n->origin_ns = now_ns;
        n->half_bits = 0;
        n->drive = n->coming;
    }
}

/* The first whose half bit ends before a time, or none; its time. */
static can_node *first_due(can_wire *w, int64_t *until_ns)
{
    can_node *first = 0;
    for (int i = 0; i < w->size; i++) {
        can_node *n = &w->nodes[i];
        if (!n->rate || !n->state) continue;
        int64_t due_ns = n->origin_ns + (n->half_bits + 1) * CAN_SECOND_NS / (2 * n->rate);
        if (due_ns >= *until_ns) continue;
        first = n;
        *until_ns = due_ns;
    }
    return first;
}

/* At the begin of its bit a node drives, in the middle it reads. */
static void half_bit(can_wire *w, can_node *n, int others, int64_t now_ns)
{
    if (++n->half_bits % 2 == 0) {
        if (n->state == CAN_IDLE && n->next_size) {
            can_begin(n, now_ns);
            n->coming = 0;
        }
        n->drive = n->coming;
        return;
    }
    uint8_t driven = n->drive;
    can_step(n, level_with_odd(w, others), now_ns);
    n->coming = n->drive;
    /* What it has decided in the middle counts from its next bit on; off the bus it lets go at once. */
    n->drive = n->state == CAN_BUS_OFF ? 1 : driven;
    w->happened |= n->happened;
}

static void go_on(can_wire *w, int others, int64_t now_ns, int64_t until_ns)
{
    for (;;) {
        synchronise(w, others, now_ns);
        int64_t due_ns = until_ns;
        can_node *n = first_due(w, &due_ns);
        if (!n) return;
        now_ns = due_ns;
        half_bit(w, n, others, now_ns);
    }
}

/* Let them have what falls into a bit, with the level that the others drive; answers the level in the middle. */
int can_tick_odd(can_wire *w, int level, int64_t start_ns, int64_t middle_ns, int64_t end_ns)
{
    go_on(w, level, start_ns, middle_ns);
    int in_the_middle = level_with_odd(w, level);
    go_on(w, level, middle_ns, end_ns);
    return in_the_middle;
}
