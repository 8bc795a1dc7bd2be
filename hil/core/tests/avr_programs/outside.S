/* INT0 by its low level, PCINT by a pin that changes, the count of edges at T1, a capture with its noise canceller. */
#include "frame.h"
handler_1:
    cbi EIMSK, 0
    inc r20
    reti
handler_5:
    inc r21
    reti
begin:
    sbi PORTD, 2
    set PCMSK2, 0x10       ; D4
    set PCICR, 4
    set EIMSK, 1
    set TCCR1B, 7          ; rising edges of D5
    sei
1:  in r18, PINB
    sbrs r18, 1            ; until D9
    rjmp 1b
    keep 0, r20
    keep 1, r21
    load_and_keep 2, TCNT1L
    set TCCR1B, 0
    set TCNT1H, 0
    set TCNT1L, 0
    set TIFR1, 0x27
    set TCCR1B, 0xc1       ; rising, four equal samples, each clock
    sbi DDRD, 7
    sbi PORTD, 7           ; D7: count 2 and on
2:  in r18, TIFR1
    sbrs r18, 5
    rjmp 2b
    load_and_keep 3, ICR1L
    load_and_keep 4, ICR1H
    end
