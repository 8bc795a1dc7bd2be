/* Ports: the synchroniser, toggles by PIN, pull-ups, flags that SBI clears alone. */
#include "frame.h"
begin:
    ldi r18, 0x0f
    out DDRD, r18
    ldi r18, 0x05
    out PORTD, r18
    in r19, PIND           ; not there yet
    nop
    in r20, PIND
    keep 0, r19
    keep 1, r20
    sbi PIND, 1            ; toggles this one alone
    in r19, PORTD
    keep 2, r19
    cbi PIND, 0            ; nothing
    in r19, PORTD
    keep 3, r19
    ldi r18, 0x03
    out PIND, r18          ; toggles both
    in r19, PORTD
    keep 4, r19
    ; B0 is held low from outside, B1 is open: pull-ups, then none of them.
    ldi r18, 0x03
    out PORTB, r18
    nop
    in r19, PINB
    keep 5, r19
    ldi r18, 0x10          ; PUD
    out MCUCR, r18
    nop
    in r19, PINB
    keep 6, r19
    ldi r18, 0
    out MCUCR, r18
    ; Both compare flags are up: SBI clears one.
    set OCR0A, 3
    set OCR0B, 3
    set TCCR0B, 1
    .rept 8
    nop
    .endr
    set TCCR0B, 0
    sbi TIFR0, 1
    in r19, TIFR0
    keep 7, r19
    end
