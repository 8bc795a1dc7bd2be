/* SPI as a master, in the mode and order that GPIOR1 tells: a byte out and a byte in. SS is D10. */
#include "frame.h"
begin:
    sbi PORTB, 2
    ldi r18, 0x2c
    out DDRB, r18
    in r18, GPIOR1
    ori r18, 0x51          ; on, master, 16 clocks a bit
    out SPCR, r18
    .rept 200
    nop
    .endr
    cbi PORTB, 2
    .rept 40
    nop
    .endr
    ldi r18, 0xc5
    out SPDR, r18
    out SPDR, r18          ; too early
    in r19, SPSR
    keep 0, r19
1:  in r19, SPSR
    sbrs r19, 7
    rjmp 1b
    in r20, SPDR
    keep 1, r20
    in r19, SPSR
    keep 2, r19
    sbi PORTB, 2
    end
