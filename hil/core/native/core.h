/* The insides of a core, for its own files only: core.c (groups), axis.c (axes), rt/thread.c. */
#ifndef HIL_CORE_PRIVATE_H
#define HIL_CORE_PRIVATE_H

#include <pthread.h>
#include <stdatomic.h>

#include "control/mechaduino.h"
#include "hil_core.h"
#include "plant/full.h"
#include "plant/simple.h"
#include "rt/ring.h"
#include "rt/seqlock.h"
#include "stepper.h"

#define SNAPSHOT_WORDS ((int)((sizeof(hil_snapshot) + 7) / 8))

/* AS5047D frames: a command's low 14 bits name a register; bit 15 is even parity, and bit 14 of an answer the
   error flag EF (data sheet, SPI). */
enum { SPI_ANGLE = 0x3FFF, SPI_DIAAGC = 0x3FFC, SPI_ERRFL = 0x0001, SPI_EF = 0x4000 };

typedef struct encoder {
    int32_t previous_command, diaagc, errfl;
    int script_len, script_linear;
    int64_t *script_ns, *script_raw;
} encoder;

/* What is wrong with an axis; all zeros: nothing. */
typedef struct axis_fault {
    int is_jammed, is_open_a, is_open_b;
    int32_t slip_counts; /* how far the magnet has slipped on the shaft */
    double noise_counts; /* standard deviation of a reading */
    double load_Nm;      /* beside the axis's own; no matter of is_faulty */
    int is_frozen, is_line_open; /* the encoder's count, and the line that it goes over */
    int32_t frozen_raw;
    uint64_t noise_key;
    double told_a_A, told_b_A; /* the latest current commands */
} axis_fault;

/* A signal source that drives the axis's inputs: source.c. */
typedef struct source {
    hil_edges *rows;
    int n, row;
    int64_t start_ns, next_ns; /* next_ns: of the edge to come, HIL_FOREVER: none */
    int64_t edge, whole_ns, part, rest; /* in a run: duration = whole * edges + part; rest: floor's remainder */
} source;

/* Samples of an axis that is watched: watch.c. */
typedef struct watch {
    hil_snapshot *ring; /* NULL: nobody watches here */
    int capacity, first, len;
    int64_t whole_ns, part, den, rest; /* interval = whole + part / den; rest / den: what the floor of next_ns left out */
    int64_t next_ns, lost;
} watch;

/* A path that the set-point follows: follow.c. */
typedef struct follow {
    hil_path_piece *pieces;
    int n, at;        /* n: 0 none */
    int64_t since_ns; /* the beginning of the piece at */
} follow;

typedef struct hil_axis {
    seqlock published_lock; /* with published, outlives the axis: any thread may be reading */
    _Atomic uint64_t published[SNAPSHOT_WORDS];
    int open, group, next_in_group; /* -1: the last of its group */
    int order;                  /* of its opening in the group, which decides ties */
    int is_active, next_active; /* -1: the last of the group's active ones */
    int is_shown;               /* what is published is what it is, but for the time */
    mechaduino law;
    int is_full; /* which of the two plants moves */
    plant plant;
    full full;
    encoder encoder;
    double load_torque_Nm; /* as it was set, without the fault's */
    axis_fault fault;
    int is_faulty; /* something of fault is set: no lane has room for it */
    double amps_per_count;
    struct { int32_t dir, step, enable, d3; } pins;
    int32_t loop_on;
    int64_t loop_since_ns, loop_steps, next_step_ns; /* control step k is at since + k * 7385 / 48 MHz */
    int64_t control_steps;
    source source;
    follow follow;
    int64_t watch_next_ns; /* of the sample to come, HIL_FOREVER: none */
    stepper *stepper; /* NULL: a servo */
    struct {
        double rev, rev_per_s, torque_Nm, a_A, b_A, a_V, b_V;
        full_energy energy;
        int32_t raw;
    } view; /* filled for a snapshot */
    watch watches[HIL_WATCHES];
    float table[HIL_TABLE_LEN];
} hil_axis;

enum { GROUP_FREE, GROUP_LOOP_THREAD, GROUP_RT_THREAD };

typedef struct hil_group {
    int open, first_axis; /* -1: none */
    int first_active;     /* of the axes that time does something to, in no order; -1: none */
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
    int64_t anchor_ns; /* wall's time of simulated time 0 */
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
    int16_t sine[MECHADUINO_SINE_LEN];
    rt_state rt;
    hil_axis *axes;
    hil_group *groups;
    _Atomic uint8_t *due; /* one flag a group: has something for the loop thread */
};

static inline int64_t axis_step_time_ns(const hil_axis *a, int64_t k)
{
    int64_t whole = k / MECHADUINO_STEP_DEN, part = k % MECHADUINO_STEP_DEN;
    return a->loop_since_ns + whole * MECHADUINO_STEP_NUM_NS + part * MECHADUINO_STEP_NUM_NS / MECHADUINO_STEP_DEN;
}

/* A control step has been made. */
static inline void axis_stepped(hil_axis *a)
{
    a->control_steps++;
    a->next_step_ns = axis_step_time_ns(a, ++a->loop_steps + 1);
}

/* A4954: current command = Vref / (10 Rsense), 255 counts = 3.3 V; direction by the IN pins. */
static inline void axis_currents(const hil_axis *a, double *a_A, double *b_A)
{
    const mechaduino_pins *p = &a->law.pins;
    *a_A = p->vref1 * a->amps_per_count * (p->in2 - p->in1);
    *b_A = p->vref2 * a->amps_per_count * (p->in4 - p->in3);
}

int64_t axis_advance(hil_core *c, hil_axis *a, int axis, int64_t t_ns); /* all that happens up to and at t_ns; how much that was */
int64_t axis_next_ns(const hil_axis *a); /* when something happens next; HIL_FOREVER: never */
int axis_is_idle(const hil_axis *a);     /* at rest, and nothing will happen by itself */
void core_stir(hil_core *c, int axis);   /* before anything is done to it: it may be idle no more */
void axis_pin(hil_core *c, int axis, int pin, int level, int64_t at_ns);
void axis_fill(hil_axis *a, int64_t now_ns, hil_snapshot *out);
void source_edge(hil_core *c, hil_axis *a, int axis); /* the edge at next_ns */
void watch_sample(hil_axis *a);                       /* the samples at watch_next_ns */
void watch_end(hil_axis *a);                          /* all of them */

/* axis.c, for stepper.c */
void axis_make_node(hil_axis *a, int64_t t_ns);
hil_axis *axis_stirred(hil_core *c, int axis, int64_t *now_ns); /* for what changes it; *now_ns: its group's time */
void axis_drive(hil_axis *a);                              /* the law's currents, at a node */
int axis_raw(const hil_axis *a, int64_t t_ns);             /* what the encoder reads */
void axis_load(hil_axis *a);                               /* at a node: both loads act from now on */
int encoder_scripted_raw(const encoder *s, int64_t t_ns);  /* with a script */
void axis_run_plant(hil_axis *a, int64_t t_ns);
void axis_set_currents(hil_axis *a, double a_A, double b_A);

/* stepper.c */
int stepper_open(hil_axis *a, const hil_axis_params *params); /* -1: no memory */
void stepper_close(hil_axis *a);
void stepper_power_up(hil_core *c, hil_axis *a, int64_t now_ns);
int64_t stepper_next_ns(const hil_axis *a);
int64_t stepper_event(hil_core *c, hil_axis *a, int64_t until_ns); /* all that its engine does up to and at until_ns; how much */
void stepper_plant(hil_axis *a, int64_t t_ns); /* the plant's whole steps up to t_ns */
void stepper_pin(hil_core *c, hil_axis *a, int pin, int level, int64_t at_ns);
double stepper_commanded_deg(const hil_axis *a);
double stepper_lag_steps(const hil_axis *a);
double stepper_lost_steps(const hil_axis *a);
int stepper_rst(const hil_axis *a);
int stepper_out(const hil_axis *a, int pin);
int stepper_mode_pins(const hil_axis *a);
void follow_step(hil_axis *a, int64_t at_ns); /* before the control step at that time */
void follow_end(hil_axis *a);
void axis_publish(hil_axis *a, int64_t now_ns);
void group_publish(hil_core *c, int group);
void core_post(hil_core *c, int axis, int64_t at_ns, int kind, double value);

/* thread.c: keep what was just opened in memory; 0 or an errno */
int rt_lock_axis(const hil_core *c, int axis);
int rt_lock_group(const hil_core *c, int group);

#endif
