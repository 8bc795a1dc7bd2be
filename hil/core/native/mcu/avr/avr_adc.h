/* The analogue-to-digital converter and the comparator: DS40002061, Analog-to-Digital Converter, Analog Comparator.

   The reference's settling on AREF's capacitor is not there. */
#ifndef HIL_AVR_ADC_H
#define HIL_AVR_ADC_H

#include "avr_state.h"

/* The channel A0 to A7 that a conversion samples at the event of a clock; -1: none. */
int avr_adc_samples(const avr *m);

void avr_adc_event(avr *m, uint64_t at);
void avr_adc_trigger(avr *m, uint16_t timer_flags, int is_external, int is_comparator, uint64_t at); /* what has risen */
void avr_adc_sleeps(avr *m, uint64_t at); /* idle, or in noise reduction mode: a conversion begins */
uint8_t avr_adc_load(avr *m, unsigned address);
void avr_adc_store(avr *m, unsigned address, uint8_t value, uint64_t at);
void avr_adc_shift(avr *m, uint64_t clocks);

/* Compares AIN0 (D6) or the bandgap with AIN1 (D7) or a channel, where levels or voltages have changed. */
void avr_comparator_look(avr *m, uint64_t at);
void avr_comparator_use(avr *m, uint64_t at); /* likewise where the program looks, or changes what is compared */
int avr_comparator_channel(const avr *m);     /* A0 to A7; -1: AIN1 */
void avr_comparator_event(avr *m, int may_change, uint64_t at); /* of its part; may_change: the channel's voltage, at any time */

#endif
