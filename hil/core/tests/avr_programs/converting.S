/* ADC: started by sleep in noise reduction; then free running, D4 changes in each. ADLAR, and the lock of ADCL. */
#include "frame.h"
handler_21:
    sbi PIND, 4
    reti
begin:
    sbi DDRD, 4
    set ADMUX, 0x40
    set ADCSRA, 0x8b       ; on, its interrupt, 8 clocks each
    set SMCR, 3
    sei
    sleep
    cli
    load_and_keep 0, ADCL
    load_and_keep 1, ADCH
    set ADMUX, 0x60
    load_and_keep 2, ADCL
    load_and_keep 3, ADCH
    set ADMUX, 0x41
    set ADCSRB, 0
    sei
    set ADCSRA, 0xeb
9:  rjmp 9b
