/* What TCNT0 and TCNT1 show after they were written, and what a write does to a match. */
#include "frame.h"
begin:
    set TCCR0B, 1
    ldi r18, 10
    out TCNT0, r18
    in r19, TCNT0          ; as written
    keep 0, r19
    out TCNT0, r18
    nop
    lds r19, TCNT0 + 0x20  ; two later
    keep 1, r19
    set TCCR0B, 0
    ; A write of OCR0A's value is no match, the next round is.
    set TCCR0A, 2          ; CTC
    set OCR0A, 20
    set TIFR0, 7
    set TCNT0, 20
    set TCCR0B, 1
    nop
    nop
    in r19, TIFR0
    keep 2, r19
    in r19, TCNT0          ; ran past it
    keep 3, r19
    set TCCR0B, 0
    ; CTC with TCNT above OCR: to FFh first, where TOV is set; at OCR it is not.
    set TCNT0, 250
    set TIFR0, 7
    set TCCR0B, 1
    .rept 10
    nop
    .endr
    in r19, TIFR0
    keep 4, r19
    set TIFR0, 7
    .rept 40
    nop
    .endr
    in r19, TIFR0
    keep 5, r19
    ; Bytes of TCNT1 go by TEMP; OCR1A's are read without it.
    set TCNT1H, 0x12
    set TCNT1L, 0x34
    set OCR1AH, 0x56
    set OCR1AL, 0x78
    lds r20, TCNT1L
    lds r19, OCR1AH
    lds r21, TCNT1H
    keep 6, r20
    keep 7, r19
    keep 8, r21
    end
