/* What moves axes of a kind together, in rows of REAL_LANES. Included by batch_any.c, batch_avx2.c and batch_avx512.c: the
   same operations, for any processor and for those with wide vectors. Those define REAL_LANES, TARGET, SIMPLE_BATCH and
   FULL_BATCH. */
#include "lanes.h"
#include "plant/real.h"
#include "plant/speed_kernel.h"
#include "plant/trig_kernel.h"
#include "plant/simple_kernel.h"
#include "plant/full_kernel.h"
#include "control/mechaduino_xn.h"
#include "law/servo.h"

/* What is the same of both plants in a row of lanes. */
typedef struct row {
    servo *servo[LANES];
    int seated; /* lanes beyond are empty */
    law_xn laws;
    int lawful; /* laws holds the laws: all are in mode x, and nothing odd has come yet */
    int stepped; /* once at least */
    mask_xn next_ns, phase; /* of the next control step; its number modulo LONGER_EVERY */
    real_xn amps_per_count, a_A, b_A;
} row;

/* Structs of one axis's numbers, and of LANES axes': the same members in the same order. */
INLINE void put_lane(void *to, const void *from, size_t size, int i)
{
    for (size_t k = 0; k < size / sizeof(double); k++) ((double *)to)[k * LANES + i] = ((const double *)from)[k];
}

INLINE void take_lane(void *to, const void *from, size_t size, int i)
{
    for (size_t k = 0; k < size / sizeof(double); k++) ((double *)to)[k] = ((const double *)from)[k * LANES + i];
}

#define PUT(to, from, i) put_lane(&(to), &(from), sizeof(from), i)
#define TAKE(to, from, i) take_lane(&(to), &(from), sizeof(to), i)

typedef struct simple_lanes {
    plant_motor_xn motor;
    plant_rate_xn part[2];
    plant_moving_xn moving;
    row row;
} simple_lanes;

typedef struct full_lanes {
    full_motor_xn motor;
    full_rate_xn whole, part[2];
    full_moving_xn moving;
    real_xn load_Nm, noise_counts;
    mask_xn noise_key;
    row row;
} full_lanes;

/* Has the place of the table brought from memory where the encoder will be in a control step's time. */
INLINE void fetch_ahead(const row *r, real_xn count, real_xn rev_per_s)
{
    real_xn ahead = count + rev_per_s * (STEP_NS * 1e-9 * HIL_TABLE_LEN);
    ahead = PICK(MAGNITUDE(ahead) < 1e6, ahead, count);
    for (int i = 0; i < LANES; i++) __builtin_prefetch(&r->servo[i]->table[(int)ahead[i] & (HIL_TABLE_LEN - 1)]);
}

/* The laws' step at their next control step's time. */
INLINE void control(hil_core *c, row *r, mask_xn raw)
{
    law_f y;
    for (int i = 0; i < LANES; i++) y[i] = r->servo[i]->table[raw[i]];
    if (r->lawful && !law_xn_step(&r->laws, c->sine, y)) {
        if (r->stepped)
            for (int i = 0; i < r->seated; i++) law_xn_put(&r->laws, &r->servo[i]->law, i);
        r->lawful = 0;
    }
    r->stepped = 1;
    if (r->lawful) {
        r->a_A = __builtin_convertvector(r->laws.a, real_xn) * r->amps_per_count;
        r->b_A = __builtin_convertvector(r->laws.b, real_xn) * r->amps_per_count;
    }
    for (int i = 0; i < r->seated && !r->lawful; i++) {
        servo *s = r->servo[i];
        float measured;
        double a_A, b_A;
        mechaduino_step(&s->law, c->sine, s->table, (int)raw[i], &measured);
        servo_currents(s, &a_A, &b_A);
        r->a_A[i] = a_A;
        r->b_A[i] = b_A;
    }
    r->phase += 1;
    r->phase &= (mask_xn)(r->phase != LONGER_EVERY);
    r->next_ns += STEP_NS + ((mask_xn)(r->phase == 0) & 1);
}

INLINE void simple_step(simple_lanes *l)
{
    fetch_ahead(&l->row, (l->moving.rev - floor_of_xn(l->moving.rev)) * 16384.0, l->moving.rev_per_s);
    mask_xn odd = (mask_xn)(l->row.phase == 0);
    plant_rate_xn rate;
#define CHOOSE(member) rate.member = PICK(odd, l->part[1].member, l->part[0].member)
    CHOOSE(kick_s);
    CHOOSE(middle_kick_s);
    CHOOSE(gradient_s2);
    CHOOSE(reach_s);
    CHOOSE(keep);
#undef CHOOSE
    plant_step_xn(&l->motor, &rate, &l->moving, l->row.a_A, l->row.b_A);
}

INLINE void simple_control(hil_core *c, simple_lanes *l)
{
    real_xn count = (l->moving.rev - floor_of_xn(l->moving.rev)) * 16384.0;
    control(c, &l->row, BITS(floor_of_xn(count) + NEAREST) & 16383);
}

INLINE void simple_run(hil_core *c, simple_lanes *l, int rows, int64_t n)
{
    for (; n > 0; n--) {
        for (int i = 0; i < rows; i++) simple_step(&l[i]);
        for (int i = 0; i < rows; i++) simple_control(c, &l[i]);
    }
}

INLINE void full_last_step(full_lanes *l)
{
    mask_xn odd = (mask_xn)(l->row.phase == 0);
    full_rate_xn rate;
#define CHOOSE(member) rate.member = PICK(odd, l->part[1].member, l->part[0].member)
    CHOOSE(h_s);
    CHOOSE(half_s);
    CHOOSE(slow);
    CHOOSE(push);
    CHOOSE(dry);
    CHOOSE(henry_per_s);
    CHOOSE(fade);
    CHOOSE(feed);
#undef CHOOSE
    full_step_xn(&l->motor, &rate, &l->moving, l->row.a_A, l->row.b_A, l->load_Nm);
    full_locate_xn(&l->moving);
}

INLINE void full_control(hil_core *c, full_lanes *l)
{
    real_xn noise = full_noise_xn(l->noise_key, l->noise_counts, l->row.next_ns);
    control(c, &l->row, full_rounded_xn(full_count_xn(&l->motor, &l->moving) + noise));
}

INLINE void full_run(hil_core *c, full_lanes *l, int rows, int64_t n)
{
    for (; n > 0; n--) {
        for (int i = 0; i < rows; i++) {
            fetch_ahead(&l[i].row, full_count_xn(&l[i].motor, &l[i].moving), l[i].moving.state.rev_per_s);
            full_open_xn(&l[i].motor, &l[i].moving);
        }
        for (int k = 1; k < FULL_WINDOW; k++)
            for (int i = 0; i < rows; i++)
                full_step_xn(&l[i].motor, &l[i].whole, &l[i].moving, l[i].row.a_A, l[i].row.b_A, l[i].load_Nm);
        for (int i = 0; i < rows; i++) full_last_step(&l[i]);
        for (int i = 0; i < rows; i++) full_control(c, &l[i]);
    }
}

INLINE void sit(row *r, hil_axis *a, int empty, double a_A, double b_A, int i)
{
    servo *s = a->own;
    if (i == 0) r->seated = 0;
    r->seated += !empty;
    r->servo[i] = s;
    r->next_ns[i] = (uint64_t)a->law_next_ns;
    r->phase[i] = (uint64_t)((s->loop_steps + 1) % LONGER_EVERY);
    r->amps_per_count[i] = s->amps_per_count;
    r->a_A[i] = a_A;
    r->b_A[i] = b_A;
    r->stepped = 0;
    r->lawful = (i == 0 || r->lawful) && s->law.mode == 'x';
    law_xn_get(&r->laws, &s->law, i);
}

/* Answers the time of the latest of n control steps. */
INLINE int64_t stand(const row *r, hil_axis *a, int64_t n, int i)
{
    servo *s = r->servo[i];
    if (r->lawful) law_xn_put(&r->laws, &s->law, i);
    s->control_steps += n;
    s->loop_steps += n;
    a->law_next_ns = (int64_t)r->next_ns[i];
    return a->law_next_ns - STEP_NS - (r->phase[i] == 0);
}

/* Seats of the rows that so many take. */
INLINE int in_rows(int seated) { return seated > LANES ? ROWS * LANES : LANES; }

TARGET void SIMPLE_BATCH(hil_core *c, const lane *lanes, int seated, int64_t n)
{
    simple_lanes rows[ROWS];
    for (int k = 0; k < in_rows(seated); k++) {
        simple_lanes *l = &rows[k / LANES];
        int i = k % LANES;
        hil_axis *a = lanes[k < seated ? k : 0].axis;
        plant *p = &a->plant;
        for (int h_ns = STEP_NS; h_ns < STEP_NS + 2; h_ns++) PUT(l->part[h_ns & 1], *plant_part(p, h_ns), i);
        PUT(l->motor, p->motor, i);
        PUT(l->moving, p->moving, i);
        sit(&l->row, a, k >= seated, p->current_a_A, p->current_b_A, i);
    }
    if (seated > LANES) simple_run(c, rows, ROWS, n);
    else simple_run(c, rows, 1, n);
    for (int k = 0; k < seated; k++) {
        simple_lanes *l = &rows[k / LANES];
        int i = k % LANES;
        plant *p = &lanes[k].axis->plant;
        p->node_ns = stand(&l->row, lanes[k].axis, n, i);
        TAKE(p->moving, l->moving, i);
        plant_set_currents(p, l->row.a_A[i], l->row.b_A[i]);
    }
}

TARGET void FULL_BATCH(hil_core *c, const lane *lanes, int seated, int64_t n)
{
    full_lanes rows[ROWS];
    for (int k = 0; k < in_rows(seated); k++) {
        full_lanes *l = &rows[k / LANES];
        int i = k % LANES;
        hil_axis *a = lanes[k < seated ? k : 0].axis;
        full *p = &a->full;
        for (int h_ns = STEP_NS; h_ns < STEP_NS + 2; h_ns++)
            PUT(l->part[h_ns & 1], *full_part(p, h_ns - (FULL_WINDOW - 1) * FULL_STEP_NS), i);
        PUT(l->motor, p->motor, i);
        PUT(l->whole, p->whole, i);
        PUT(l->moving, p->moving, i);
        l->load_Nm[i] = p->steady_Nm;
        l->noise_counts[i] = p->noise_counts;
        l->noise_key[i] = p->noise_key;
        sit(&l->row, a, k >= seated, p->command_a_A, p->command_b_A, i);
    }
    if (seated > LANES) full_run(c, rows, ROWS, n);
    else full_run(c, rows, 1, n);
    for (int k = 0; k < seated; k++) {
        full_lanes *l = &rows[k / LANES];
        int i = k % LANES;
        full *p = &lanes[k].axis->full;
        p->node_ns = stand(&l->row, lanes[k].axis, n, i);
        TAKE(p->moving, l->moving, i);
        full_set_currents(p, l->row.a_A[i], l->row.b_A[i]);
    }
}
