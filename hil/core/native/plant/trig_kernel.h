/* Sine and cosine, for one REAL (real.h). */

/* Below 2^51; larger numbers are whole, and come out as something whole. */
INLINE REAL NAME(floor_of)(REAL x)
{
    REAL nearest = (x + NEAREST) - NEAREST;
    return nearest - PICK(nearest > x, CONSTANT(1.0), CONSTANT(0.0));
}

/* sin and cos of an angle in turns, to about 1e-15. From 2^48 turns on (a rotor that an absurd load has run
   away with) NaN. The polynomials are in Estrin's order: short chains. */
INLINE void NAME(sincos_turns)(REAL turns, REAL *s, REAL *c)
{
    REAL shifted = turns * 4.0 + NEAREST;
    MASK quarter = BITS(shifted);
    REAL x = (turns - (shifted - NEAREST) * 0.25) * TWO_PI; /* |x| <= pi/4 */
    x = PICK(MAGNITUDE(turns) < 0x1p48, x, CONSTANT(__builtin_nan("")));
    REAL z = x * x, z2 = z * z, z4 = z2 * z2;
    REAL sine = x + x * z *
        (((-1.0 / 6 + z * (1.0 / 120)) + z2 * (-1.0 / 5040 + z * (1.0 / 362880))) +
         z4 * ((-1.0 / 39916800 + z * (1.0 / 6227020800.0)) + z2 * (-1.0 / 1307674368000.0)));
    REAL cosine = 1.0 + z *
        (((-0.5 + z * (1.0 / 24)) + z2 * (-1.0 / 720 + z * (1.0 / 40320))) +
         z4 * ((-1.0 / 3628800 + z * (1.0 / 479001600.0)) + z2 * (-1.0 / 87178291200.0)));
    MASK odd = -(quarter & 1);
    MASK sine_bits = (BITS(sine) & ~odd) | (BITS(cosine) & odd);
    MASK cosine_bits = (BITS(cosine) & ~odd) | (BITS(sine) & odd);
    *s = UNBITS(sine_bits ^ ((quarter & 2) << 62));
    *c = UNBITS(cosine_bits ^ (((quarter + 1) & 2) << 62));
}
