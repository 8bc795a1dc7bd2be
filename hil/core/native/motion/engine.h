/* The state of a SAC's motion engine: data for motion.c, profile.c and whoever owns an engine. */
#ifndef HIL_MOTION_ENGINE_H
#define HIL_MOTION_ENGINE_H

#include <stdint.h>

#include "../abi.h"
#include "ramp.h"

#define MOTION_NEVER INT64_MAX

/* One command, every attribute resolved. */
typedef struct motion_entry {
    uint32_t steps, rpm, cycle_us, wait_us;
    int32_t acc_hundredths, dec_hundredths;
    uint8_t is_ccw, is_linear, extra_pulses, is_sync, is_pulses;
} motion_entry;

typedef struct motion_setup {
    int32_t steps_per_rev, slow_rpm, microstep_exponent, pulse_us, interrupt_overhead_us, clock_correction_us;
    int32_t is_clock_internal, is_cw_high, ops, mode_pins;
    int64_t external_clock_Hz; /* what the external clock is taken to have */
} motion_setup;

enum { WHAT_NOTHING, WHAT_START, WHAT_PULSE, WHAT_END };

typedef struct motion_loop {
    int32_t start, finish, is_on, at; /* 0: not known */
    int64_t passes;                   /* left; 0: forever */
} motion_loop;

typedef struct motion {
    motion_setup setup;
    motion_entry entries[MOTION_SLOTS];
    uint8_t xref[MOTION_QUEUE + 1];
    uint8_t pending[MOTION_QUEUE];
    int32_t pending_first, pending_len;
    motion_loop loop, array; /* array: `at` is the index in xref, start and finish are unused */
    int32_t is_gap_on, is_throttle;

    int32_t state, slot; /* slot: -1 when nothing runs, waits or is held */
    int32_t what;        /* happens at next */
    int64_t next;
    motion_entry now; /* the command in `slot`, as it was when it was loaded */
    int64_t accel_left, cruise_left, decel_left; /* pulses; cruise_left -1: without end */
    int64_t decel_steps;
    int32_t is_decel_set; /* `decel` is the ramp of these */
    ramp accel, decel;
    ramp_list list; /* of the one that is reversed now */
    int64_t period_us;   /* of the present step */
    int32_t pulse;       /* which of the step comes next */
    int64_t rest;        /* external clock: remainder of the last period */
    int64_t in_play_rpm, in_play_until; /* the speed that the next command starts with, and until when */
    int32_t is_held;     /* `slot` waits for the sync */
    int64_t held_base;

    int32_t preempt_slot; /* -1: none */
    int32_t preempt_held;
    int64_t preempt_at;

    int64_t clock_Hz;     /* what the external clock has; -1: external_clock_Hz */
    int64_t pulses;       /* since power-up: clockwise less counter-clockwise */
    int32_t dir_level, op_sa;
    int64_t fall_after;   /* half-us from the last pulse's rise to its fall */
    int64_t begun, ended; /* commands */
    int32_t sync_level, estop_level;
} motion;

#endif
