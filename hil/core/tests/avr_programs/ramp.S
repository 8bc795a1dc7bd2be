/* Timer 2 in CTC: its handler raises OCR2A, which works at once, for the flag comes when the counter leaves the value.
   D4 changes in each. Idle sleep in between. */
#include "frame.h"
handler_7:
    sbi PIND, 4
    lds r16, OCR2A
    subi r16, -10
    sts OCR2A, r16
    reti
begin:
    sbi DDRD, 4
    set TCCR2A, 2
    set OCR2A, 99
    set TIMSK2, 2
    set SMCR, 1
    set TCCR2B, 2          ; 8 clocks a tick
    sei
again:
    sleep
    rjmp again
