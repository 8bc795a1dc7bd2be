/* Motor and encoder of an axis, whichever plant it has: what turns, and what is read of it. For servos and steppers. */
#ifndef HIL_SHAFT_H
#define HIL_SHAFT_H

#include <math.h>

#include "state.h"

static inline void shaft_run(hil_axis *a, int64_t t_ns)
{
    if (a->is_full) full_advance(&a->full, t_ns);
    else plant_advance(&a->plant, t_ns);
}

/* The next node of the plant's own. */
static inline int64_t shaft_next_node_ns(const hil_axis *a)
{
    return a->is_full ? a->full.node_ns + a->full.step_ns : a->plant.node_ns + a->plant.step_ns;
}

/* Makes t_ns a node: before a change of currents or load. */
static inline void shaft_node(hil_axis *a, int64_t t_ns)
{
    if (a->is_full) full_node(&a->full, t_ns);
    else plant_node(&a->plant, t_ns);
}

/* Of the plant's last one. */
static inline int64_t shaft_node_ns(const hil_axis *a) { return a->is_full ? a->full.node_ns : a->plant.node_ns; }

/* After a change of what is wrong with it. */
static inline void shaft_sum_faults(hil_axis *a)
{
    const axis_fault *f = &a->fault;
    a->is_faulty = f->is_jammed || f->is_open_a || f->is_open_b || f->is_swapped_a || f->is_swapped_b || f->is_too_hot ||
                   f->slip_counts || f->noise_counts > 0 || f->is_frozen || f->is_line_open;
}

static inline void shaft_set_currents(hil_axis *a, double a_A, double b_A)
{
    a->fault.told_a_A = a_A;
    a->fault.told_b_A = b_A;
    if (a->is_faulty) {
        if (a->fault.is_open_a || a->fault.is_too_hot) a_A = 0;
        if (a->fault.is_open_b || a->fault.is_too_hot) b_A = 0;
        if (a->fault.is_swapped_a) a_A = -a_A;
        if (a->fault.is_swapped_b) b_A = -b_A;
    }
    if (a->is_full) full_set_currents(&a->full, a_A, b_A);
    else plant_set_currents(&a->plant, a_A, b_A);
}

/* At a node: both loads act from now on. */
static inline void shaft_set_load(hil_axis *a)
{
    double load_Nm = a->load_torque_Nm + a->fault.load_Nm;
    if (a->is_full) full_set_load(&a->full, load_Nm);
    else plant_set_load(&a->plant, load_Nm);
}

static inline double shaft_load_Nm(const hil_axis *a) { return a->is_full ? a->full.load_torque_Nm : a->plant.load_torque_Nm; }

/* The angle at a time that is not before the plant's last node. */
static inline double shaft_rev(const hil_axis *a, int64_t t_ns)
{
    return a->is_full ? full_at(&a->full, t_ns).moving.state.rev : plant_at(&a->plant, t_ns).rev;
}

/* The count at an angle. */
static inline int shaft_count(double rev)
{
    if (!(fabs(rev) < 0x1p51)) return 0; /* run away under an absurd load */
    return (int)((rev - floor_of(rev)) * 16384) & 16383;
}

/* What a faulty encoder makes of a count. */
static inline int shaft_faulty_raw(const hil_axis *a, int raw, int64_t t_ns)
{
    if (!a->is_faulty) return raw;
    double noise = full_noise(a->fault.noise_key, a->fault.noise_counts, (uint64_t)t_ns);
    return (raw + a->fault.slip_counts + (int)floor(noise + 0.5)) & 16383;
}

/* What is read of an encoder that does not see the shaft; -1: it sees it. */
static inline int shaft_blind_raw(const hil_axis *a, int64_t t_ns)
{
    if (a->fault.is_line_open) return 16383;
    if (a->fault.is_frozen) return a->fault.frozen_raw;
    return a->encoder.script_len ? encoder_scripted_raw(&a->encoder, t_ns) : -1;
}

/* What the encoder reads, at a node. */
static inline int shaft_raw_at_node(const hil_axis *a, int64_t t_ns)
{
    int raw = shaft_blind_raw(a, t_ns);
    if (raw >= 0) return raw;
    return shaft_faulty_raw(a, a->is_full ? full_raw(&a->full, t_ns) : shaft_count(a->plant.moving.rev), t_ns);
}

/* What the encoder reads. */
static inline int shaft_raw(const hil_axis *a, int64_t t_ns)
{
    int raw = shaft_blind_raw(a, t_ns);
    if (raw >= 0) return raw;
    if (!a->is_full) return shaft_faulty_raw(a, shaft_count(plant_at(&a->plant, t_ns).rev), t_ns);
    full now = full_at(&a->full, t_ns);
    return shaft_faulty_raw(a, full_raw(&now, t_ns), t_ns);
}

#endif
