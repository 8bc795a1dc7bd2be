/* What a pulse of the motion engine costs, the engine alone: `make bench`. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "../motion/motion.h"

static int64_t cpu_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return t.tv_sec * INT64_C(1000000000) + t.tv_nsec;
}

static void measure(const char *what, int exponent, const motion_entry *e)
{
    enum { PULSES = 4000000 };
    static motion m;
    motion_setup s = {.steps_per_rev = 200, .slow_rpm = 10, .microstep_exponent = exponent, .pulse_us = 1,
                      .interrupt_overhead_us = 8, .is_clock_internal = 1, .external_clock_Hz = 1000000};
    motion_init(&m, &s);
    for (int slot = 0; slot < MOTION_SLOTS; slot++) m.entries[slot] = *e;
    motion_loop_bounds(&m, 1, 2, 0);
    int64_t began_ns = cpu_ns();
    int pulses = 0;
    while (pulses < PULSES) pulses += motion_run(&m);
    printf("%-36s %5.1f ns a pulse\n", what, (double)(cpu_ns() - began_ns) / PULSES);
}

int main(void)
{
    motion_entry e = {.steps = 20000, .rpm = 625, .cycle_us = 480, .acc_hundredths = 99900, .dec_hundredths = 99900};
    measure("cruise, 16 microsteps", 4, &e);
    measure("cruise, full steps", 0, &e);
    e.acc_hundredths = e.dec_hundredths = 1;
    measure("harmonic ramps, 16 microsteps", 4, &e);
    measure("harmonic ramps, full steps", 0, &e);
    e.is_linear = 1;
    measure("linear ramps, 16 microsteps", 4, &e);
    measure("linear ramps, full steps", 0, &e);
    e.steps = 2;
    measure("commands of 2 steps, linear", 0, &e);
    return 0;
}
