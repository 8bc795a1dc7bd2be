/* Packets of the SAC's network: STX, destination, origin, data, ETX, a CRC or not, NUL. No allocation, no I/O.
   What the bytes mean, and what is malformed, is said in device_profiles/sac/packet.py. */
#ifndef SAC_PACKET_H
#define SAC_PACKET_H

#include <stddef.h>
#include <stdint.h>

enum {
    PACKET_STX = 2,
    PACKET_ETX = 3,
    PACKET_TO_ALL = 0, /* the destination that is everybody */
    PACKET_DATA_MAX = 80,
    PACKET_FRAME = 6, /* STX, two addresses, ETX, CRC, NUL; one less without a CRC */
    PACKET_RAW_MAX = PACKET_DATA_MAX + PACKET_FRAME,
};

/* What an item is: a packet, or why its bytes are none. */
enum {
    PACKET_GOOD,
    PACKET_NOISE,
    PACKET_CUT,
    PACKET_ADDRESS,
    PACKET_NO_ETX,
    PACKET_TOO_LONG,
    PACKET_NO_NUL,
};

typedef struct packet_item {
    int kind;
    int len; /* of raw */
    uint8_t crc; /* of a packet; 0: it has none */
    uint8_t raw[PACKET_RAW_MAX];
} packet_item;

/* All zeros: a receiver that has heard nothing. raw has what is not part of an item yet. */
typedef struct packet_decoder {
    int state;
    int len;
    uint8_t raw[PACKET_RAW_MAX];
} packet_decoder;

uint8_t packet_crc8(const uint8_t *data, size_t len);

/* Takes bytes up to and with the one that completes an item, or all of them; *used is how many. Answers
   whether there is an item. One byte completes one item at most. */
int packet_take(packet_decoder *d, const uint8_t *bytes, size_t len, size_t *used, packet_item *item);

/* Writes up to len + PACKET_FRAME bytes and answers how many; len is at most PACKET_DATA_MAX. */
size_t packet_encode(uint8_t *out, uint8_t destination, uint8_t origin, const uint8_t *data, size_t len, int has_crc);

#endif
