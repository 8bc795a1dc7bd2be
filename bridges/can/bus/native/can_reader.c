/* The stuffed part of a frame, as it is read. */
#include "can_reader.h"

enum { POLYNOMIAL = 0x4599, CRC_BITS = 15 };

void can_reader_start(can_node *n)
{
    n->at = n->run = n->dlc = 0;
    n->last = 2;
    n->tail = -1;
    n->crc = n->crc_read = n->id = 0;
    n->is_bad = n->is_extended = n->is_remote = 0;
    n->crc_at = 19;
}

/* A bit by its place, from the start of frame, which is 0. */
static void read_field(can_node *n, int at, int level)
{
    if (at == 0) return;
    if (at < 12) {
        n->id = n->id << 1 | (uint32_t)level;
    } else if (at == 12) {
        n->is_remote = (uint8_t)level;
    } else if (at == 13) {
        n->is_extended = (uint8_t)level;
        if (level) n->crc_at = 39;
    } else if (n->is_extended && at < 32) {
        n->id = n->id << 1 | (uint32_t)level;
    } else if (n->is_extended && at == 32) {
        n->is_remote = (uint8_t)level;
    } else {
        at -= n->is_extended ? 35 : 15;
        if (at < 0) return;
        if (at < 4) {
            n->dlc = n->dlc << 1 | level;
            if (at == 3 && !n->is_remote) n->crc_at += 8 * (n->dlc < 8 ? n->dlc : 8);
        } else {
            uint8_t *byte = &n->data[(at - 4) / 8];
            *byte = (uint8_t)(*byte << 1 | level);
        }
    }
}

/* False if it had to be a stuff bit and is none. */
int can_read_bit(can_node *n, int level)
{
    if (n->run == 5) {
        if (level == n->last) return 0;
        n->run = 1;
        n->last = level;
    } else {
        n->run = level == n->last ? n->run + 1 : 1;
        n->last = level;
        int at = n->at++;
        if (at < n->crc_at) {
            uint32_t is_one = (uint32_t)level ^ (n->crc >> 14 & 1);
            n->crc = (n->crc << 1 & 0x7FFF) ^ (is_one ? POLYNOMIAL : 0);
            read_field(n, at, level);
        } else {
            n->crc_read = n->crc_read << 1 | (uint32_t)level;
        }
    }
    if (n->at == n->crc_at + CRC_BITS && n->run != 5) {
        n->tail = 0;
        n->is_bad = n->crc_read != n->crc;
    }
    return 1;
}
