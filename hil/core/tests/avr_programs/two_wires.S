/* TWI as a master at 400 kHz: a start, an address that nobody has, a stop; or another that a slave has. */
#include "frame.h"
.macro done
1:  lds r18, TWCR
    sbrs r18, 7
    rjmp 1b
    lds r18, TWSR
.endm
begin:
    sbi PORTC, 4
    sbi PORTC, 5
    set TWBR, 12
    set TWCR, 0xa4         ; start
    load_and_keep 0, TWSR
    done
    keep 1, r18
    set TWDR, 0x42         ; 21h, to write
    set TWCR, 0x84
    done
    keep 2, r18
    sbrs r18, 3            ; 18h or 20h
    rjmp ended
    set TWDR, 0xc5
    set TWCR, 0x84
    done
    keep 3, r18
    set TWCR, 0xa4         ; again, to read
    done
    keep 4, r18
    set TWDR, 0x43
    set TWCR, 0x84
    done
    keep 5, r18
    set TWCR, 0xc4         ; a byte with ACK
    done
    keep 6, r18
    load_and_keep 7, TWDR
    set TWCR, 0x84         ; one without
    done
    keep 8, r18
    load_and_keep 9, TWDR
ended:
    set TWCR, 0x94         ; stop
1:  lds r18, TWCR
    sbrc r18, 4
    rjmp 1b
    end
