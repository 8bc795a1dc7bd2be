/* Modes of the timers: DS40002061, tables Waveform Generation Mode Bit Description. */
#ifndef HIL_AVR_WAVEFORM_H
#define HIL_AVR_WAVEFORM_H

#include <stdint.h>

/* AVR_PLAIN: normal and CTC; FAST, PHASE (correct), FREQUENCY (and phase correct) are PWM: by when new compare values are taken. */
enum avr_shape { AVR_PLAIN, AVR_FAST, AVR_PHASE, AVR_FREQUENCY };

typedef struct avr_waveform {
    uint8_t shape, is_dual;
    uint16_t top;            /* 0: a register */
    uint8_t is_top_capture;  /* it is ICR1, else OCRA */
    uint8_t is_toggling;     /* COM 1 toggles OCA */
} avr_waveform;

static inline const avr_waveform *avr_waveform_of(int is_wide, int mode)
{
    static const avr_waveform narrow[8] = {
        {AVR_PLAIN, 0, 0xff, 0, 0}, {AVR_PHASE, 1, 0xff, 0, 0}, {AVR_PLAIN, 0, 0, 0, 0}, {AVR_FAST, 0, 0xff, 0, 0},
        {AVR_PLAIN, 0, 0xff, 0, 0}, {AVR_PHASE, 1, 0, 0, 1}, {AVR_PLAIN, 0, 0xff, 0, 0}, {AVR_FAST, 0, 0, 0, 1},
    };
    static const avr_waveform wide[16] = {
        {AVR_PLAIN, 0, 0xffff, 0, 0}, {AVR_PHASE, 1, 0xff, 0, 0}, {AVR_PHASE, 1, 0x1ff, 0, 0}, {AVR_PHASE, 1, 0x3ff, 0, 0},
        {AVR_PLAIN, 0, 0, 0, 0}, {AVR_FAST, 0, 0xff, 0, 0}, {AVR_FAST, 0, 0x1ff, 0, 0}, {AVR_FAST, 0, 0x3ff, 0, 0},
        {AVR_FREQUENCY, 1, 0, 1, 0}, {AVR_FREQUENCY, 1, 0, 0, 1}, {AVR_PHASE, 1, 0, 1, 0}, {AVR_PHASE, 1, 0, 0, 1},
        {AVR_PLAIN, 0, 0, 1, 0}, {AVR_PLAIN, 0, 0xffff, 0, 0}, {AVR_FAST, 0, 0, 1, 1}, {AVR_FAST, 0, 0, 0, 1},
    };
    return is_wide ? &wide[mode & 15] : &narrow[mode & 7];
}

#endif
