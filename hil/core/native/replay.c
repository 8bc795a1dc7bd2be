/* The Mechaduino's law alone, fed from arrays. */
#include <stdlib.h>
#include <string.h>

#include "hil_core.h"
#include "law/servo.h"

struct hil_replay {
    mechaduino law;
    int16_t sine[MECHADUINO_SINE_LEN];
    float table[HIL_TABLE_LEN];
};

hil_replay *hil_replay_new(const float *table)
{
    hil_replay *p = calloc(1, sizeof *p);
    if (!p) return NULL;
    mechaduino_sine(p->sine);
    mechaduino_power_up(&p->law);
    memcpy(p->table, table, sizeof p->table);
    return p;
}

int hil_replay_set(hil_replay *p, hil_field field, double value) { return servo_set(&p->law, field, value); }

static void fill_row(const hil_replay *p, float y, hil_replay_row *row)
{
    const mechaduino *m = &p->law;
    const mechaduino_pins *n = &m->pins;
    *row = (hil_replay_row){.y_meas = y, .y_excite = m->y, .yw = m->yw, .e = m->e, .ITerm = m->ITerm, .DTerm = m->DTerm,
                            .v = m->v, .u = m->u, .U = m->U, .wrap_count = m->wrap_count,
                            .vref1 = (int16_t)n->vref1, .vref2 = (int16_t)n->vref2, .in1 = (int8_t)n->in1,
                            .in2 = (int8_t)n->in2, .in3 = (int8_t)n->in3, .in4 = (int8_t)n->in4,
                            .led = (int8_t)m->led};
}

void hil_replay_step(hil_replay *p, int raw, hil_replay_row *row)
{
    float y;
    mechaduino_step(&p->law, p->sine, p->table, raw & 16383, &y);
    fill_row(p, y, row);
}

void hil_replay_output(hil_replay *p, float theta_deg, int effort, hil_replay_row *row)
{
    mechaduino_output(&p->law, p->sine, theta_deg, effort);
    fill_row(p, 0, row);
}

void hil_replay_free(hil_replay *p) { free(p); }
