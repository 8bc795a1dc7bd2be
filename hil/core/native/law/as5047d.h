/* A magnetic encoder, an AS5047D: a chip in front of a magnet on another axis's shaft, which is read over SPI. Its data
   sheet's sections are named as5047d.c; what that leaves open: device_profiles/as5047d/README.md */
#ifndef HIL_LAW_AS5047D_H
#define HIL_LAW_AS5047D_H

#include "../law.h"

enum { AS5047D_SETTINGS = 5 }; /* registers that can be written: PROG, ZPOSM, ZPOSL, SETTINGS1, SETTINGS2 */

typedef struct as5047d {
    outputs out;
    int32_t pins[HIL_SPI_INPUTS];
    int32_t has_magnet, shaft; /* shaft: where the axis is that turns the magnet, counted from this one */
    double sense, zero_rev;    /* sense: 1, or -1 where the chip sees the shaft from behind; zero: of the shaft, where it reads 0 */
    int32_t clocks;            /* since CSn fell */
    uint32_t heard, answer;    /* the frame that comes in, and the one that goes out */
    int32_t writes;            /* what the frame to come is written into, of settings; -1: it is a command */
    uint16_t settings[AS5047D_SETTINGS];
    int64_t frames;
} as5047d;

extern const law as5047d_law;

const as5047d *as5047d_view(const hil_axis *a); /* of another law: all zeros */

/* Puts a magnet in front of the chip: on the shaft of the axis so many places behind its own. */
void as5047d_place(hil_axis *a, int shaft, double sense, double zero_rev, int64_t now_ns);

#endif
