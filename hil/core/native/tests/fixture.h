/* What several files of tests set up: the Mechaduino's axis, a core with axes, a random generator. */
#ifndef HIL_TESTS_FIXTURE_H
#define HIL_TESTS_FIXTURE_H

#include <stdlib.h>
#include <string.h>

#include "../hil_core.h"
#include "../state.h"
#include "check.h"

/* device_profiles/mechaduino/profile.yaml */
static const hil_axis_params MECHADUINO = {
    .inertia_kg_m2 = 5.4e-6, .viscous_Nm_s_per_rad = 0.004, .torque_constant_Nm_per_A = 0.225,
    .sense_resistor_ohm = 0.15, .rotor_teeth = 50,
};

static inline void identity_table(float *table)
{
    for (int i = 0; i < HIL_TABLE_LEN; i++) table[i] = (float)(i * 360.0 / HIL_TABLE_LEN);
}

static inline hil_core *new_core(int max_axes)
{
    int fd;
    hil_core *c = hil_core_new(max_axes, &fd);
    if (!c) {
        perror("hil_core_new");
        exit(2);
    }
    return c;
}

static inline int open_axis(hil_core *c, int group)
{
    int axis = hil_axis_open(c, group, &MECHADUINO);
    if (axis >= 0) identity_table(hil_axis_table(c, axis));
    return axis;
}

/* A group without a horizon. */
static inline int open_group(hil_core *c, int64_t now_ns)
{
    int group = hil_group_open(c, now_ns);
    if (group >= 0) hil_group_set_horizon(c, group, HIL_FOREVER);
    return group;
}

/* A core of one group with one axis, both 0. */
static inline hil_core *new_bench(void)
{
    hil_core *c = new_core(1);
    open_axis(c, open_group(c, 0));
    return c;
}

/* In as many calls as it takes; without events that wait to be taken. */
static inline int64_t advance_to(hil_core *c, int group, int64_t until_ns)
{
    int64_t now_ns;
    while ((now_ns = hil_group_advance(c, group, until_ns)) < until_ns) {
    }
    return now_ns;
}

/* Control step k of a loop switched on at 0. */
static inline int64_t step_ns(int64_t k) { return k * 7385000 / 48; }

/* xorshift64*; never 0. */
static inline uint64_t next_random(uint64_t *state)
{
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return *state * 0x2545F4914F6CDD1D;
}

static inline int64_t random_below(uint64_t *state, int64_t n) { return (int64_t)(next_random(state) % (uint64_t)n); }

#endif
