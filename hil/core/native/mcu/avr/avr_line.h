/* The serial line to D0 as the world gives it: characters that are known before they come, and a wire's level.
   Both are open-drain: low if one is. Times are the world's cycles. */
#ifndef HIL_AVR_LINE_H
#define HIL_AVR_LINE_H

#include "avr_state.h"

/* Level of a character's line at a cycle; 1 where it is not there. */
int avr_character_level(const avr_character *c, uint64_t cycle);

/* The first cycle after its stop bit. */
uint64_t avr_character_end(const avr_character *c);

int avr_line_level(const avr_usart *u, uint64_t cycle);

/* The first cycle, from one on, at which the line falls; AVR_NEVER: none is known. */
uint64_t avr_line_falls(const avr_usart *u, uint64_t from);

/* The first cycle after one at which the characters' level may change; AVR_NEVER: none. */
uint64_t avr_line_next(const avr_usart *u, uint64_t after);

void avr_line_wire(avr_usart *u, int level, uint64_t cycle);

/* Forgets characters that have ended at a cycle. */
void avr_line_forget(avr_usart *u, uint64_t ended);

#endif
