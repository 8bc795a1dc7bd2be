/* Timer 1 in mode 14, TOP is ICR1 = 99: D9 is high for OCR1A + 1 of 100 clocks. The handler of its match writes OCR1A, which
   is taken at the period's end; D4 changes in each. */
#include "frame.h"
handler_11:
    sbi PIND, 4
    ldi r16, 0
    sts OCR1AH, r16
    ldi r16, 49
    sts OCR1AL, r16
    reti
begin:
    sbi DDRD, 4
    sbi DDRB, 1
    set ICR1H, 0           ; no mode of it yet: not taken
    set TCCR1A, 0x82
    set TCCR1B, 0x18
    set ICR1H, 0
    set ICR1L, 99
    set OCR1AL, 19
    set TIMSK1, 2
    set TCCR1B, 0x19
    sei
9:  rjmp 9b
