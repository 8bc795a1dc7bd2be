/* What a processor tells the world, and asks of it. */
#ifndef HIL_AVR_WORLD_H
#define HIL_AVR_WORLD_H

#include "avr_state.h"

/* Called while it runs, at the cycle that is given, which is m->cycle then; may call avr_stop, avr_pin, avr_poke and avr_jump of its functions. NULL: need not know. */
typedef struct avr_world {
    void *self;
    void (*pin)(void *self, int pin, enum avr_drive drive, uint64_t cycle); /* what drives it has changed; asked for by avr_watch */
    void (*sent)(void *self, const avr_character *character); /* a frame begins at TX */
    double (*volts)(void *self, int channel, uint64_t cycle); /* at A0 to A7, where a conversion samples; NULL: those of avr_volts */
    void (*reset)(void *self, enum avr_cause cause, uint64_t cycle); /* it has reset itself */
    void (*note)(void *self, enum avr_note note, uint32_t value, uint64_t cycle);
    void (*means)(void *self, uint64_t cycle); /* mean levels of pins may be others from there on; asked for by avr_tell_means */
    int (*spm)(void *self, uint32_t page_byte, uint64_t cycle); /* a page of the flash was written by its program */
    void (*stored)(void *self, int address, uint64_t cycle); /* its program has begun to write a byte of the EEPROM, which is there at once */
} avr_world;

#endif
