/* Mean levels of the pins of a bank, and RC low-passes at them: what a program makes of a PWM pin, an RC filter and an analogue input. */
#ifndef HIL_LAW_SMOOTHED_PIN_H
#define HIL_LAW_SMOOTHED_PIN_H

#include "bank_state.h"

double smoothed_mean_V(const pin_bank *b, int pin); /* of its PWM, or by its level */
int smoothed_add(pin_bank *b, int pin, double rc_s, int64_t now_ns); /* its number, also of one that is there; -1: there are too many */
void smoothed_look(pin_bank *b, int64_t at_ns); /* mean levels may be others from there on */
double smoothed_V(hil_core *c, int axis, hil_field number, int64_t at_ns); /* output of a filter of an axis; as analog_input.field */

#endif
