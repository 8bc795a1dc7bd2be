#include "packet.h"

#include <string.h>

/* UNCHECKED: a packet without CRC has just ended. */
enum { OUTSIDE, DESTINATION, ORIGIN, DATA, CRC, END, UNCHECKED };

/* Dallas/Maxim: x^8 + x^5 + x^4 + 1, least significant bit first, from 0. Four bits at a time. */
uint8_t packet_crc8(const uint8_t *data, size_t len)
{
    static const uint8_t LOW[16] = {0x00, 0x5e, 0xbc, 0xe2, 0x61, 0x3f, 0xdd, 0x83, 0xc2, 0x9c, 0x7e, 0x20, 0xa3, 0xfd, 0x1f, 0x41};
    static const uint8_t HIGH[16] = {0x00, 0x9d, 0x23, 0xbe, 0x46, 0xdb, 0x65, 0xf8, 0x8c, 0x11, 0xaf, 0x32, 0xca, 0x57, 0xe9, 0x74};
    uint8_t crc = 0;
    for (size_t i = 0; i < len; i++) {
        crc ^= data[i];
        crc = LOW[crc & 15] ^ HIGH[crc >> 4];
    }
    return crc;
}

/* The first n bytes held are an item. */
static int give(packet_decoder *d, int kind, int n, packet_item *item)
{
    item->kind = kind;
    item->len = n;
    item->crc = 0;
    memcpy(item->raw, d->raw, (size_t)n);
    d->len = 0;
    d->state = OUTSIDE;
    return 1;
}

static void begin(packet_decoder *d)
{
    d->raw[0] = PACKET_STX;
    d->len = 1;
    d->state = DESTINATION;
}

static int one(packet_decoder *d, uint8_t byte, packet_item *item)
{
    if (d->state == UNCHECKED) {
        d->state = OUTSIDE;
        if (byte == 0) return 0; /* idle: whoever sends the CRC's place whatever is in it ends with one more */
    }
    /* Only the CRC is read by its place; anywhere else an STX begins a packet, whatever was before it. */
    if (byte == PACKET_STX && d->state != CRC) {
        int held = d->len, was = d->state;
        if (held) give(d, was == OUTSIDE ? PACKET_NOISE : was == END ? PACKET_NO_NUL : PACKET_CUT, held, item);
        begin(d);
        return held > 0;
    }
    d->raw[d->len++] = byte;
    switch (d->state) {
    case OUTSIDE:
        return d->len == PACKET_RAW_MAX && give(d, PACKET_NOISE, d->len, item);
    case DESTINATION:
    case ORIGIN:
        if (byte == PACKET_ETX) return give(d, PACKET_ADDRESS, d->len, item);
        d->state++;
        return 0;
    case DATA:
        if (byte == PACKET_ETX)
            d->state = CRC;
        else if (byte == 0)
            return give(d, PACKET_NO_ETX, d->len, item);
        else if (d->len == 3 + PACKET_DATA_MAX + 1)
            return give(d, PACKET_TOO_LONG, d->len, item);
        return 0;
    case CRC:
        if (byte == 0) {
            give(d, PACKET_GOOD, d->len, item);
            d->state = UNCHECKED;
            return 1;
        }
        d->state = END;
        return 0;
    default: /* END */
        if (byte == 0) {
            uint8_t crc = d->raw[d->len - 2];
            give(d, PACKET_GOOD, d->len, item);
            item->crc = crc;
            return 1;
        }
        /* If the next packet's STX stood in the CRC's place, this is its destination. */
        if (d->raw[d->len - 2] != PACKET_STX || byte == PACKET_ETX) return give(d, PACKET_NO_NUL, d->len, item);
        give(d, PACKET_NO_NUL, d->len - 2, item);
        begin(d);
        d->raw[d->len++] = byte;
        d->state = ORIGIN;
        return 1;
    }
}

int packet_take(packet_decoder *d, const uint8_t *bytes, size_t len, size_t *used, packet_item *item)
{
    for (size_t i = 0; i < len; i++)
        if (one(d, bytes[i], item)) {
            *used = i + 1;
            return 1;
        }
    *used = len;
    return 0;
}

size_t packet_encode(uint8_t *out, uint8_t destination, uint8_t origin, const uint8_t *data, size_t len, int has_crc)
{
    uint8_t *end = out + 3 + len;
    out[0] = PACKET_STX;
    out[1] = destination;
    out[2] = origin;
    if (len) memcpy(out + 3, data, len);
    *end++ = PACKET_ETX;
    if (has_crc) *end++ = packet_crc8(data, len);
    *end++ = 0;
    return (size_t)(end - out);
}
