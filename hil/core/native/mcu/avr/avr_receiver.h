/* The receiver of USART0: it samples the line at its own bit times. DS40002061, USART0, Asynchronous Data Reception. */
#ifndef HIL_AVR_RECEIVER_H
#define HIL_AVR_RECEIVER_H

#include "avr_state.h"

void avr_receiver_begins(avr *m, uint64_t at);  /* a frame: who still waits in the shift register is lost to it */
void avr_receiver_take(avr *m, int bit, uint64_t at); /* a bit, at an edge of XCK */
void avr_receiver_put(avr *m, uint16_t value, uint8_t errors); /* into the buffers */
void avr_receiver_event(avr *m, uint64_t at);   /* a start bit, or the end of a frame */
void avr_receiver_look(avr *m, uint64_t at);    /* the line has changed: when does a frame begin? */
void avr_receiver_rate(avr *m, uint64_t at);    /* before bits get another length, or another number: takes those that are over */
void avr_receiver_resume(avr *m, uint64_t at);  /* and after it */
void avr_receiver_enable(avr *m, int is_on, uint64_t at);
uint8_t avr_receiver_read(avr *m);              /* UDR */
void avr_receiver_show(avr *m);                 /* RXC and errors, of what UDR would give */

#endif
