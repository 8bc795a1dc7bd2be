/* Matches that come while a handler is entered, or after their flag was up for long, count once each. GPIOR1 tells where TCNT2
   begins. */
#include "frame.h"
handler_7:                 ; OCF2A
    ldi r16, 0
    sts TCCR2B, r16
    inc r20
    reti
handler_15:                ; OCF0B
    inc r21
    reti
begin:
    set TCCR2A, 2
    set OCR2A, 22
    set TIMSK2, 2
    in r18, GPIOR1
    sts TCNT2, r18
    set TCCR2B, 1
    .rept 30
    nop
    .endr
    sei
    nop                    ; entered 32 clocks after it began to count
    .rept 20
    nop
    .endr
    cli
    keep 0, r20
    ; A match at 11, the flag up; one more at 117; served from 152 on. The next is at 223.
    set TCCR0A, 2
    set OCR0A, 0x69
    set OCR0B, 0x0a
    set TIMSK0, 4
    set TCCR0B, 1
    .rept 150
    nop
    .endr
    sei
    .rept 51
    nop
    .endr
    cli
    keep 1, r21
    end
