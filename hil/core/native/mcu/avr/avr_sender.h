/* The transmitter's shift register, and who drives RXD and TXD: DS40002061, USART0, Data Transmission. */
#ifndef HIL_AVR_SENDER_H
#define HIL_AVR_SENDER_H

#include "avr_state.h"

/* Bits that are over at a clock, of a frame under way. */
unsigned avr_sender_over(const avr *m, uint64_t at);

int avr_sender_level(const avr *m, uint64_t at); /* at TXD */
uint64_t avr_sender_next_level(const avr *m, uint64_t after); /* when TXD's level may change next */

void avr_sender_begin(avr *m, uint32_t bit_clocks, uint64_t at); /* what waits goes to the shift register */
void avr_sender_schedule(avr *m); /* when the frame under way is over, by the registers as they are */

/* TXD is the transmitter's while it is on or a frame is under way; RXD the receiver's. */
void avr_sender_show(avr *m, uint64_t at);

#endif
