/* The Mechaduino's law alone: control/mechaduino.c. */
#include "fixture.h"

typedef struct bare_law {
    mechaduino m;
    int16_t sine[MECHADUINO_SINE_LEN];
    float table[HIL_TABLE_LEN];
} bare_law;

static bare_law *fresh(void)
{
    static bare_law law;
    mechaduino_power_up(&law.m);
    mechaduino_sine(law.sine);
    identity_table(law.table);
    return &law;
}

static int tick(bare_law *law, int raw)
{
    float y;
    return mechaduino_step(&law->m, law->sine, law->table, raw, &y);
}

static void check_pins(const mechaduino *m, int vref1, int in1, int in2, int vref2, int in3, int in4)
{
    CHECK_INT(m->pins.vref1, vref1);
    CHECK_INT(m->pins.in1, in1);
    CHECK_INT(m->pins.in2, in2);
    CHECK_INT(m->pins.vref2, vref2);
    CHECK_INT(m->pins.in3, in3);
    CHECK_INT(m->pins.in4, in4);
}

static uint32_t bits(float x)
{
    uint32_t u;
    memcpy(&u, &x, sizeof u);
    return u;
}

static void power_up_values(void)
{
    mechaduino *m = &fresh()->m;
    CHECK(m->pKp == 15.0f && m->pKi == 0.2f && m->pKd == 250.0f && m->pLPF == 30.0f);
    CHECK(m->vKp == 0.001f && m->vKi == 0.001f && m->vKd == 0.0f && m->vLPF == 100.0f);
    CHECK(m->PA == 1.8f && m->uMAX == 115);
    CHECK(m->r == 0 && m->y == 0 && m->yw == 0 && m->ITerm == 0 && m->DTerm == 0 && m->v == 0 && m->u == 0);
    CHECK_INT(m->mode, 0);
    CHECK_INT(m->wrap_count, 0);
    check_pins(m, 37, 0, 1, 37, 0, 1);
}

static void filters_are_computed(void)
{
    mechaduino *m = &fresh()->m;
    for (int again = 0; again < 2; again++) {
        CHECK_INT(bits(m->pLPFa), 0x3f78aecb);
        CHECK_INT(bits(m->pLPFb), 0x3cea26a0);
        CHECK_INT(bits(m->vLPFa), 0x3f68698f);
        CHECK_INT(bits(m->vLPFb), 0x42c7a29a);
        mechaduino_set_pLPF(m, 10.0f);
        mechaduino_set_vLPF(m, 10.0f);
        CHECK_NEAR(m->pLPFa, exp(-2 * 3.14159 * 10 / 6500), 1e-7);
        CHECK_NEAR(m->pLPFb, 1 - m->pLPFa, 1e-9);
        CHECK(m->vLPFa == m->pLPFa);
        CHECK_NEAR(m->vLPFb, (1 - m->vLPFa) * 6500 / 6, 1e-4);
        mechaduino_set_pLPF(m, 30.0f);
        mechaduino_set_vLPF(m, 100.0f);
    }
}

static void sine_table(void)
{
    bare_law *law = fresh();
    CHECK_INT(law->sine[0], 0);
    CHECK_INT(law->sine[450], 724);
    CHECK_INT(law->sine[900], 1024);
    CHECK_INT(law->sine[1800], 0);
    CHECK_INT(law->sine[2700], -1024);
    CHECK_INT(law->sine[3600], 0);
}

static void commutation(void)
{
    bare_law *law = fresh();
    mechaduino_output(&law->m, law->sine, 0, 100);
    check_pins(&law->m, 0, 0, 1, 100, 0, 1);
    mechaduino_output(&law->m, law->sine, 90, 100); /* 12.5 electrical turns */
    check_pins(&law->m, 0, 0, 1, 100, 1, 0);
    mechaduino_output(&law->m, law->sine, 1.8f, 100);
    check_pins(&law->m, 100, 0, 1, 0, 0, 1);
    mechaduino_output(&law->m, law->sine, -1.8f, 115);
    check_pins(&law->m, 115, 1, 0, 0, 0, 1);
    mechaduino_output(&law->m, law->sine, -0.9f, 100); /* sine -724 and 724: truncated towards 0 */
    check_pins(&law->m, 70, 1, 0, 70, 0, 1);
    mechaduino_output(&law->m, law->sine, -0.9f, -100);
    check_pins(&law->m, 70, 0, 1, 70, 1, 0);
}

static void angles_saturate(void)
{
    bare_law *law = fresh();
    mechaduino_output(&law->m, law->sine, 1e30f, 100); /* INT32_MAX mod 3600 = 847: sine 1020 */
    check_pins(&law->m, 99, 0, 1, 99, 0, 1);
    mechaduino_output(&law->m, law->sine, -INFINITY, 100); /* INT32_MIN mod 3600 = 2752: sine -1020 */
    check_pins(&law->m, 99, 1, 0, 99, 1, 0);
    mechaduino_output(&law->m, law->sine, NAN, 100); /* as 0 */
    check_pins(&law->m, 0, 0, 1, 0, 0, 1);
}

static void position_steps(void)
{
    bare_law *law = fresh();
    mechaduino *m = &law->m;
    m->mode = 'x';
    m->r = 10;
    tick(law, 0); /* u = 15 * 10 + 0.2 * 10, limited */
    CHECK(m->e == 10 && m->ITerm == 2 && m->DTerm == 0 && m->u == 115 && m->y == 1.8f);
    CHECK_INT(m->U, 115);
    CHECK_INT(m->led, 0);
    check_pins(m, 115, 1, 0, 0, 0, 1); /* output(-1.8, 115) */
    tick(law, 455); /* 9.997559 deg: e = 0.00244, D = -0.02858288 * 250 * 9.997559 */
    CHECK_NEAR(m->yw, 9.99755859375, 0);
    CHECK_NEAR(m->e, 0.00244140625, 0);
    CHECK_NEAR(m->DTerm, -71.43973, 1e-4);
    CHECK_NEAR(m->u, 15 * 0.00244140625 + 2.00048828 - 71.43973, 1e-4);
    CHECK_INT(m->U, 69);
    CHECK_INT(m->led, 1);
    CHECK(m->y < 9.99755859375); /* pushed back: the phase advance is subtracted */
}

static void integral_is_limited(void)
{
    bare_law *law = fresh();
    law->m.mode = 'x';
    law->m.r = 1000;
    tick(law, 0);
    CHECK(law->m.ITerm == 150);
    law->m.r = -10000;
    tick(law, 0);
    CHECK(law->m.ITerm == -150);
    CHECK(law->m.u == -115);
}

static void velocity_step(void)
{
    bare_law *law = fresh();
    mechaduino *m = &law->m;
    m->mode = 'v';
    m->r = 60;
    tick(law, 100); /* 2.197265625 deg from 0: v = 99.81758 * 2.197265625 */
    CHECK_NEAR(m->v, 219.32574, 1e-3);
    CHECK_NEAR(m->e, 60 - 219.32574, 1e-3);
    CHECK_NEAR(m->ITerm, -0.15932574, 1e-6);
    CHECK_NEAR(m->u, -0.31865148, 1e-6);
    CHECK_INT(m->U, 0); /* below one count: no torque */
    CHECK_NEAR(m->y, 2.197265625 - 1.8, 1e-6);
}

static void torque_and_none(void)
{
    bare_law *law = fresh();
    mechaduino *m = &law->m;
    m->mode = 't';
    m->r = 50.7f;
    tick(law, 0);
    CHECK(m->u == 50.7f);
    CHECK_INT(m->U, 50);
    m->r = -200;
    tick(law, 0);
    CHECK(m->u == -115 && m->y == -1.8f);
    check_pins(m, 115, 0, 1, 0, 0, 1); /* output(1.8, 115) */
    m->mode = 0;
    tick(law, 0);
    check_pins(m, 0, 0, 1, 0, 0, 1);
}

static void hybrid_step(void)
{
    bare_law *law = fresh();
    mechaduino *m = &law->m;
    m->mode = 'h';
    tick(law, 100); /* 2.2 deg from 0: one step missed, output(0.1125, 69): sines 100 and 1019 */
    CHECK_INT(m->missed_steps, 1);
    check_pins(m, 6, 0, 1, 68, 0, 1);
    CHECK_INT(m->led, 0);
    CHECK(m->y_1 == 0); /* only the commutation of the other modes takes it along */
}

static void turns_are_counted(void)
{
    bare_law *law = fresh();
    law->m.mode = 't';
    tick(law, 16383); /* quirk: y_1 starts at 0 */
    CHECK_INT(law->m.wrap_count, -1);
    tick(law, 1);
    CHECK_INT(law->m.wrap_count, 0);
    CHECK_NEAR(law->m.yw, 360.0 / 16384, 0);
}

static void counters_wrap(void)
{
    bare_law *law = fresh();
    law->m.mode = 'h';
    law->m.r = -1e30f;
    law->m.wrap_count = INT32_MIN;
    law->m.missed_steps = INT32_MAX;
    tick(law, 12000);
    CHECK_INT(law->m.wrap_count, INT32_MAX);
    CHECK_INT(law->m.missed_steps, INT32_MIN);
}

static void step_response_every_fifth(void)
{
    bare_law *law = fresh();
    int due = 0;
    for (int i = 0; i < 20; i++) due += tick(law, 0);
    CHECK_INT(due, 0);
    law->m.print_yw = 1;
    for (int i = 1; i <= 20; i++) CHECK_INT(tick(law, 0), i % 5 == 0);
}

static void step_input(void)
{
    bare_law *law = fresh();
    mechaduino_step_pin(&law->m);
    CHECK(law->m.r == -0.05625f);
    mechaduino_dir_pin(&law->m, 0);
    mechaduino_step_pin(&law->m);
    mechaduino_step_pin(&law->m);
    CHECK(law->m.r == 0.05625f);
    mechaduino_dir_pin(&law->m, 1);
    mechaduino_step_pin(&law->m);
    CHECK(law->m.r == 0);
}

/* No number that a client can put in reaches undefined behaviour; the sanitizers watch. */
static void any_number_is_defined(void)
{
    static const double NUMBERS[] = {NAN, INFINITY, -INFINITY, 1e300, -1e300, 3e38, -3e38, 1e30, 4294967296.0,
                                     2147483648.0, -2147483648.0, -2147483649.0, 1e-45, -0.0, 0.5, 115};
    static const int MODES[] = {'x', 'v', 't', 'h', 0};
    static float table[HIL_TABLE_LEN];
    enum { N = sizeof NUMBERS / sizeof *NUMBERS };
    uint64_t seed = 1;
    identity_table(table);
    for (int mode = 0; mode < 5; mode++)
        for (int field = 0; field < HIL_FIELDS; field++) {
            if (!hil_field_table[field].writable || field == HIL_FIELD_mode) continue;
            for (int i = 0; i < N * N; i++) {
                hil_replay *p = hil_replay_new(table);
                hil_replay_row row;
                hil_replay_set(p, HIL_FIELD_mode, MODES[mode]);
                hil_replay_set(p, HIL_FIELD_r, NUMBERS[i / N]);
                hil_replay_set(p, (hil_field)field, NUMBERS[i % N]);
                for (int k = 0; k < 3; k++) hil_replay_step(p, (int)next_random(&seed), &row);
                hil_replay_output(p, (float)NUMBERS[i / N], INT32_MIN + i, &row);
                hil_replay_free(p);
            }
        }
}

void law_tests(void)
{
    RUN(power_up_values);
    RUN(filters_are_computed);
    RUN(sine_table);
    RUN(commutation);
    RUN(angles_saturate);
    RUN(position_steps);
    RUN(integral_is_limited);
    RUN(velocity_step);
    RUN(torque_and_none);
    RUN(hybrid_step);
    RUN(turns_are_counted);
    RUN(counters_wrap);
    RUN(step_response_every_fifth);
    RUN(step_input);
    RUN(any_number_is_defined);
}
