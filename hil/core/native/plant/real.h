/* What the plants' kernels are written in: REAL is one axis's number, or one number of each of LANES axes.

   A kernel (simple_kernel.h, full_kernel.h) is included once for every kind of REAL and gives, with the same
   operations in the same order, the same bits for an axis whether it moves alone or in a lane: there is no
   contraction and no library function in it. Define REAL_LANES as 1, 4 or 8 before including this file; it may be
   included again, with 1 or with the same number. NAME(x) is x, and x_xn for lanes. */
#include <stdint.h>
#include <string.h>

#undef REAL
#undef MASK
#undef NAME
#undef PICK
#undef BITS
#undef UNBITS
#undef CONSTANT
#undef ANY
#undef CHOSEN
#undef MAGNITUDE
#undef LESSER
#undef GREATER

#ifndef HIL_PLANT_REAL_H
#define HIL_PLANT_REAL_H
#define INLINE static inline __attribute__((always_inline, unused))
static const double TWO_PI = 6.28318530717958647692;
static const double NEAREST = 0x1.8p52; /* added and taken away: rounds to a whole number, below 2^51 */
INLINE uint64_t bits_of(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}
INLINE double of_bits(uint64_t bits)
{
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}
#endif

#if REAL_LANES > 1 && !defined(LANES)
#define LANES REAL_LANES
typedef double real_xn __attribute__((vector_size(8 * LANES), may_alias));
typedef uint64_t mask_xn __attribute__((vector_size(8 * LANES), may_alias));
INLINE int any_of(mask_xn mask)
{
    uint64_t any = 0;
    for (int i = 0; i < LANES; i++) any |= mask[i];
    return any != 0;
}
#endif

#if REAL_LANES == 1
#define REAL double
#define MASK uint64_t
#define NAME(x) x
#define PICK(mask, yes, no) ((mask) ? (yes) : (no))
#define BITS(x) bits_of(x)
#define UNBITS(x) of_bits(x)
#define CONSTANT(x) (x)
#define ANY(mask) (mask)
#define MAGNITUDE(x) __builtin_fabs(x)
#define LESSER(x, y) ((x) < (y) ? (x) : (y)) /* y, if one of them is a NaN */
#define GREATER(x, y) ((x) > (y) ? (x) : (y))
#else
#define REAL real_xn
#define MASK mask_xn
#define NAME(x) x##_xn
#define BITS(x) ((mask_xn)(x))
#define UNBITS(x) ((real_xn)(x))
#define MAGNITUDE(x) UNBITS(BITS(x) & INT64_MAX)
#if LANES == 4
#define CONSTANT(x) ((real_xn){x, x, x, x})
#else
#define CONSTANT(x) ((real_xn){x, x, x, x, x, x, x, x})
#endif
#if defined(__AVX512DQ__) && LANES == 8 && !defined(__clang__) /* what gcc does not find by itself */
#include <immintrin.h>
#define CHOSEN(mask) _mm512_movepi64_mask((__m512i)(mask))
#define PICK(mask, yes, no) ((real_xn)_mm512_mask_blend_pd(CHOSEN(mask), (__m512d)(no), (__m512d)(yes)))
#define ANY(mask) CHOSEN(mask)
#define LESSER(x, y) ((real_xn)_mm512_min_pd((__m512d)(x), (__m512d)(y)))
#define GREATER(x, y) ((real_xn)_mm512_max_pd((__m512d)(x), (__m512d)(y)))
#elif defined(__AVX2__) && LANES == 4 && !defined(__clang__)
typedef double wide_xn __attribute__((vector_size(32)));
#define PICK(mask, yes, no) ((real_xn)__builtin_ia32_blendvpd256((wide_xn)(no), (wide_xn)(yes), (wide_xn)(mask)))
#define ANY(mask) __builtin_ia32_movmskpd256((wide_xn)(mask))
#define LESSER(x, y) ((real_xn)__builtin_ia32_minpd256((wide_xn)(x), (wide_xn)(y)))
#define GREATER(x, y) ((real_xn)__builtin_ia32_maxpd256((wide_xn)(x), (wide_xn)(y)))
#else
#define PICK(mask, yes, no) ((real_xn)(((mask_xn)(yes) & (mask_xn)(mask)) | ((mask_xn)(no) & ~(mask_xn)(mask))))
#define ANY(mask) any_of(mask)
#define LESSER(x, y) PICK((x) < (y), x, y)
#define GREATER(x, y) PICK((x) > (y), x, y)
#endif
#endif
