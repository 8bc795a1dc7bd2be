/* What a debugger and a profile hold of a chip: data alone. */
#ifndef HIL_AVR_DEBUG_STATE_H
#define HIL_AVR_DEBUG_STATE_H

#include <stdint.h>

enum { AVR_FUNCTIONS = 512, AVR_LAPS = 1024 };

typedef struct avr_debug {
    uint8_t is_on;      /* one instruction is carried out at a time, and it is looked here before each */
    uint8_t is_halted;  /* it stands, until avr_go */
    uint8_t is_counting;
    uint8_t steps;      /* instructions until it halts, and one; 0: it does not */

    uint64_t since;                   /* clock at which counting began */
    uint16_t functions, last;         /* how many there are; the one that an instruction was of last */
    uint16_t starts[AVR_FUNCTIONS];   /* their first words, ascending */
    uint64_t spent[AVR_FUNCTIONS];    /* clocks of their instructions */
    uint32_t calls[AVR_FUNCTIONS];    /* times that their first instruction was carried out */
    int32_t lap_at;                   /* word whose times are kept; -1: none */
    uint64_t lap_from, laps;          /* when it was there last; how often since then */
    uint32_t lap[AVR_LAPS];           /* clocks from one time to the next, the latest */
} avr_debug;

#endif
