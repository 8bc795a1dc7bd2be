/* Timer 1 in mode 8, TOP is ICR1 = 50, OCR1A = 0: D9 stays low; then OCR1A = 50: high; then 20 in mode 10. D4 tells. */
#include "frame.h"
.macro wait
    ldi r18, 200
1:  dec r18
    brne 1b
.endm
begin:
    sbi DDRB, 1
    sbi DDRD, 4
    set TCCR1A, 0x80
    set TCCR1B, 0x10
    set ICR1L, 50
    set TCCR1B, 0x11
    wait
    sbi PIND, 4
    set OCR1AL, 50
    wait
    sbi PIND, 4
    set TCCR1A, 0x82       ; mode 10
    set OCR1AL, 20
    wait
    wait
    sbi PIND, 4
    end
