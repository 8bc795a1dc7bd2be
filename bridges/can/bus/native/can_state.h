/* What a CAN wire and its controllers hold. Levels: 0 dominant, 1 recessive. Sections are those of the CAN Specification 2.0 (Bosch, 1991), part B:
   3.1 frames, 6 error handling, 7 fault confinement. */
#ifndef CAN_STATE_H
#define CAN_STATE_H

#include <stdint.h>

enum {
    CAN_NODES_MAX = 256,
    CAN_BITS_MAX = 160,
    CAN_NOISES_MAX = 16,
    CAN_HELD_BITS = 4096, /* a wire that is dominant for so long changes nobody's counters any more */
    CAN_REC_MAX = 255,
    CAN_PASSIVE = 128,
    CAN_OFF = 256,
};

/* States of a controller. Those above IDLE have to do with what is on the wire. */
enum {
    CAN_ABSENT,
    CAN_INTEGRATING,
    CAN_BUS_OFF,
    CAN_IDLE,
    CAN_FRAME,
    CAN_FLAG,
    CAN_PASSIVE_FLAG,
    CAN_WAITING, /* behind a flag, for a recessive bit */
    CAN_DELIMITER,
    CAN_INTERMISSION,
    CAN_SUSPENDED,
};

/* What has happened to a controller in a bit. */
enum { CAN_SENT = 1, CAN_HEARD = 2, CAN_ERROR = 4, CAN_CHANGED = 8 };

enum { CAN_NO_ERROR, CAN_BIT_ERROR, CAN_STUFF_ERROR, CAN_CRC_ERROR, CAN_FORM_ERROR, CAN_ACK_ERROR };

typedef struct can_node {
    int state, count; /* bits of the state that are over */
    int tec, rec;
    int sequences; /* of 11 recessive bits, in bus-off */
    int happened, error;
    int lost; /* arbitrations */
    uint8_t drive; /* level of this bit, or of the next once this one is read */
    uint8_t coming; /* level of the next bit of one with a clock of its own */
    uint8_t is_sender, is_overload, is_first, is_stuck, is_listening, recovers;
    uint8_t is_forgiven; /* this error may not count */
    uint8_t acks; /* 2: takes itself for one that does */
    /* to be sent: in one of its two places */
    const uint8_t *places;
    int next_place, next_size;
    uint32_t next_key;
    int place, sent_bits;
    /* what is read */
    int at, run, last; /* bits so far without stuff bits, level and length of the last run */
    int tail; /* bits behind the CRC; -1: before that */
    int crc_at;
    uint32_t crc, crc_read, id;
    uint8_t is_bad, is_extended, is_remote;
    int dlc;
    uint8_t data[8];
    int64_t start_ns;
    uint64_t no_ack_most, no_ack_state; /* draws up to it are not acknowledged */
    int64_t rate, origin_ns, half_bits; /* of one with a clock of its own; else rate is 0 */
} can_node;

typedef struct can_noise {
    uint64_t most, state;
} can_noise;

typedef struct can_wire {
    can_node *nodes;
    int size;
    int64_t rate, origin_ns, bit;
    int odd; /* nodes with a clock of their own */
    int stuck;
    int level, odd_level, held;
    int noises;
    can_noise noise[CAN_NOISES_MAX];
    int happened, sender;
    int is_asleep, leaps;
    int64_t busy_bits, decided_ns;
} can_wire;

#define CAN_SECOND_NS INT64_C(1000000000)

#endif
