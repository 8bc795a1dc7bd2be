/* The Mechaduino's position loop for LANES boards at a time: mechaduino_step in mode x, with the same float32
   operations in the same order, so the same bits. tests/batch.c compares the two. Included after plant/real.h. */
#ifndef HIL_CONTROL_MECHADUINO_XN_H
#define HIL_CONTROL_MECHADUINO_XN_H

#include "mechaduino.h"

typedef float law_f __attribute__((vector_size(4 * LANES), may_alias));
typedef int32_t law_i __attribute__((vector_size(4 * LANES), may_alias));
typedef uint32_t law_u __attribute__((vector_size(4 * LANES), may_alias));
typedef double law_d __attribute__((vector_size(8 * LANES), may_alias));
typedef int64_t law_l __attribute__((vector_size(8 * LANES), may_alias));

#define LAW_PICK(mask, yes, no) ((law_f)(((law_i)(yes) & (mask)) | ((law_i)(no) & ~(mask))))
#define LAW_ALL(x) ((law_f){0} + (x))
#define LAW_INLINE static inline __attribute__((always_inline))

typedef struct law_xn {
    law_f r, y_1, yw_1, ITerm, DTerm, pKp, pKi, pKd, pLPFa, pLPFb, PA, most_u, phase;
    law_i wrap_count;
    law_f y, yw, e, u; /* results */
    law_i U, led, a, b; /* a, b: counts of the coils, signed */
} law_xn;

LAW_INLINE void law_xn_get(law_xn *l, const mechaduino *m, int i)
{
    l->r[i] = m->r;
    l->y_1[i] = m->y_1;
    l->yw_1[i] = m->yw_1;
    l->ITerm[i] = m->ITerm;
    l->DTerm[i] = m->DTerm;
    l->pKp[i] = m->pKp;
    l->pKi[i] = m->pKi;
    l->pKd[i] = m->pKd;
    l->pLPFa[i] = m->pLPFa;
    l->pLPFb[i] = m->pLPFb;
    l->PA[i] = m->PA;
    l->most_u[i] = (float)m->uMAX;
    l->phase[i] = m->phase;
    l->wrap_count[i] = m->wrap_count;
}

/* After at least one step. */
LAW_INLINE void law_xn_put(const law_xn *l, mechaduino *m, int i)
{
    m->y = l->y[i];
    m->y_1 = l->y_1[i];
    m->yw = m->yw_1 = l->yw[i];
    m->e = m->e_1 = l->e[i];
    m->ITerm = l->ITerm[i];
    m->DTerm = l->DTerm[i];
    m->u = l->u[i];
    m->U = l->U[i];
    m->led = l->led[i];
    m->wrap_count = l->wrap_count[i];
    mechaduino_drive(m, l->a[i], l->b[i]);
}

LAW_INLINE law_i law_mod_3600(law_i x)
{
    law_i k = x - __builtin_convertvector(__builtin_convertvector(x, law_d) * (1.0 / 3600), law_i) * 3600;
    k += (k < 0) & 3600;
    return k - ((k >= 3600) & 3600);
}

/* effort * sine / 1024, rounded towards 0. */
LAW_INLINE law_i law_coil(law_i effort, const int16_t *sine, law_i angle)
{
    law_i at = law_mod_3600(angle), product;
    for (int i = 0; i < LANES; i++) product[i] = sine[at[i]];
    product = (law_i)((law_u)product * (law_u)effort);
    return (product + ((product >> 31) & 1023)) >> 10;
}

/* One control step; y: the calibrated angles. 0: some number does not fit the short ways taken here (a NaN, 2^30);
   then nothing has been done. */
LAW_INLINE int law_xn_step(law_xn *l, const int16_t *sine, law_f y)
{
    law_f d = y - l->y_1;
    law_i down = d < -180.0f, up = (d > 180.0f) & ~down;
    law_i wraps = (law_i)((law_u)l->wrap_count - (law_u)down + (law_u)up);
    law_d turned = 360.0 * __builtin_convertvector(wraps, law_d);
    law_f yw = __builtin_convertvector(__builtin_convertvector(y, law_d) + turned, law_f);
    law_f e = l->r - yw, I = l->ITerm + l->pKi * e;
    law_i above = I > 150.0f, below = I < -150.0f;
    I = LAW_PICK(above, LAW_ALL(150.0f), LAW_PICK(below, LAW_ALL(-150.0f), I));
    law_f D = l->pLPFa * l->DTerm - l->pLPFb * l->pKd * (yw - l->yw_1);
    law_f u = l->pKp * e + I + D;
    law_i forward = u > 0.0f;
    law_f excite = LAW_PICK(forward, y + l->PA, y - l->PA);
    law_f limited = LAW_PICK(forward, LAW_PICK(u > l->most_u, l->most_u, u), LAW_PICK(u < -l->most_u, -l->most_u, u));
    law_f size = (law_f)((law_i)limited & INT32_MAX), angle = l->phase * -excite;
    law_i fits = (size < 0x1p30f) & ((law_f)((law_i)angle & INT32_MAX) < 0x1p30f);
    int32_t all = -1;
    for (int i = 0; i < LANES; i++) all &= fits[i];
    if (!all) return 0;
    l->y_1 = y;
    l->y = excite;
    l->yw = l->yw_1 = yw;
    l->wrap_count = wraps;
    l->e = e;
    l->ITerm = I;
    l->DTerm = D;
    l->u = limited;
    l->U = __builtin_convertvector(size, law_i);
    law_l dark = __builtin_convertvector((law_f)((law_i)e & INT32_MAX), law_d) < 0.1;
    l->led = __builtin_convertvector(dark, law_i) & 1;
    l->a = law_coil(l->U, sine, __builtin_convertvector(angle, law_i));
    l->b = law_coil(l->U, sine, __builtin_convertvector(angle + 900.0f, law_i));
    return 1;
}

#endif
