/* What a core, its groups and its axes hold: data alone.

   The core's files are layers: what they include and call makes no circle (hil/core/tests checks it). From below:
   cells, what knows no axis (mcu/, motion/, plant/, control/, encoder, source, follow, outputs, extremes, watch), this, core, shaft, law, the laws (law/),
   pins and view, axis, group and fault, batch, rt/thread, arena; beside them replay. */
#ifndef HIL_STATE_H
#define HIL_STATE_H

#include <pthread.h>
#include <stdatomic.h>

#include "cells.h"
#include "control/mechaduino.h"
#include "encoder.h"
#include "outputs.h"
#include "plant/full.h"
#include "plant/simple.h"
#include "rt/ring.h"
#include "rt/seqlock.h"
#include "source.h"
#include "types.h"
#include "watch.h"

#define SNAPSHOT_WORDS ((int)((sizeof(hil_snapshot) + 7) / 8))

typedef struct law law; /* law.h */
typedef struct switch_list switch_list; /* switches.h */

/* What is wrong with an axis; all zeros: nothing. */
typedef struct axis_fault {
    int is_jammed, is_open_a, is_open_b, is_swapped_a, is_swapped_b;
    int is_too_hot; /* its driver has no current: the law's doing, nobody's fault */
    int32_t slip_counts; /* how far the magnet has slipped on the shaft */
    double noise_counts; /* standard deviation of a reading */
    double load_Nm;      /* beside the axis's own; no matter of is_faulty */
    int is_frozen, is_line_open; /* the encoder's count, and the line that it goes over */
    int32_t frozen_raw;
    double silent_rate; /* of readings on a bus that get no answer */
    uint64_t noise_key;
    double told_a_A, told_b_A; /* the latest current commands */
} axis_fault;

typedef struct hil_axis {
    seqlock published_lock; /* with published, outlives the axis: any thread may be reading */
    _Atomic uint64_t published[SNAPSHOT_WORDS];
    int open, group, next_in_group; /* -1: the last of its group */
    int order;                  /* of its opening in the group, which decides ties */
    int is_active, next_active; /* -1: the last of the group's active ones */
    int is_joined, next_joined; /* wired to another axis, or a part of a board with it, from then on; -1: the last such */
    int next_bound;             /* of a list that lives in a call; -1: the last */
    int is_shown;               /* what is published is what it is, but for the time */
    const law *law;
    void *own;           /* the law's memory */
    own_cells *cells;    /* NULL: its board has no fields of its own */
    int64_t law_next_ns; /* when it does something next; HIL_FOREVER: not by itself */
    int is_pacing;       /* its next step is the plant's next node: who looks before steps a copy */
    int is_turned;       /* it has other currents since the plant's last node, which come with the next */
    int is_telling;      /* it may post events when it steps */
    int is_processor;    /* it runs a program: what it does next cannot be known beforehand */
    int has_stopped;     /* it has gone no further than stopped_ns: it has done something that others may hear of */
    int64_t stopped_ns;
    int is_full;   /* which of the two plants moves */
    int is_faulty; /* something of fault is set: no lane has room for it */
    int64_t watch_next_ns; /* of the sample to come, or of the look at its switches or its driver's heat to come; HIL_FOREVER: none */
    int64_t switch_next_ns, heat_next_ns; /* of these looks */
    switch_list *switches; /* NULL: it has none. One that has some is never idle */
    source source;
    encoder encoder;
    axis_fault fault;
    double load_torque_Nm; /* as it was set, without the fault's */
    double zero_rev;       /* of the angles that are told: what turns the shaft knows nothing of it */
    plant plant; /* from here on lanes touch little */
    full full;
    struct {
        double rev, rev_per_s, torque_Nm, a_A, b_A, a_V, b_V;
        full_energy energy;
        int32_t raw;
    } view; /* filled for a snapshot */
    watch watches[HIL_WATCHES];
    struct {
        int32_t recorded, known, high; /* inputs, a bit each: kept in edges, set at all, set to 1 */
        edge_list edges;
    } inputs;
} hil_axis;

enum { GROUP_FREE, GROUP_LOOP_THREAD, GROUP_RT_THREAD };

typedef struct hil_group {
    int open, first_axis; /* -1: none */
    int first_active;     /* of the axes that time does something to, in no order; -1: none */
    int first_joined, first_bound; /* as first_active */
    _Atomic int owner;
    _Atomic int64_t now_ns;
    _Atomic int failed;
    int64_t horizon_ns;
    int reported; /* the due horizon has been told once */
    int stops;    /* an event is waiting that time does not go past */
    int64_t published_ns;
    event_ring events;
} hil_group;

typedef struct rt_state {
    pthread_t thread;
    _Atomic int running, stop;
    hil_rt_options options;
    int64_t anchor_ns; /* wall's time of the start */
    int64_t begin_ns;  /* simulated time then */
    seqlock stats_lock;
    _Atomic uint64_t stats[(sizeof(hil_rt_stats) + 7) / 8];
    hil_rt_stats live; /* the thread's own */
    int next_group;    /* where the next wake begins */
    int64_t wakes;
    void *stack;
    size_t stack_len;
} rt_state;

struct hil_core {
    int max_axes;
    _Atomic int groups_used;
    size_t arena_len;
    int event_fd;
    hil_lanes lanes;
    int16_t sine[MECHADUINO_SINE_LEN];
    rt_state rt;
    hil_axis *axes;
    struct { char *first; size_t stride; } laws[HIL_LAWS]; /* memory for each law at each axis; only what is opened is touched */
    hil_group *groups;
    hil_event *events; /* RING_MOST for each group; likewise */
    _Atomic uint8_t *due; /* one flag a group: has something for the loop thread */
};

#endif
