/* TWI as the slave 21h: statuses as they come, what was written, and two bytes to read. */
#include "frame.h"
begin:
    sbi PORTC, 4
    sbi PORTC, 5
    ldi r30, 0
    ldi r31, 2             ; KEPT
    ldi r20, 0x30
    set TWAR, 0x42
    set TWCR, 0xc4
1:  lds r18, TWCR
    sbrs r18, 7
    rjmp 1b
    lds r18, TWSR
    st Z+, r18
    lds r19, TWDR
    sbrc r18, 5            ; A0h and on: it is read
    sts TWDR, r20
    sbrc r18, 5
    inc r20
    st Z+, r19
    set TWCR, 0xc4
    rjmp 1b
