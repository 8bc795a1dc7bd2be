/* What goes over the core's face (hil_core.h), and what its modules hand each other: values, no functions. */
#ifndef HIL_TYPES_H
#define HIL_TYPES_H

#include <stddef.h>
#include <stdint.h>

#define HIL_TABLE_LEN 16384
/* Eight buckets an octave: bucket b < 8 counts values of b ns; the others those of
   [(8 + b % 8) << (b / 8 - 1), (9 + b % 8) << (b / 8 - 1)) ns, up to 2^42. */
#define HIL_HISTOGRAM_LEN 320
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

enum { HIL_KIND_ANY, HIL_KIND_SERVO, HIL_KIND_STEPPER }; /* of axis that has a field */

typedef struct hil_field_info {
    const char *name, *type, *unit, *meaning;
    size_t offset; /* in hil_snapshot */
    int writable, kind; /* kind: HIL_KIND_* */
} hil_field_info;

typedef enum hil_event_kind {
    HIL_EVENT_STEP_RESPONSE = 1, /* value: yw * 1024, the number that 'j' prints before truncation */
    HIL_EVENT_ENABLE = 2,        /* value: level of the enable input after a change */
    HIL_EVENT_COMMAND_BEGUN = 3, /* of a stepper that reports (HIL_MOTION_REPORT): OP SA rose; value: its slot */
    HIL_EVENT_COMMAND_ENDED = 4, /* and fell */
    HIL_EVENT_ESTOP = 5,         /* value: level of a stepper's Estop input after a change */
} hil_event_kind;

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
    int32_t end_stops;
} hil_load;

/* What a signal source does to an axis's inputs. steps 0: at at_ns the pin gets the level. Else a run of
   that many pulses on the step input: edge j, a rise if j is even, at at_ns + floor(j * duration_ns / (2 * steps)).
   at_ns counts from the source's start. */
typedef struct hil_edges {
    int64_t at_ns, steps, duration_ns;
    int32_t pin, level;
} hil_edges;

typedef enum hil_law { HIL_LAW_MECHADUINO, HIL_LAW_SAC } hil_law; /* a servo, a stepper */

/* The motor's and driver's parameters; the names carry the units. All finite; inertia, torque
   constant, sense resistor and rotor teeth above 0, friction at least 0 (the caller checks). */
typedef struct hil_axis_params {
    int32_t law;
    int32_t driver; /* of a stepper: 0 A4988, 1 DRV8825 */
    double phase_current_A; /* of a stepper: what the driver is set to */
    double inertia_kg_m2, viscous_Nm_s_per_rad, torque_constant_Nm_per_A;
    double sense_resistor_ohm, start_deg, load_torque_Nm;
    int32_t rotor_teeth;
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

/* What hil_axis_fault sets to a value; 0: right again. */
enum {
    HIL_FAULT_JAM,          /* 1: the rotor stands */
    HIL_FAULT_OPEN_A,       /* 1: no current in coil A */
    HIL_FAULT_OPEN_B,
    HIL_FAULT_SLIP,         /* counts that the encoder's magnet has slipped */
    HIL_FAULT_NOISE,        /* standard deviation of a reading, counts */
    HIL_FAULT_NOISE_SEED,   /* a whole number */
    HIL_FAULT_SUPPLY,       /* volts of the full plant's supply */
    HIL_FAULT_SHIFT,        /* turns that the shaft is moved by, once; not one that is jammed */
    HIL_FAULT_LOAD,         /* Nm on the shaft beside load_torque_Nm as it was set */
    HIL_FAULT_FREEZE,       /* 1: the encoder stays at the count that it has now */
    HIL_FAULT_OPEN_LINE,    /* 1: the encoder's data line is open and reads as all ones */
};

/* A piece of a path: the set-point and its first three derivatives at the piece's beginning, by the second. */
typedef struct hil_path_piece {
    int64_t duration_ns;
    double r, per_s, per_s2, per_s3;
} hil_path_piece;
#define HIL_PATH_NS (INT64_C(1) << 62) /* a path is shorter */

/* An edge of an output, recorded. */
typedef struct hil_edge {
    int64_t at_ns;
    int32_t pin, level;
} hil_edge;
enum { HIL_OUT_CLK, HIL_OUT_DIR, HIL_OUT_OP_SA, HIL_OUT_OP_SB, HIL_OUT_MS1, HIL_OUT_MS2, HIL_OUT_MS3, HIL_OUTPUTS };
enum { HIL_IN_SYNC, HIL_IN_ESTOP, HIL_IN_RST, HIL_IN_ENA, HIL_IN_ENB }; /* hil_axis_pin of a stepper */

enum { HIL_WATCHES = 17 }; /* of an axis */

#endif
