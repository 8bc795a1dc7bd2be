/* Frame of the programs here: vectors, a start, and words for what they all do. Registers up to 3Fh have addresses of
   I/O. They keep results from KEPT on, and end in a loop with GPIOR0 at 0xA5. */
#define __SFR_OFFSET 0
#include <avr/io.h>
#define KEPT 0x200

/* A handler that the program has not is at 0: it begins again. */
.macro vector n
    jmp handler_\n
    .weak handler_\n
.endm
.macro set address, value
    ldi r16, \value
    .if (\address) < 0x40
    out \address, r16
    .else
    sts \address, r16
    .endif
.endm
.macro keep n, register
    sts KEPT + \n, \register
.endm
.macro load_and_keep n, address
    .if (\address) < 0x40
    in r17, \address
    .else
    lds r17, \address
    .endif
    sts KEPT + \n, r17
.endm
.macro end
    ldi r16, 0xa5
    out GPIOR0, r16
9:  rjmp 9b
.endm

.section .text
    jmp begin
    .irp n, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25
    vector \n
    .endr
