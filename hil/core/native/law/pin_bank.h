/* A microcontroller's pins without a motor: inputs and outputs at exact times, and trains of pulses as its timers make
   them. What runs on the processor drives them over hil_bank_*. */
#ifndef HIL_LAW_PIN_BANK_H
#define HIL_LAW_PIN_BANK_H

#include "bank_processor.h"

extern const law pin_bank_law;

const pin_bank *pin_bank_view(const hil_axis *a); /* of another law: all zeros */
int pin_bank_levels(const pin_bank *b);
int pin_bank_fault(hil_core *c, hil_axis *a, int what, double value, int64_t now_ns); /* as hil_axis_fault */
void pin_bank_plan(hil_axis *a); /* after its processor has come, gone, or been told something */

#endif
