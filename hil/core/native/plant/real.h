/* What the plants' kernels are written in: REAL is one axis's number, or one number of each of LANES axes.

   A kernel (simple_kernel.h, full_kernel.h) is included once for every kind of REAL and gives, with the same
   operations in the same order, the same bits for an axis whether it moves alone or in a lane: there is no
   contraction and no library function in it. Define REAL_LANES as 1 or 4 before including this file; it may be
   included again. NAME(x) is x, and x_x4 for lanes. */
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
#undef MAGNITUDE
#undef LESSER
#undef GREATER

#ifndef HIL_PLANT_REAL_H
#define HIL_PLANT_REAL_H
#define LANES 4
typedef double real_x4 __attribute__((vector_size(32), may_alias));
typedef uint64_t mask_x4 __attribute__((vector_size(32), may_alias));
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
#define REAL real_x4
#define MASK mask_x4
#define NAME(x) x##_x4
#define BITS(x) ((mask_x4)(x))
#define UNBITS(x) ((real_x4)(x))
#define MAGNITUDE(x) UNBITS(BITS(x) & INT64_MAX)
#define CONSTANT(x) ((real_x4){x, x, x, x})
#if defined(__AVX2__) && !defined(__clang__) /* what gcc does not find by itself */
typedef double wide_x4 __attribute__((vector_size(32)));
#define PICK(mask, yes, no) ((real_x4)__builtin_ia32_blendvpd256((wide_x4)(no), (wide_x4)(yes), (wide_x4)(mask)))
#define ANY(mask) __builtin_ia32_movmskpd256((wide_x4)(mask))
#define LESSER(x, y) ((real_x4)__builtin_ia32_minpd256((wide_x4)(x), (wide_x4)(y)))
#define GREATER(x, y) ((real_x4)__builtin_ia32_maxpd256((wide_x4)(x), (wide_x4)(y)))
#else
#define PICK(mask, yes, no) ((real_x4)(((mask_x4)(yes) & (mask_x4)(mask)) | ((mask_x4)(no) & ~(mask_x4)(mask))))
#define ANY(mask) (((mask)[0] | (mask)[1] | (mask)[2] | (mask)[3]) != 0)
#define LESSER(x, y) PICK((x) < (y), x, y)
#define GREATER(x, y) PICK((x) > (y), x, y)
#endif
#endif
