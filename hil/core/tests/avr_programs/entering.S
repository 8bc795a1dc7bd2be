/* One instruction runs after SEI and after RETI before an interrupt; `sei, sleep` sleeps first, and wakes. */
#include "frame.h"
handler_14:                ; OCF0A
    inc r20
    mov r21, r22           ; how far the main program had got
    reti
begin:
    set OCR0A, 5
    set TIMSK0, 2
    set TCCR0B, 1
    .rept 10
    nop
    .endr
    set TCCR0B, 0          ; its flag is up
    ldi r22, 0
    sei
    inc r22                ; this one yet
    inc r22
    cli
    keep 0, r20
    keep 1, r21
    ; sei, cli lets nothing in.
    set TCNT0, 0
    set TCCR0B, 1
    .rept 10
    nop
    .endr
    set TCCR0B, 0
    sei
    cli
    nop
    nop
    keep 2, r20
    ; sei, sleep with a flag up: asleep first, and woken at once.
    set SMCR, 1
    sei
    sleep
    cli
    keep 3, r20
    end
