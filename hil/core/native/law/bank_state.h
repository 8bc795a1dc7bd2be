/* What a bank of pins holds, and its processor: data alone. */
#ifndef HIL_LAW_BANK_STATE_H
#define HIL_LAW_BANK_STATE_H

#include "../law.h"
#include "../mcu/avr/atmega328p.h"

enum { MOST_SMOOTHED = 16 }; /* filters at its pins */
enum { MOST_WAITING = 512 }; /* characters: some packets of a line, which are told as a whole when they begin */

/* A voltage at an analogue pin: volts, or where a field is named that of another axis, times gain, and volts. */
typedef struct analog_input {
    int axis;
    hil_field number;
    double gain, volts;
    double (*field)(hil_core *c, int axis, hil_field number, int64_t at_ns);
} analog_input;

/* An RC low-pass at a pin. Its input is the pin's mean level in volts, which stays until something changes it: so its output is
   exact at any time. The piece before the present one is kept for who looks a little back. */
typedef struct smoothed_pin {
    int pin;
    double rc_s;
    double to_V, from_V;               /* input, and output at from_ns */
    int64_t from_ns;
    double before_to_V, before_from_V; /* the same of the piece before */
    int64_t before_ns;
} smoothed_pin;

typedef struct bank_processor {
    avr chip;
    int32_t is_running; /* it drives the pins; if not, its board's firmware does, and it stands still */
    int32_t has_boot;   /* a boot loader that is not in its flash goes before the program, after each reset */
    int32_t driver_pin; /* it enables the driver of a line that it sends on; -1: none does */
    int32_t stuck, stuck_high; /* pins that are stuck, and how, a bit each */
    double nominal_hz, clock_error_pct;
    double vcc_V, aref_V;
    int64_t hz;         /* cycle k is at zero_ns + floor((k - zero_cycle) * 1e9 / hz) */
    int64_t zero_ns;
    uint64_t zero_cycle;
    analog_input analog[AVR_CHANNELS];
    avr_character waiting[MOST_WAITING]; /* of its line, that the chip has no room for yet */
    int32_t first_waiting, n_waiting;
} bank_processor;

typedef struct pin_bank {
    outputs out;
    int32_t driven;                 /* pins that are outputs, a bit each */
    int32_t outside[HIL_BANK_PINS]; /* levels that come from outside */
    hil_pulses *rows;               /* of the latest train */
    int n_rows, row, pin;
    int64_t row_left;        /* pulses of the row that are to come */
    int64_t rise_ns, fall_ns; /* of the next pulse, and of the one that is high; HIL_FOREVER: none */
    int64_t sent, left;
    bank_processor processor;
    smoothed_pin smoothed[MOST_SMOOTHED];
    int32_t n_smoothed;
} pin_bank;

#endif
