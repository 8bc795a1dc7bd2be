/* USART0 where bits go by a clock at XCK (D4): synchronous frames, and as a master of SPI. DS40002061, USART0, Synchronous
   Clock Operation, and USART in SPI Mode.

   The clock is its own where the pin is an output, and a frame of SPI alone makes it run; else it is another's. Edges on
   which a bit is put out and those on which one is taken in follow each other. */
#ifndef HIL_AVR_CLOCKED_H
#define HIL_AVR_CLOCKED_H

#include "avr_registers.h"
#include "avr_state.h"

static inline int avr_is_clocked(const avr *m) { return m->data[UCSR0C] & UMSEL; }
static inline int avr_is_spi(const avr *m) { return (m->data[UCSR0C] & UMSEL) == UMSEL; }

void avr_clocked_event(avr *m, uint64_t at);              /* half a period of its own clock is over */
void avr_clocked_edge(avr *m, int is_high, uint64_t at);  /* of another's clock */
void avr_clocked_look(avr *m, uint64_t at);               /* registers of the USART have changed, or UDR was written */

#endif
