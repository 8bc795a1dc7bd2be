/* The watchdog: WDCE and WDE alone turn nothing on; WDIE stays set where WDE is not; with it, the second time resets. */
#include "frame.h"
handler_6:
    lds r18, KEPT + 2
    inc r18
    sts KEPT + 2, r18
    reti
begin:
    in r18, MCUSR
    sbrc r18, 3            ; WDRF
    rjmp again
    set KEPT + 2, 0
    set WDTCSR, 0x18
    nop
    nop
    nop
    nop
    load_and_keep 0, WDTCSR
    set WDTCSR, 0x18
    set WDTCSR, 0x40       ; WDIE, 16 ms
    sei
1:  lds r18, KEPT + 2
    cpi r18, 3
    brne 1b
    load_and_keep 1, WDTCSR
    set WDTCSR, 0x18
    set WDTCSR, 0x48       ; WDIE and WDE
9:  rjmp 9b
again:                     ; after the reset, which is the second time
    keep 3, r18
    load_and_keep 4, WDTCSR
    ldi r18, 0
    out MCUSR, r18
    set WDTCSR, 0x18
    set WDTCSR, 0
    load_and_keep 5, WDTCSR
    end
