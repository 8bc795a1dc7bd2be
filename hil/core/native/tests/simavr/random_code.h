/* Random code for an ATmega328P: all opcodes that it has, with memory that no part of the chip answers at. */
#ifndef HIL_RANDOM_CODE_H
#define HIL_RANDOM_CODE_H

#include <stdint.h>

typedef struct chance { uint64_t state; } chance;

/* splitmix64: each seed is as good as another, 0 too. */
static inline uint64_t draw(chance *c)
{
    uint64_t z = c->state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

/* 0 to n - 1 */
static inline unsigned draw_below(chance *c, unsigned n) { return (unsigned)((draw(c) >> 32) * n >> 32); }

void random_code(chance *c, uint16_t *words, unsigned n);

#endif
