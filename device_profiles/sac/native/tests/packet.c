/* The packet codec: bounds of its memory, under the sanitizers. What it reads is checked from Python. */
#include "../packet.h"

#include <string.h>

#include "check.h"

static void what_is_encoded_comes_back(void)
{
    uint8_t data[PACKET_DATA_MAX], wire[PACKET_RAW_MAX];
    memset(data, 'm', sizeof data);
    for (size_t i = 0; i <= 2 * PACKET_DATA_MAX + 1; i++) {
        packet_decoder d = {0};
        packet_item item;
        size_t used, len = i / 2, size = packet_encode(wire, 85, 1, data, len, i % 2);
        uint8_t crc = i % 2 ? packet_crc8(data, len) : 0;
        CHECK_INT(size, len + PACKET_FRAME - (i % 2 == 0));
        CHECK_INT(packet_take(&d, wire, size, &used, &item), 1);
        CHECK_INT(used, len + PACKET_FRAME - (crc == 0));
        CHECK_INT(item.kind, PACKET_GOOD);
        CHECK_INT(item.crc, crc);
        CHECK_INT(item.len, used);
        CHECK(!memcmp(item.raw, wire, used));
        CHECK_INT(packet_take(&d, wire + used, size - used, &used, &item), 0); /* of an empty one's CRC, 0 */
        CHECK_INT(d.len, 0);
    }
}

/* A million bytes that are mostly frame characters: nothing is written out of bounds, no byte is lost. */
static void any_bytes_are_taken(void)
{
    static const uint8_t OFTEN[] = {0, PACKET_STX, PACKET_ETX, 'm'};
    packet_decoder d = {0};
    uint32_t state = 1;
    size_t fed = 0, given = 0, idle = 0;
    for (int i = 0; i < 1000000; i++) {
        state = state * 1664525 + 1013904223;
        uint8_t byte = state >> 31 ? (state >> 29 & 1 ? OFTEN[state >> 20 & 3] : (uint8_t)(state >> 12)) : 'y';
        packet_item item;
        size_t used;
        fed++;
        int before = d.len;
        if (packet_take(&d, &byte, 1, &used, &item)) given += (size_t)item.len;
        else if (d.len == before) idle++;
        CHECK_INT(used, 1);
        CHECK(d.len >= 0 && d.len < PACKET_RAW_MAX);
    }
    CHECK_INT(given + (size_t)d.len + idle, fed);
    CHECK(idle > 0 && idle < fed / 10);
}

void packet_tests(void)
{
    RUN(what_is_encoded_comes_back);
    RUN(any_bytes_are_taken);
}
