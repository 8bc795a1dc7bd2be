/* USART0: its registers. DS40002061, USART0. */
#ifndef HIL_AVR_USART_H
#define HIL_AVR_USART_H

#include "avr_state.h"

void avr_usart_sent(avr *m, uint64_t at); /* event: a frame is over, or one may begin */

uint8_t avr_usart_load(avr *m, unsigned address, uint64_t at);
void avr_usart_store(avr *m, unsigned address, uint8_t value, uint64_t at);
void avr_usart_shift(avr *m, uint64_t clocks);

#endif
