/* Chance: draws from a seed, the same each time. */
#ifndef CAN_CHANCE_H
#define CAN_CHANCE_H

#include <stdint.h>

/* As Chance.bits of hil/wire/byte_faults.py. */
static inline uint64_t can_draw(uint64_t *state)
{
    uint64_t z = *state += UINT64_C(0x9E3779B97F4A7C15);
    z = (z ^ z >> 30) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ z >> 27) * UINT64_C(0x94D049BB133111EB);
    return z ^ z >> 31;
}

#endif
