/* The CAN wire: bounds of its memory with everything on it, under the sanitizers. What the bits say is checked from
   Python. */
#include "../can_wire.h"

#include <stdlib.h>
#include <string.h>

#include "../can_chance.h"
#include "../can_errors.h"
#include "check.h"

enum { NODES = 6, RATE = 500000 };

typedef struct bench {
    can_wire w;
    can_node nodes[CAN_NODES_MAX];
    uint8_t places[CAN_NODES_MAX * 2 * CAN_BITS_MAX];
} bench;

static bench *fresh(int leaps)
{
    bench *b = calloc(1, sizeof *b);
    if (!b) exit(2);
    b->w = (can_wire){.nodes = b->nodes, .size = NODES, .rate = RATE, .level = 1, .odd_level = 1, .leaps = leaps,
                      .decided_ns = -1, .sender = -1};
    for (int i = 0; i < NODES; i++)
        b->nodes[i] = (can_node){.state = CAN_INTEGRATING, .drive = 1, .coming = 1, .recovers = 1,
                                 .places = b->places + i * 2 * CAN_BITS_MAX};
    return b;
}

static void put(uint8_t *bits, int *size, unsigned value, int width)
{
    for (int i = width - 1; i >= 0; i--) bits[(*size)++] = value >> i & 1;
}

/* A data frame's bits as they are on the wire; answers how many. */
static int frame(uint8_t *out, unsigned id, const uint8_t *data, int dlc)
{
    uint8_t plain[CAN_BITS_MAX];
    int size = 0, sent = 0, run = 0;
    unsigned crc = 0;
    put(plain, &size, 0, 1);
    put(plain, &size, id, 11);
    put(plain, &size, 0, 3);
    put(plain, &size, (unsigned)dlc, 4);
    for (int i = 0; i < dlc; i++) put(plain, &size, data[i], 8);
    for (int i = 0; i < size; i++) crc = (crc << 1 & 0x7FFF) ^ ((plain[i] ^ (crc >> 14 & 1)) ? 0x4599u : 0);
    put(plain, &size, crc, 15);
    for (int i = 0; i < size; i++) {
        run = i && plain[i] == out[sent - 1] ? run + 1 : 1;
        out[sent++] = plain[i];
        if (run < 5) continue;
        out[sent] = !out[sent - 1];
        sent++;
        run = 1;
    }
    for (int i = 0; i < 10; i++) out[sent++] = 1;
    return sent;
}

static void load(bench *b, int i, unsigned id, const uint8_t *data, int dlc)
{
    can_node *n = &b->nodes[i];
    n->next_place = n->state == CAN_FRAME && n->is_sender ? 1 - n->place : 0;
    n->next_size = frame(b->places + (i * 2 + n->next_place) * CAN_BITS_MAX, id, data, dlc);
    n->next_key = id;
}

static void integrate(bench *b)
{
    for (int i = 0; i < 20; i++) can_tick(&b->w, INT64_MAX);
}

static void a_frame_is_heard(int leaps)
{
    const uint8_t data[] = {0, 0, 0xFF, 0x55, 1};
    bench *b = fresh(leaps);
    integrate(b);
    can_wake(&b->w, can_at(&b->w, b->w.bit));
    load(b, 2, 0x123, data, sizeof data);
    b->w.is_asleep = 0;
    for (int i = 0; i < CAN_BITS_MAX && !(b->w.happened & CAN_SENT); i++) can_tick(&b->w, INT64_MAX);
    CHECK_INT(b->w.sender, 2);
    CHECK_INT(b->nodes[2].tec, 0);
    for (int i = 0; i < NODES; i++) {
        if (i == 2) continue;
        CHECK_INT(b->nodes[i].happened & CAN_ERROR, 0);
        CHECK_INT(b->nodes[i].happened & CAN_HEARD, CAN_HEARD);
        if (leaps) continue; /* what is said is known then */
        CHECK_INT(b->nodes[i].id, 0x123);
        CHECK_INT(b->nodes[i].dlc, sizeof data);
        CHECK(!memcmp(b->nodes[i].data, data, sizeof data));
    }
    free(b);
}

static void a_frame_is_heard_bit_by_bit(void) { a_frame_is_heard(0); }

static void a_frame_is_heard_at_once(void) { a_frame_is_heard(1); }

static void nobody_acknowledges(void)
{
    const uint8_t data[] = {7};
    bench *b = fresh(0);
    for (int i = 1; i < NODES; i++) b->nodes[i].is_listening = 1;
    integrate(b);
    load(b, 0, 5, data, 1);
    for (int i = 0; i < 20000; i++) can_tick(&b->w, INT64_MAX);
    CHECK_INT(b->nodes[0].tec, CAN_PASSIVE); /* 7, rule 3, exception 1 */
    free(b);
}

/* Something happens to a node, by chance. */
static void disturb(bench *b, uint64_t *chance)
{
    uint64_t drawn = can_draw(chance);
    int i = (int)(drawn % NODES), dlc = (int)(drawn >> 8 & 15);
    can_node *n = &b->nodes[i];
    uint8_t data[8];
    memcpy(data, &drawn, sizeof data);
    switch (drawn >> 16 & 15) {
    case 0: can_go_off(n); break;
    case 1: n->recovers = !n->recovers; break;
    case 2: n->is_listening = !n->is_listening; break;
    case 3: n->no_ack_most = n->no_ack_most ? 0 : UINT64_MAX / 2; break;
    case 4:
        b->w.odd += n->rate ? -1 : 1;
        n->rate = n->rate ? 0 : RATE + (int64_t)(drawn >> 20 & 0xFFFF) - 0x8000;
        n->origin_ns = can_at(&b->w, b->w.bit);
        n->half_bits = -1;
        break;
    case 5: b->w.stuck = !b->w.stuck; break;
    case 6:
        b->w.noises = (int)(drawn >> 20 & 3);
        for (int j = 0; j < b->w.noises; j++) b->w.noise[j] = (can_noise){UINT64_MAX >> (drawn >> 24 & 15), drawn};
        break;
    case 7: can_wake(&b->w, can_at(&b->w, b->w.bit) + (int64_t)(drawn >> 40)); break;
    default: load(b, i, (unsigned)(drawn >> 20 & 0x7FF), data, dlc < 8 ? dlc : 8);
    }
    b->w.is_asleep = 0;
}

/* A million bits with everything that may go wrong: no index leaves its array, no counter its range. */
static void anything_happens(void)
{
    uint64_t chance = 1;
    bench *b = fresh(1);
    for (int i = 0; i < 1000000; i++) {
        if (can_draw(&chance) % 40 == 0) disturb(b, &chance);
        if (i % 50000 == 0) b->w.stuck = b->w.noises = 0;
        int64_t before_ns = can_at(&b->w, b->w.bit);
        can_tick(&b->w, can_at(&b->w, b->w.bit + 200));
        CHECK(can_at(&b->w, b->w.bit) >= before_ns);
        for (int j = 0; j < NODES; j++) {
            CHECK(b->nodes[j].rec >= 0 && b->nodes[j].rec <= CAN_REC_MAX);
            CHECK(b->nodes[j].tec >= 0 && b->nodes[j].tec < CAN_OFF + 8);
        }
    }
    free(b);
}

void can_wire_tests(void)
{
    RUN(a_frame_is_heard_bit_by_bit);
    RUN(a_frame_is_heard_at_once);
    RUN(nobody_acknowledges);
    RUN(anything_happens);
}
