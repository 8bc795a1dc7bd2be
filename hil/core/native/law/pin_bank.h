/* A microcontroller's pins without a motor: inputs and outputs at exact times, and trains of pulses as its timers make
   them. What runs on the processor drives them over hil_bank_*. */
#ifndef HIL_LAW_PIN_BANK_H
#define HIL_LAW_PIN_BANK_H

#include "../law.h"

typedef struct pin_bank {
    outputs out;
    int32_t driven;                 /* pins that are outputs, a bit each */
    int32_t outside[HIL_BANK_PINS]; /* levels that come from outside */
    hil_pulses *rows;               /* of the latest train */
    int n_rows, row, pin;
    int64_t row_left;        /* pulses of the row that are to come */
    int64_t rise_ns, fall_ns; /* of the next pulse, and of the one that is high; HIL_FOREVER: none */
    int64_t sent, left;
} pin_bank;

extern const law pin_bank_law;

const pin_bank *pin_bank_view(const hil_axis *a); /* of another law: all zeros */
int pin_bank_levels(const pin_bank *b);

#endif
