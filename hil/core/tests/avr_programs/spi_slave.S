/* SPI as a slave, in the mode and order that GPIOR1 tells. */
#include "frame.h"
begin:
    sbi DDRB, 4
    in r18, GPIOR1
    ori r18, 0x40
    out SPCR, r18
    ldi r18, 0x93
    out SPDR, r18
1:  in r19, SPSR
    sbrs r19, 7
    rjmp 1b
    in r20, SPDR
    keep 0, r20
    end
