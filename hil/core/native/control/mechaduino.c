#include "mechaduino.h"

#include <math.h>
#include <string.h>

static const float Fs = 6500.0f;

/* The M0+'s float-to-int: truncates, saturates, and makes 0 of a NaN; C leaves the last two undefined. */
static int32_t to_int(float x)
{
    if (x != x) return 0;
    if (x >= 2147483648.0f) return INT32_MAX;
    if (x <= -2147483648.0f) return INT32_MIN;
    return (int32_t)x;
}

/* Sums and products wrap on the M0+; C leaves signed overflow undefined. (h mode counts wrap_count and
   missed_steps at every control step: past 2^31 in four days.) */
static int32_t wrapping_add(int32_t x, int32_t y) { return (int32_t)((uint32_t)x + (uint32_t)y); }
static int32_t wrapping_mul(int32_t x, int32_t y) { return (int32_t)((uint32_t)x * (uint32_t)y); }

static int32_t modulo(int32_t x, int32_t m)
{
    int32_t k = x % m;
    return k < 0 ? k + m : k;
}

void mechaduino_sine(int16_t sine[MECHADUINO_SINE_LEN])
{
    for (int a = 0; a < MECHADUINO_SINE_LEN; a++)
        sine[a] = (int16_t)lround(1024 * sin(a * 3.1415 / 1800));
}

void mechaduino_set_spr(mechaduino *m, int32_t spr)
{
    m->phase = (float)(10 * spr / 4);
    m->aps = (float)(360.0 / spr);
    m->stepangle = (float)(m->aps / 32.0);
}

void mechaduino_set_pLPF(mechaduino *m, float hz)
{
    m->pLPF = hz;
    m->pLPFa = (float)exp(-2 * 3.14159 * hz / Fs);
    m->pLPFb = (float)(1.0 - m->pLPFa);
}

void mechaduino_set_vLPF(mechaduino *m, float hz)
{
    m->vLPF = hz;
    m->vLPFa = (float)exp(-2 * 3.14159 * hz / Fs);
    m->vLPFb = (float)((1.0 - m->vLPFa) * Fs * 0.16666667);
}

void mechaduino_power_up(mechaduino *m)
{
    memset(m, 0, sizeof *m);
    m->pKp = 15.0f;
    m->pKi = 0.2f;
    m->pKd = 250.0f;
    mechaduino_set_pLPF(m, 30.0f);
    m->vKp = 0.001f;
    m->vKi = 0.001f;
    m->vKd = 0.0f;
    mechaduino_set_vLPF(m, 100.0f);
    mechaduino_set_spr(m, 200);
    m->PA = m->aps;
    m->uMAX = 115;
    m->pins.vref1 = m->pins.vref2 = 37; /* (int)(0.33 uMAX) */
    m->pins.in2 = m->pins.in4 = 1;
}

void mechaduino_output(mechaduino *m, const int16_t *sine, float theta_deg, int32_t effort)
{
    int32_t a = wrapping_mul(effort, sine[modulo(to_int(m->phase * theta_deg), 3600)]) / 1024;
    int32_t b = wrapping_mul(effort, sine[modulo(to_int(m->phase * theta_deg + 900.0f), 3600)]) / 1024;
    mechaduino_drive(m, a, b);
}

void mechaduino_step_pin(mechaduino *m)
{
    if (m->dir)
        m->r += m->stepangle;
    else
        m->r -= m->stepangle;
}

void mechaduino_dir_pin(mechaduino *m, int level) { m->dir = !level; }

static void position_control(mechaduino *m)
{
    m->e = m->r - m->yw;
    m->ITerm += m->pKi * m->e;
    if (m->ITerm > 150.0f)
        m->ITerm = 150.0f;
    else if (m->ITerm < -150.0f)
        m->ITerm = -150.0f;
    m->DTerm = m->pLPFa * m->DTerm - m->pLPFb * m->pKd * (m->yw - m->yw_1);
    m->u = m->pKp * m->e + m->ITerm + m->DTerm;
}

static void velocity_control(mechaduino *m)
{
    m->v = m->vLPFa * m->v + m->vLPFb * (m->yw - m->yw_1);
    m->e = m->r - m->v;
    m->ITerm += m->vKi * m->e;
    if (m->ITerm > 200.0f)
        m->ITerm = 200.0f;
    else if (m->ITerm < -200.0f)
        m->ITerm = -200.0f;
    m->u = m->vKp * m->e + m->ITerm - m->vKd * (m->e - m->e_1);
}

static void hybrid_control(mechaduino *m, const int16_t *sine)
{
    if (m->yw < m->r - m->aps)
        m->missed_steps = wrapping_add(m->missed_steps, -1);
    else if (m->yw > m->r + m->aps)
        m->missed_steps = wrapping_add(m->missed_steps, 1);
    /* 69 counts: 255/3.3 * (0.6 A * 10 * 0.15 ohm) */
    mechaduino_output(m, sine, (float)(0.1125 * -(m->r - (float)m->missed_steps)), 69);
}

static void commutate(mechaduino *m, const int16_t *sine)
{
    m->y_1 = m->y;
    if (m->u > 0) {
        m->y += m->PA;
        if (m->u > (float)m->uMAX) m->u = (float)m->uMAX;
    } else {
        m->y -= m->PA;
        if (m->u < -(float)m->uMAX) m->u = -(float)m->uMAX;
    }
    m->U = to_int(fabsf(m->u));
    m->led = fabsf(m->e) < 0.1;
    mechaduino_output(m, sine, -m->y, m->U);
}

static inline void measure(mechaduino *m, float y)
{
    m->y = y;
    float d = m->y - m->y_1;
    if (d < -180.0f)
        m->wrap_count = wrapping_add(m->wrap_count, 1);
    else if (d > 180.0f)
        m->wrap_count = wrapping_add(m->wrap_count, -1);
    m->yw = (float)(m->y + 360.0 * m->wrap_count);
}

void mechaduino_measure(mechaduino *m, const float *table, int raw)
{
    m->yw_1 = m->yw;
    measure(m, table[raw]);
    m->y_1 = m->y;
}

int mechaduino_step(mechaduino *m, const int16_t *sine, const float *table, int raw, float *y_measured)
{
    measure(m, *y_measured = table[raw]);

    switch (m->mode) {
    case 'h':
        hybrid_control(m, sine);
        break;
    case 'x':
        position_control(m);
        commutate(m, sine);
        break;
    case 'v':
        velocity_control(m);
        commutate(m, sine);
        break;
    case 't':
        m->u = m->r;
        commutate(m, sine);
        break;
    default:
        m->u = 0;
        commutate(m, sine);
    }
    m->e_1 = m->e;
    m->yw_1 = m->yw;

    if (!m->print_yw || ++m->print_counter < 5) return 0;
    m->print_counter = 0;
    return 1;
}
