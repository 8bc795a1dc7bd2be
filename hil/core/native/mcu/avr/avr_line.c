#include "avr_line.h"

/* When bit i of a character begins, 0 the start bit. */
static uint64_t begin_of(const avr_character *c, unsigned i) { return c->cycle + (((uint64_t)c->bit_cycles_256 * i) >> 8); }

/* Level of bit i: start, data, stop. */
static int level_of(const avr_character *c, unsigned i)
{
    if (i == 0) return 0;
    return i > c->length ? !c->is_broken : c->bits >> (i - 1) & 1;
}

uint64_t avr_character_end(const avr_character *c) { return begin_of(c, c->length + 2u); }

int avr_character_level(const avr_character *c, uint64_t cycle)
{
    if (cycle < c->cycle || cycle >= avr_character_end(c)) return 1;
    unsigned i = (unsigned)(((cycle - c->cycle) << 8) / c->bit_cycles_256); /* at most one too few: bits begin at whole cycles */
    if (cycle >= begin_of(c, i + 1)) i++;
    return level_of(c, i);
}

static const avr_character *heard(const avr_usart *u, int i) { return &u->heard[(u->heard_first + i) % AVR_HEARD]; }

static int wire_level(const avr_usart *u, uint64_t cycle)
{
    int level = u->wire;
    for (int i = 0; i < u->wire_count && u->wire_at[(u->wire_last + AVR_LEVELS - i) % AVR_LEVELS] > cycle; i++) level = !level;
    return level;
}

int avr_line_level(const avr_usart *u, uint64_t cycle)
{
    for (int i = 0; i < u->heard_count; i++)
        if (!avr_character_level(heard(u, i), cycle)) return 0;
    return wire_level(u, cycle);
}

static int falls_at(const avr_usart *u, uint64_t cycle)
{
    return !avr_line_level(u, cycle) && (cycle == 0 || avr_line_level(u, cycle - 1));
}

uint64_t avr_line_falls(const avr_usart *u, uint64_t from)
{
    uint64_t first = AVR_NEVER;
    int level = u->wire;
    for (int i = 0; i < u->wire_count; i++, level = !level) {
        uint64_t at = u->wire_at[(u->wire_last + AVR_LEVELS - i) % AVR_LEVELS];
        if (at < from) break;
        if (!level && falls_at(u, at)) first = at;
    }
    for (int i = 0; i < u->heard_count; i++) {
        const avr_character *c = heard(u, i);
        if (c->cycle >= first) break;
        for (unsigned bit = 0; bit <= c->length + 1u; bit++) {
            uint64_t at = begin_of(c, bit);
            if (at < from || level_of(c, bit) || !falls_at(u, at)) continue;
            if (at < first) first = at;
            break;
        }
    }
    return first;
}

uint64_t avr_line_next(const avr_usart *u, uint64_t after)
{
    uint64_t first = AVR_NEVER;
    for (int i = 0; i < u->heard_count; i++) {
        const avr_character *c = heard(u, i);
        for (unsigned bit = 0; bit <= c->length + 2u; bit++)
            if (begin_of(c, bit) > after && begin_of(c, bit) < first) first = begin_of(c, bit);
    }
    return first;
}

void avr_line_wire(avr_usart *u, int level, uint64_t cycle)
{
    if (level == u->wire) return;
    u->wire = (uint8_t)level;
    if (u->wire_count && u->wire_at[u->wire_last] == cycle) { /* there and back in one cycle */
        u->wire_last = (uint8_t)((u->wire_last + AVR_LEVELS - 1) % AVR_LEVELS);
        u->wire_count--;
        return;
    }
    u->wire_last = (uint8_t)((u->wire_last + 1) % AVR_LEVELS);
    u->wire_at[u->wire_last] = cycle;
    if (u->wire_count < AVR_LEVELS) u->wire_count++;
}

void avr_line_forget(avr_usart *u, uint64_t ended)
{
    while (u->heard_count && avr_character_end(heard(u, 0)) <= ended) {
        u->heard_first = (uint8_t)((u->heard_first + 1) % AVR_HEARD);
        u->heard_count--;
    }
}
