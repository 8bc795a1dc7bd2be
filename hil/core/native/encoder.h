/* The encoder's chip, an AS5047D: its registers over SPI, and a script that it may read from instead of the shaft. */
#ifndef HIL_ENCODER_H
#define HIL_ENCODER_H

#include <stdint.h>

/* Frames: a command's low 14 bits name a register; bit 15 is even parity, and bit 14 of an answer the error flag EF
   (data sheet, SPI). */
enum { SPI_ANGLE = 0x3FFF, SPI_DIAAGC = 0x3FFC, SPI_ERRFL = 0x0001, SPI_EF = 0x4000 };

typedef struct encoder {
    int32_t previous_command, diaagc, errfl;
    int script_len, script_linear;
    int64_t *script_ns, *script_raw;
} encoder;

/* The answer to the frame before, as the AS5047D's pipeline has it; the angle is that of now. While the error
   register holds anything every answer says so, the one that reads and clears it too. */
static inline int encoder_exchange(encoder *e, int command, int raw)
{
    int value = 0, error = e->errfl ? SPI_EF : 0;
    switch (e->previous_command & 0x3FFF) {
    case SPI_ANGLE: value = raw; break;
    case SPI_DIAAGC: value = e->diaagc; break;
    case SPI_ERRFL:
        value = e->errfl;
        e->errfl = 0;
        break;
    }
    e->previous_command = command;
    value |= error;
    return value | __builtin_parity((unsigned)value & 0x7FFF) << 15;
}

int encoder_script(encoder *e, int n, const int64_t *at_ns, const int64_t *raw, int is_linear); /* -1: no memory; n = 0: none */
int encoder_scripted_raw(const encoder *e, int64_t t_ns); /* with a script */

#endif
