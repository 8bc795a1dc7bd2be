/* Long linear ramps downwards. */
#include "check.h"

#include "motion/ramp.h"

/* Both sides of RAMP_FAR against the list walked from its start: periods of 1 us come from values that differ by
   1e-7 from step to step. */
static void test_far_values_are_the_recurrences(void)
{
    static ramp_list list;
    enum { NEAR = 2000 };
    const int64_t length = RAMP_FAR + NEAR;
    ramp up, down;
    ramp_linear_from_stop(&up, 1, 200);
    ramp_linear_from_stop(&down, 1, 200);
    ramp_reverse(&down, length, &list);
    double values[2 * NEAR];
    for (int64_t i = 0; i < length; i++) {
        if (i >= length - 2 * NEAR) values[i - (length - 2 * NEAR)] = up.c;
        ramp_next_us(&up);
    }
    for (int i = 2 * NEAR - 1; i >= 0; i--) {
        double value = values[i], fraction = value - floor(value);
        int64_t period_us = ramp_next_us(&down);
        CHECK(period_us == (int64_t)value || fraction < 1e-6 || fraction > 1 - 1e-6);
    }
}

/* Cheap however long it is, and it does not get faster on its way down. */
static void test_a_ramp_of_2_to_the_48_ends_slow(void)
{
    static ramp_list list;
    ramp down;
    ramp_linear_from_stop(&down, 1, 200);
    ramp_reverse(&down, INT64_C(1) << 48, &list);
    int64_t before_us = 0;
    for (int i = 0; i < 100000; i++) {
        int64_t period_us = ramp_next_us(&down);
        CHECK(period_us >= before_us);
        before_us = period_us;
    }
}

void ramp_tests(void)
{
    RUN(test_far_values_are_the_recurrences);
    RUN(test_a_ramp_of_2_to_the_48_ends_slow);
}
