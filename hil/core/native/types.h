/* What goes over the core's face (hil_core.h), and what its modules hand each other: values, no functions. */
#ifndef HIL_TYPES_H
#define HIL_TYPES_H

#include <stddef.h>
#include <stdint.h>

#include "abi.h"

#define HIL_FOREVER INT64_MAX

typedef struct hil_core hil_core;

typedef float hil_f32;
typedef double hil_f64;
typedef int32_t hil_i32;
typedef int64_t hil_i64;

typedef struct hil_snapshot {
#define X(name, type, kind, access, unit, expression, meaning) hil_##type name;
#include "fields.def"
#undef X
} hil_snapshot;

typedef enum hil_field {
#define X(name, type, kind, access, unit, expression, meaning) HIL_FIELD_##name,
#include "fields.def"
#undef X
    HIL_FIELDS
} hil_field;

typedef struct hil_field_info {
    const char *name, *type, *unit, *meaning;
    size_t offset; /* in hil_snapshot */
    int writable, kind; /* kind: HIL_KIND_* */
} hil_field_info;

typedef struct hil_event {
    int64_t at_ns;
    int32_t axis;
    int32_t kind;
    double value;
} hil_event;

/* What the full plant takes more. Resistance, inductance and supply above 0, the others at least 0. */
typedef struct hil_full_params {
    double phase_resistance_ohm, phase_inductance_H, supply_V, detent_torque_Nm, coulomb_torque_Nm;
    double full_step_error_pct, encoder_eccentricity_deg, encoder_nonlinearity_deg, encoder_noise_counts;
} hil_full_params;

/* What the full plant's shaft turns; all zeros: nothing. The parts add up. Inertia, stiffness and the
   pendulum's weight times length at least 0; min_deg below max_deg. */
typedef struct hil_load {
    double inertia_kg_m2, torque_Nm;
    double stiffness_Nm_per_rad, pendulum_Nm, centre_deg; /* centre: where spring and pendulum rest */
    double min_deg, max_deg;
    double stop_Nm_per_rad; /* 0: as stiff as a step of the plant resolves */
    int32_t end_stops;
} hil_load;

/* What a signal source does to an axis's inputs. steps 0: at at_ns the pin gets the level. Else a run of
   that many pulses on the step input: edge j, a rise if j is even, at at_ns + floor(j * duration_ns / (2 * steps)).
   at_ns counts from the source's start. */
typedef struct hil_edges {
    int64_t at_ns, steps, duration_ns;
    int32_t pin, level;
} hil_edges;

/* Pulses one after the other: each rises period_ns after the one before, the first one after what was before it, and
   is high for high_ns, which is less. */
typedef struct hil_pulses {
    int64_t pulses, period_ns, high_ns;
} hil_pulses;

/* The motor's and driver's parameters; the names carry the units. All finite; inertia, torque
   constant, sense resistor and rotor teeth above 0, friction at least 0 (the caller checks). */
typedef struct hil_axis_params {
    int32_t law;
    int32_t driver; /* of a stepper: 0 A4988, 1 DRV8825 */
    double phase_current_A; /* of a stepper or a driver: what the driver is set to */
    double ambient_degC;    /* of a driver */
    double fast_decay_pct;  /* of a driver: part of the supply that a falling current gets */
    double inertia_kg_m2, viscous_Nm_s_per_rad, torque_constant_Nm_per_A;
    double sense_resistor_ohm, start_deg, load_torque_Nm;
    int32_t rotor_teeth;
    int32_t driver_microsteps, counts_backwards; /* of a joint; microsteps 0: a servo turns it. 1: its pulses are counted the wrong way */
    double gear_ratio, encoder_null_deg, encoder_offset_deg; /* of a joint; null + offset is what its encoder shows at 0 */
    int32_t is_full; /* the full plant; of the simple one what follows is ignored */
    hil_full_params full;
    hil_load load;
    uint64_t seed; /* phases of periodic errors, and noise */
} hil_axis_params;

typedef struct hil_rt_options {
    int64_t period_ns; /* up to 1 s */
    double speed;      /* simulated seconds per second */
    int priority;      /* SCHED_FIFO priority wanted */
    int cpu;           /* CPU to pin to, -1: none */
} hil_rt_options;

typedef struct hil_rt_stats {
    int64_t ticks, missed, elapsed_ns, overruns;
    uint64_t wake_latency[HIL_HISTOGRAM_LEN];
    int64_t longest_latency_ns, latency_total_ns;
    int fifo_errno, pin_errno, lock_errno; /* 0: granted */
    int running;
} hil_rt_stats;

/* A piece of a path: the set-point and its first three derivatives at the piece's beginning, by the second. */
typedef struct hil_path_piece {
    int64_t duration_ns;
    double r, per_s, per_s2, per_s3;
} hil_path_piece;
#define HIL_PATH_NS (INT64_C(1) << 62) /* a path is shorter */

/* A switch: a cam from one angle of a shaft to another, by the shaft's own angle (hil_axis_set of position_deg moves nothing).
   It lets go by the hysteresis farther out. every_deg above 0: it comes again each so many degrees. opens: the cam opens
   the contact (normally closed); closed_level: what a closed contact makes of the pin. Both angles finite where it repeats. */
typedef struct hil_switch {
    double from_deg, to_deg, hysteresis_deg, every_deg;
    int32_t opens, closed_level;
    int32_t to_axis, to_pin; /* to_axis -1: to no pin */
    int64_t bounce_ns;       /* the longest */
    uint64_t seed;           /* of the bounces */
} hil_switch;

/* An edge of an output, recorded. */
typedef struct hil_edge {
    int64_t at_ns;
    int32_t pin, level;
} hil_edge;

#endif
