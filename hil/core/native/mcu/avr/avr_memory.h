/* EEPROM, and flash as the program sees it: its reading, SPM, signature and fuses.
   DS40002061, EEPROM Data Memory, Self-Programming, Memory Programming. */
#ifndef HIL_AVR_MEMORY_H
#define HIL_AVR_MEMORY_H

#include "avr_state.h"

/* Word at which the boot section begins, by the fuses. */
unsigned avr_eeprom_address(const avr *m); /* that EEAR has */
unsigned avr_boot_start(const avr *m);

uint8_t avr_flash_byte(avr *m, unsigned z, uint64_t at); /* LPM */
void avr_spm(avr *m, unsigned pc, uint64_t at);          /* SPM at a word, at its end */
void avr_spm_event(avr *m, uint64_t at);
void avr_spm_store(avr *m, uint8_t value, uint64_t at);  /* SPMCSR */

void avr_eeprom_store(avr *m, uint8_t value, uint64_t at); /* EECR */
void avr_eeprom_event(avr *m, uint64_t at);

#endif
