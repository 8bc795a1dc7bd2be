/* The speed of a shaft, for one REAL (real.h). */

/* The speed that is left of one in rev/s: the limit at most, a NaN is cut too; and 0 where friction has left
   less than any angle shows, instead of decaying forever. */
INLINE REAL NAME(turning)(REAL rev_per_s, REAL limit)
{
    REAL most = GREATER(LESSER(rev_per_s, limit), -limit);
    return PICK(MAGNITUDE(most) < 1e-20, CONSTANT(0.0), most);
}
