/* The wire: bits of all nodes in step, and leaps over frames that nothing disturbs. */
#include "can_wire.h"

#include "can_chance.h"
#include "can_node.h"
#include "can_odd.h"

int64_t can_at(const can_wire *w, int64_t bit) { return w->origin_ns + bit * CAN_SECOND_NS / w->rate; }

static int64_t middle_ns(const can_wire *w) { return w->origin_ns + (2 * w->bit + 1) * CAN_SECOND_NS / (2 * w->rate); }

/* True if everybody only waits, so that the next bit may begin at any time. */
static int is_quiet(const can_wire *w)
{
    for (int i = 0; i < w->size; i++) {
        const can_node *n = &w->nodes[i];
        if (n->rate && n->state) return 0;
        if ((n->state == CAN_IDLE && n->next_size) || (n->state > CAN_IDLE && n->state != CAN_SUSPENDED)) return 0;
    }
    return 1;
}

/* Go on now, if it sleeps or everybody only waits: the next bit begins at this time. */
void can_wake(can_wire *w, int64_t now_ns)
{
    if ((!w->is_asleep && !is_quiet(w)) || can_at(w, w->bit) > now_ns) return;
    if (w->is_asleep && !w->level) { /* with the phase that it had, for those who are still in step */
        int64_t over_ns = now_ns - w->origin_ns, before = w->bit;
        w->bit = over_ns % CAN_SECOND_NS * w->rate / CAN_SECOND_NS;
        w->origin_ns += over_ns / CAN_SECOND_NS * CAN_SECOND_NS;
        w->busy_bits += over_ns / CAN_SECOND_NS * w->rate + w->bit - before;
    } else {
        w->origin_ns = now_ns;
        w->bit = 0;
    }
    for (int i = 0; i < w->size; i++) {
        w->nodes[i].origin_ns = now_ns;
        w->nodes[i].half_bits = -1;
    }
    w->held = 0;
    w->is_asleep = 0;
}

static int is_in_leap(const can_node *n) { return n->state != CAN_ABSENT && (n->state != CAN_BUS_OFF || n->recovers); }

/* The one that wins the arbitration, if its frame will be good for all and nobody's state changes; else none.
   A number has the bits from the identifier to RTR: the lowest is of the one that step_contradicted of can_node.c leaves
   as sender. */
static can_node *undisturbed_sender(const can_wire *w)
{
    can_node *best = 0;
    int is_tie = 0, ackers = 0;
    if (w->odd || w->stuck) return 0;
    for (int i = 0; i < w->size; i++) {
        can_node *n = &w->nodes[i];
        if (!is_in_leap(n)) continue;
        /* At 128 a good frame makes it active again, a receiver before the frame's end. */
        if (n->rec >= CAN_PASSIVE || n->tec == CAN_PASSIVE || n->no_ack_most) return 0;
        if (n->state != CAN_IDLE && n->state != CAN_SUSPENDED) return 0;
        ackers += !n->is_listening;
        if (n->state != CAN_IDLE || !n->next_size) continue;
        /* Two of one number go on side by side behind the arbitration: what comes of it is left to the bits. */
        is_tie = best ? (n->next_key == best->next_key || (is_tie && n->next_key > best->next_key)) : 0;
        if (!best || n->next_key < best->next_key) best = n;
    }
    /* The sender is counted among them, and needs another one. */
    return is_tie || ackers < 2 ? 0 : best;
}

/* True if no noise hits the next bits; then they are drawn. */
static int is_spared(can_wire *w, int bits)
{
    uint64_t states[CAN_NOISES_MAX];
    for (int j = 0; j < w->noises; j++) {
        states[j] = w->noise[j].state;
        for (int i = 0; i < bits; i++)
            if (can_draw(&states[j]) <= w->noise[j].most) return 0;
    }
    /* As many draws as the bits make: noise hits the same ones, whether a frame is leapt over or not. */
    for (int j = 0; j < w->noises; j++) w->noise[j].state = states[j];
    return 1;
}

/* Leap to the end of a frame; false if something may disturb it. */
static int leap(can_wire *w, int64_t limit_ns)
{
    can_node *sender = undisturbed_sender(w);
    if (!sender) return 0;
    int bits = sender->next_size;
    if (can_at(w, w->bit + bits) > limit_ns || !is_spared(w, bits)) return 0;
    int64_t now_ns = can_at(w, w->bit);
    for (int i = 0; i < w->size; i++) {
        can_node *n = &w->nodes[i];
        if (n->state == CAN_ABSENT || n->state == CAN_BUS_OFF) continue;
        n->start_ns = now_ns;
        n->is_sender = n == sender;
        if (n == sender) {
            n->place = n->next_place;
            can_sent(n);
            continue;
        }
        n->lost += n->state == CAN_IDLE && n->next_size;
        if (!n->is_listening) can_good(n);
        n->happened |= CAN_HEARD;
        n->state = CAN_INTERMISSION;
        n->count = 0;
    }
    w->happened = CAN_SENT | CAN_HEARD;
    w->sender = (int)(sender - w->nodes);
    w->bit += bits;
    w->busy_bits += bits;
    w->level = w->odd_level = 1;
    w->held = 0;
    return 1;
}

/* The sender, if one alone has sent, and others have heard it or nothing. */
static int lone_sender(const can_wire *w)
{
    int sender = -1;
    for (int i = 0; i < w->size; i++) {
        if (w->nodes[i].happened & (CAN_ERROR | CAN_CHANGED)) return -1;
        if (w->nodes[i].happened & CAN_SENT) {
            if (sender >= 0) return -1;
            sender = i;
        }
    }
    return sender;
}

/* True if nothing will happen until somebody does something. */
static int is_settled(const can_wire *w)
{
    if (w->stuck) return w->held >= CAN_HELD_BITS;
    if (!w->level) return 0;
    for (int i = 0; i < w->size; i++) {
        const can_node *n = &w->nodes[i];
        if (n->state > CAN_IDLE || n->state == CAN_INTEGRATING) return 0;
        if (n->state == CAN_IDLE ? n->next_size : n->state == CAN_BUS_OFF && n->recovers) return 0;
    }
    return 1;
}

static void forget_what_happened(can_wire *w)
{
    if (!w->happened) return;
    w->happened = 0;
    w->sender = -1;
    for (int i = 0; i < w->size; i++) w->nodes[i].happened = 0;
}

/* Let those begin that have something; answers what all together drive, and in is_busy whether anybody is on it. */
static int drive(can_wire *w, int64_t now_ns, int *is_busy)
{
    int level = !w->stuck;
    for (int i = 0; i < w->size; i++) {
        can_node *n = &w->nodes[i];
        if (n->state == CAN_IDLE && n->next_size && !n->rate) can_begin(n, now_ns);
        if (n->state <= CAN_IDLE) continue;
        *is_busy |= n->state != CAN_SUSPENDED;
        if (!n->rate) level &= n->drive;
    }
    return level;
}

/* Go on by a bit, or by a frame that ends before the limit. */
void can_tick(can_wire *w, int64_t limit_ns)
{
    forget_what_happened(w);
    /* By whole seconds: a bit's time that is no whole number of nanoseconds leaves no rounding behind. */
    if (w->bit >= w->rate) {
        w->origin_ns += w->bit / w->rate * CAN_SECOND_NS;
        w->bit %= w->rate;
    }
    int64_t now_ns = can_at(w, w->bit);
    int begins = 0, is_busy = 0;
    for (int i = 0; i < w->size; i++) {
        if (w->nodes[i].state != CAN_IDLE) continue;
        w->decided_ns = now_ns;
        begins |= w->nodes[i].next_size;
    }
    if (begins && w->leaps && leap(w, limit_ns)) return;
    int level = drive(w, now_ns, &is_busy);
    if (w->odd) level = can_tick_odd(w, level, now_ns, middle_ns(w), can_at(w, w->bit + 1));
    if (is_busy || !level) {
        w->busy_bits++;
        for (int i = 0; i < w->noises; i++) level ^= can_draw(&w->noise[i].state) <= w->noise[i].most;
    }
    w->level = level;
    w->held = level ? 0 : w->held + 1;
    for (int i = 0; i < w->size; i++) {
        can_node *n = &w->nodes[i];
        if (!n->state || n->rate) continue;
        can_step(n, level, now_ns);
        w->happened |= n->happened;
    }
    w->bit++;
    if (w->happened) w->sender = lone_sender(w);
    w->is_asleep = is_settled(w);
}
