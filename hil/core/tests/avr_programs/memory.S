/* EEPROM: a write takes its time, reads are at once; EERIE after the write has begun. SPM from here does nothing. */
#include "frame.h"
handler_22:
    cbi EECR, 3
    inc r23
    reti
begin:
    ldi r18, 7
    out EEARL, r18
    ldi r18, 0x5a
    out EEDR, r18
    sbi EECR, 1            ; not armed: nothing
    in r19, EECR
    keep 0, r19
    sbi EECR, 2
    sbi EECR, 1
    in r19, EECR
    keep 1, r19
    sbi EECR, 3
    sei
    sbi PORTB, 5
    sbi DDRB, 5
1:  tst r23
    breq 1b
    cbi PORTB, 5
    sbi EECR, 0
    in r19, EEDR
    keep 2, r19
    keep 3, r23
    ; Erases of pages count from the boot section alone.
    cli
    ldi r30, 0
    ldi r31, 0x10
    ldi r18, 0x03
    out SPMCSR, r18
    spm
    ldi r30, 0
    ldi r31, 0
    lpm r19, Z
    keep 4, r19
    ; The signature, and a fuse.
    ldi r30, 0
    ldi r18, 0x21
    out SPMCSR, r18
    lpm r19, Z
    keep 5, r19
    ldi r30, 3
    ldi r18, 0x09
    out SPMCSR, r18
    lpm r19, Z
    keep 6, r19
    end
