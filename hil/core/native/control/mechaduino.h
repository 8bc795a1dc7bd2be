/* The control law of Mechaduino firmware 0.1.5, in the float32 arithmetic of its Cortex-M0+.
   Names are the firmware's own. Pure: no time, no plant. */
#ifndef HIL_CONTROL_MECHADUINO_H
#define HIL_CONTROL_MECHADUINO_H

#include <stdint.h>

#define MECHADUINO_SINE_LEN 3601
/* One control step every 7385 cycles of 48 MHz: round(48e6 / 6500). */
#define MECHADUINO_STEP_NUM_NS 7385000
#define MECHADUINO_STEP_DEN 48

typedef struct mechaduino_pins {
    int32_t vref1, vref2; /* counts, 0 to 255 */
    int32_t in1, in2, in3, in4;
} mechaduino_pins;

typedef struct mechaduino {
    float r, y, y_1, yw, yw_1, e, e_1, ITerm, DTerm, v, u;
    int32_t U, wrap_count, missed_steps, mode, led;
    float pKp, pKi, pKd, pLPF, pLPFa, pLPFb;
    float vKp, vKi, vKd, vLPF, vLPFa, vLPFb;
    float PA;
    int32_t uMAX;
    int32_t print_yw, print_counter;
    int32_t dir; /* 1: a step at the input is towards larger counts, a step by letter towards smaller ones */
    /* Of the motor that it was compiled for: counts of the sine a degree, degrees of a full step and of a pulse. */
    float phase, aps, stepangle;
    mechaduino_pins pins;
} mechaduino;

/* The firmware's built-in table: round(1024 sin(a 3.1415 / 1800)), a = 0 to 3600. */
void mechaduino_sine(int16_t sine[MECHADUINO_SINE_LEN]);
/* RAM as after power-up, and the pins as setup() leaves them. */
void mechaduino_power_up(mechaduino *m);
/* As if it were compiled for a motor of so many steps a turn, 1 to 1000. At power-up: 200. */
void mechaduino_set_spr(mechaduino *m, int32_t spr);
void mechaduino_set_pLPF(mechaduino *m, float hz);
void mechaduino_set_vLPF(mechaduino *m, float hz);
/* The pins for coil currents in counts. */
static inline void mechaduino_drive(mechaduino *m, int32_t a, int32_t b)
{
    m->pins.vref1 = a < 0 ? -a : a;
    m->pins.in2 = a >= 0;
    m->pins.in1 = a < 0;
    m->pins.vref2 = b < 0 ? -b : b;
    m->pins.in4 = b >= 0;
    m->pins.in3 = b < 0;
}
void mechaduino_output(mechaduino *m, const int16_t *sine, float theta_deg, int32_t effort);
/* One control interrupt. Returns 1 when the step response print is due. y_measured: the calibrated angle. */
int mechaduino_step(mechaduino *m, const int16_t *sine, const float *table, int raw, float *y_measured);
/* The first part of it alone, for a controller of one's own: y, yw and wrap_count; yw_1 is yw as it was before. */
void mechaduino_measure(mechaduino *m, const float *table, int raw);
/* Interrupts of the step and dir inputs: a rising edge, and an edge to a level. */
void mechaduino_step_pin(mechaduino *m);
void mechaduino_dir_pin(mechaduino *m, int level);

#endif
