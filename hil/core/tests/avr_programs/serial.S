/* USART: UDR before TXEN stays, UDRE, two bytes back to back; then 9 bits and even parity come in. */
#include "frame.h"
begin:
    set UBRR0L, 0          ; U2X: 8 clocks a bit
    set UCSR0A, 2
    set UDR0, 'x'
    set UDR0, 'a'
    load_and_keep 0, UCSR0A
    set UCSR0B, 8
    set UCSR0B, 0x18
1:  lds r18, UCSR0A
    sbrs r18, 5
    rjmp 1b
    set UDR0, 'b'
    set UDR0, 'c'          ; UDRE is 0: ignored
    load_and_keep 1, UCSR0A
2:  lds r18, UCSR0A
    sbrs r18, 6
    rjmp 2b
    keep 2, r18
    ; 9 bits and even parity at 16 x 4 clocks.
    set UCSR0A, 0x40
    set UBRR0L, 3
    set UCSR0C, 0x26
    set UCSR0B, 0x14
    ldi r30, 3
    ldi r31, 2             ; KEPT + 3
    ldi r20, 3
3:  lds r18, UCSR0A
    sbrs r18, 7
    rjmp 3b
    lds r19, UCSR0B
    lds r21, UDR0
    st Z+, r18
    st Z+, r19
    st Z+, r21
    dec r20
    brne 3b
    end
