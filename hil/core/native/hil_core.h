/* The native core: groups of axes, each with its own simulated time.

   Handles are opaque; there is no global or static mutable state, so many cores live in one
   process. hil_core_new takes the memory of cores, groups, axes and their laws at once. Later scripts,
   sources, paths and watches are allocated by the calls that set them, in their caller's thread; a list of recorded edges grows in whichever thread advances.

   Who may touch a group: its owner. A group is free, or owned by the loop thread (hil_group_acquire)
   or by the real-time thread; every function below that takes a group or an axis needs the caller to
   own it, unless its comment says "any thread". A core without a real-time thread needs no acquire. */
#ifndef HIL_CORE_H
#define HIL_CORE_H

#include "motion/engine.h"
#include "types.h"

extern const hil_field_info hil_field_table[HIL_FIELDS];

hil_core *hil_core_new(int max_axes, int *event_fd); /* NULL: no memory. event_fd: eventfd, owned by the core */
/* How axes move together; the widest that this processor has unless it is set. The same bits with any. set: before time
   passes; -1: this processor has no such instructions. */
int hil_core_set_lanes(hil_core *c, hil_lanes lanes);
hil_lanes hil_core_lanes(const hil_core *c);
void hil_core_free(hil_core *c);                     /* stops the real-time thread first */

/* Groups and axes: one group for each device with its axis, or for all devices joined by a wire.
   Return the new id, or -1 when all slots are taken or there is no memory; for an axis -2 when its motor is too stiff to be
   integrated. Opening cold-starts: boot pins, zeroed law. */
int hil_group_open(hil_core *c, int64_t now_ns);
void hil_group_close(hil_core *c, int group);
int hil_axis_open(hil_core *c, int group, const hil_axis_params *params);
int64_t hil_axis_bytes(hil_law law); /* memory that is locked for an axis with this law, alone in its group */
void hil_axis_power_up(hil_core *c, int axis); /* cold start; shaft, table, inputs and registers stay */

/* Simulated time. advance: runs every control step up to and at min(until_ns, horizon) and returns the
   time reached; earlier than that when the event ring is half full (drain it and call again: until then
   time stands still), and when it has done as much as one call does, some milliseconds' work (call again). */
int64_t hil_group_advance(hil_core *c, int group, int64_t until_ns);
/* As hil_group_advance for each of n groups: their axes move together. */
void hil_groups_advance(hil_core *c, const int *groups, int n, int64_t until_ns);
int hil_group_is_quiet(const hil_core *c, int group);    /* 1: it will post no event before its firmware has run */
int64_t hil_group_now(const hil_core *c, int group);     /* any thread */
void hil_group_set_horizon(hil_core *c, int group, int64_t horizon_ns);
int hil_group_failed(const hil_core *c, int group);      /* any thread; 1: the event ring overflowed */
int hil_group_has_news(const hil_core *c, int group);    /* consumer's thread; 1: events to take, or it failed */
int hil_group_take_event(hil_core *c, int group, hil_event *out); /* consumer's thread; 0: none */

/* Ownership. acquire spins while the real-time thread is in the group: microseconds. */
void hil_group_acquire(hil_core *c, int group);
void hil_group_release(hil_core *c, int group); /* publishes the snapshots of its axes */

/* An axis. Values act at the group's present time. */
double hil_axis_get(hil_core *c, int axis, hil_field field);
int hil_axis_set(hil_core *c, int axis, hil_field field, double value); /* -1: read-only, or of the other kind of axis */
/* Cells for values of its board's own, at 0, each in the place of a field that the axis does not have; hil_axis_set and
   hil_axis_get reach it there. Once, before anybody watches the axis. -1: no memory, or not now. */
int hil_axis_cells(hil_core *c, int axis, int n, const int32_t *fields);
void hil_axis_output(hil_core *c, int axis, float theta_deg, int effort);
void hil_axis_vref(hil_core *c, int axis, int vref1, int vref2); /* current commands only; IN pins stay */
void hil_axis_loop(hil_core *c, int axis, int on);
int hil_axis_spi(hil_core *c, int axis, int command);
float *hil_axis_table(hil_core *c, int axis); /* HIL_TABLE_LEN angles in degrees; NULL: its law has none */
void hil_axis_pin(hil_core *c, int axis, int pin, int level); /* pin: HIL_SERVO_IN_*, HIL_IN_* */
/* Something (HIL_FAULT_*) goes wrong with an axis, or is right again (value 0). The currents of an open phase stop at
   once. -1: this axis cannot have it. */
int hil_axis_fault(hil_core *c, int axis, int what, double value);
/* A call of the axis's law: abi.def has the calls, and says what each takes and answers. -1: it means nothing now, or the
   law has none. */
double hil_axis_do(hil_core *c, int axis, int call, double x, double y, double z);
double hil_axis_supply_V(const hil_core *c, int axis); /* 0: the simple plant has none */

/* Encoder counts from a script instead of the shaft: n points, times ascending; held before the first
   and after the last. Times and counts within +-2^61. n = 0 gives the encoder back to the shaft. -1: no
   memory. */
int hil_axis_script_encoder(hil_core *c, int axis, int n, const int64_t *at_ns, const int64_t *raw, int linear);
/* A signal source on the inputs from now on, instead of the one before; n = 0: none. Rows in time's order,
   each at or after the end of the run before; steps at least 0, duration_ns at least 2 * steps.
   At one time a source's edge comes before the control step. -1: no memory. */
int hil_axis_drive(hil_core *c, int axis, int n, const hil_edges *rows);

/* The set-point follows a path from start_ns on (now, if that is past), at each control step, and keeps its end;
   until then, and with n = 0, it stays as it is.
   Whatever else sets the set-point or the mode, or stops the loop, ends the path. -1: no memory, -2: a piece
   that is not finite, or too long, -3: its law follows no paths. */
int hil_axis_follow(hil_core *c, int axis, int64_t start_ns, int n, const hil_path_piece *pieces);

/* ---- a stepper: the SAC's motion engine with driver and motor ---- */

/* Slots: 0 continuous, 1 to 30 queue, 31 one-shot. What each does: motion/motion.h. */
void hil_motion_setup(hil_core *c, int axis, const motion_setup *setup); /* ends all motion */
void hil_motion_write(hil_core *c, int axis, int slot, const motion_entry *entry);
void hil_motion_read(hil_core *c, int axis, int slot, motion_entry *out);
void hil_motion_xref_write(hil_core *c, int axis, int index, int slot);
int hil_motion_xref(hil_core *c, int axis, int index);

/* Of an axis with outputs: edges of these (a bit each) from now on, others no more. For virtual time: the list grows in whichever
   thread advances. */
void hil_axis_record_edges(hil_core *c, int axis, int outputs);
int hil_axis_take_edges(hil_core *c, int axis, hil_edge *out, int max);
int hil_axis_output_levels(hil_core *c, int axis); /* a bit each; 0 of an axis without outputs */
/* The same of inputs: first the levels of now, of those that were ever set; then what changes them. */
void hil_axis_record_inputs(hil_core *c, int axis, int inputs);
int hil_axis_take_inputs(hil_core *c, int axis, hil_edge *out, int max);
/* A wire from an output of one axis to an input of another of the same group: from now on the input has the
   output's level, its edges at the same ns. -1: too many, or an axis without outputs. */
int hil_wire(hil_core *c, int from_axis, int from_pin, int to_axis, int to_pin);
/* A magnet on the shaft of another axis of its group, in front of an encoder's chip: from now on the chip reads that shaft,
   0 where the shaft is at zero_deg, as its plant has it (hil_axis_set of position_deg moves nothing). is_reversed: it
   counts down as the shaft's angle grows. -1: the axis is no such chip. */
int hil_magnet(hil_core *c, int axis, int of_axis, int is_reversed, double zero_deg);

/* A switch at an axis, whose pin is of an axis of its group: from now on the pin has the contact's level. Answers its number
   at this axis. -1: there are too many, or there is no memory. */
int hil_switch_add(hil_core *c, int axis, const hil_switch *given);
/* What is wrong with it from now on: its contact stays HIL_CONTACT_OPEN or HIL_CONTACT_CLOSED, or 0; it sits so much farther
   up. -1: there is no such switch, or the shift is not finite. */
int hil_switch_fault(hil_core *c, int axis, int which, int held, double shift_deg);
int hil_switch_is_active(const hil_core *c, int axis, int which); /* by its contact, from any thread */

/* ---- a microcontroller's pins ---- */

/* The board drives a pin to a level from now on, or no longer (-1): then it has the level that comes from outside. */
void hil_bank_write(hil_core *c, int axis, int pin, int level);
int hil_bank_read(const hil_core *c, int axis, int pin);
/* Pulses at a pin from now on, instead of those before, which end at once; n = 0: none. Their end is an event.
   -1: no memory. */
int hil_bank_pulses(hil_core *c, int axis, int pin, int n, const hil_pulses *rows);

/* ---- its processor, which runs a program instead ---- */

/* After a power-up it stands still, its flash and EEPROM are empty, and the board drives the pins. */
void hil_processor_load(hil_core *c, int axis, int at, int n, const uint8_t *data); /* into its flash */
void hil_processor_load_eeprom(hil_core *c, int axis, int at, int n, const uint8_t *data);
void hil_processor_set_fuses(hil_core *c, int axis, const uint8_t fuses[4], int has_boot); /* low, high, extended, lock; has_boot: law/bank_processor.h */
/* A reset for these causes (bits of MCUSR; 0: MCUSR is 0). From now on it drives the pins, until hold or a power-up. */
void hil_processor_reset(hil_core *c, int axis, int causes, int64_t start_up_cycles);
void hil_processor_hold(hil_core *c, int axis);
void hil_processor_clock(hil_core *c, int axis, int64_t hz);
void hil_processor_supply(hil_core *c, int axis, double vcc_V, double aref_V);
int64_t hil_processor_start_up(hil_core *c, int axis); /* clocks of its start after a reset, by its fuses */
/* What its memories have: bytes that are there, of flash, EEPROM or the data space as reads without effects find it. */
void hil_processor_read(hil_core *c, int axis, int memory, int at, int n, uint8_t *out); /* memory: HIL_MEMORY_* */
int64_t hil_processor_cycles(hil_core *c, int axis); /* since its power came */
int64_t hil_processor_baud(hil_core *c, int axis);   /* of its UART, to the nearest; 0: it is off */
int hil_processor_framing(hil_core *c, int axis);    /* of its characters: avr_framing in mcu/avr/atmega328p.h */
int hil_processor_pc(hil_core *c, int axis);         /* the byte address of the next instruction */
/* What drives a pin from the chip (atmega328p.h: avr_drive) + 4 times its level; *duty: part of the time that its PWM is high, -1: it has none. */
int hil_processor_pin(hil_core *c, int axis, int pin, double *duty);
void hil_processor_poke(hil_core *c, int axis, int address, int value); /* of its data space, without what a write does */
/* A character that comes to its RX, not before the group's time; atmega328p.h: avr_character. -1: there is no room. */
int hil_processor_hear(hil_core *c, int axis, int64_t start_ns, double bit_ns, int bits, int length, int is_broken);
void hil_processor_retract(hil_core *c, int axis, int64_t after_ns); /* characters that would begin after that do not come */
/* The voltage at an analogue pin is gain times a field of an axis of its group, and volts, at the time of each sample. Without
   that it is the field a0_V and so on. */
void hil_processor_measure(hil_core *c, int axis, int channel, int of_axis, hil_field field, double gain, double volts);
void hil_processor_volts(hil_core *c, int axis, int channel, double volts);
/* The same of the mean level of a pin, 0 to 19, of a bank of its group, through an RC low-pass. -1: there are too many at that bank. */
int hil_processor_smooth(hil_core *c, int axis, int channel, int of_axis, int pin, double rc_s, double gain, double volts);
void hil_processor_drives_line(hil_core *c, int axis, int pin); /* changes of this output are events: it enables the driver of its line */
/* Debugging: it halts before the instruction at a breakpoint, with an event at whose time its group stands, and goes on from there
   as if it had not. mcu/avr/avr_debug.h says what each does. */
void hil_processor_break(hil_core *c, int axis, int byte, int is_on);
void hil_processor_halt(hil_core *c, int axis);
void hil_processor_go(hil_core *c, int axis, int is_step);
int hil_processor_is_halted(hil_core *c, int axis);
void hil_processor_jump(hil_core *c, int axis, int byte);
void hil_processor_stack_floor(hil_core *c, int axis, int address); /* below it its stack is noted; from a power-up on 100h */
int hil_processor_stack_lowest(hil_core *c, int axis); /* since its reset, by what was put on it */
/* Counts: AVR_FUNCTIONS and AVR_LAPS at the most. Those that read answer how many there are of n. */
void hil_processor_count(hil_core *c, int axis, int n, const uint16_t *starts, int lap_at);
int hil_processor_counted(hil_core *c, int axis, int n, uint64_t *spent, uint32_t *calls);
int64_t hil_processor_counted_clocks(hil_core *c, int axis); /* since count */
int hil_processor_laps(hil_core *c, int axis, int n, uint32_t *laps);

/* Samples: watch `slot` of HIL_WATCHES takes a snapshot at each floor(k * num_ns / den), after all that happens at
   that time. Its ring keeps the first `capacity` that nobody has taken and counts the others as lost. num_ns at
   least den, both below 2^62; num_ns = 0 ends the watch. -1: no memory. The loop thread takes the samples, and need
   not own the axis. */
int hil_axis_watch(hil_core *c, int axis, int slot, int64_t num_ns, int64_t den, int capacity);
/* The extremes of each field instead: of every `points` snapshots, up to a k that is a multiple of it, a pair of samples has
   the smallest and the largest value, in the order in which they came; at_ns is that of the first and of the last. */
int hil_axis_watch_extremes(hil_core *c, int axis, int slot, int64_t num_ns, int64_t den, int points, int capacity);
int hil_axis_take_samples(hil_core *c, int axis, int slot, hil_snapshot *out, int max); /* how many */
int64_t hil_axis_lost_samples(const hil_core *c, int axis, int slot);
void hil_axis_snapshot(hil_core *c, int axis, hil_snapshot *out);
void hil_axis_published(const hil_core *c, int axis, hil_snapshot *out); /* any thread: as of the last release, or in real time of the last 20 ms */

/* The real-time thread. start: 0, or an errno when no thread could be made at all; what it was refused
   (FIFO priority, CPU, locked memory) is in the stats when start returns. */
int hil_rt_start(hil_core *c, const hil_rt_options *options); /* at speed 0 time stands */
void hil_rt_stop(hil_core *c);
int64_t hil_rt_now(const hil_core *c); /* any thread: the simulated time that the wall's time asks for */
void hil_rt_stats_read(const hil_core *c, hil_rt_stats *out); /* any thread; ticks + missed = floor(elapsed / period) */
int hil_rt_take_due(hil_core *c, int *groups, int max); /* groups that reached their horizon or have events; max: call again */

/* A watchdog for the calling thread and the pieces of work that it does: a signal in it each time it has
   burnt `cpu_ns` of CPU time, and during work each time `wall_ns` have gone by. Its handler only calls
   `interrupt(signal_number)`. Work that goes on after HIL_WATCHDOG_SAY times cpu_ns, or
   HIL_WATCHDOG_SAY_WALL times wall_ns, is reported, async signal safe, on stderr and into `file` (the work's
   name); after HIL_WATCHDOG_END times cpu_ns the process ends with HIL_WATCHDOG_EXIT. NULL: no memory or no
   timer. */
enum { HIL_WATCHDOG_SAY = 10, HIL_WATCHDOG_SAY_WALL = 50, HIL_WATCHDOG_END = 20, HIL_WATCHDOG_EXIT = 70 };
typedef struct hil_watchdog hil_watchdog;
hil_watchdog *hil_watchdog_new(int signal_number, void (*interrupt)(int), const char *file);
void hil_watchdog_arm(hil_watchdog *w, int64_t cpu_ns, int64_t wall_ns);
void hil_watchdog_enter(hil_watchdog *w, const char *work);             /* its name, which stays where it is */
int hil_watchdog_leave(hil_watchdog *w);                                /* 1 if it was reported */
void hil_watchdog_aside(hil_watchdog *w);                               /* in work: what comes is not of it */
void hil_watchdog_resume(hil_watchdog *w, const char *work);            /* it is again */
int64_t hil_watchdog_bells(const hil_watchdog *w);                      /* of CPU time, since it was armed */
int hil_watchdog_bells_in_work(const hil_watchdog *w, int wall);        /* since it was entered */
void hil_watchdog_close(hil_watchdog *w); /* gives the signal back; at once, not when it is freed */
void hil_watchdog_free(hil_watchdog *w);

/* The Mechaduino's law alone, fed from arrays: one row for each control step. */
typedef struct hil_replay_row {
    float y_meas, y_excite, yw, e, ITerm, DTerm, v, u;
    int32_t U, wrap_count;
    int16_t vref1, vref2;
    int8_t in1, in2, in3, in4, led;
} hil_replay_row;
typedef struct hil_replay hil_replay;
hil_replay *hil_replay_new(const float *table);
int hil_replay_set(hil_replay *p, hil_field field, double value);
void hil_replay_step(hil_replay *p, int raw, hil_replay_row *row);
void hil_replay_output(hil_replay *p, float theta_deg, int effort, hil_replay_row *row); /* commutation alone */
void hil_replay_free(hil_replay *p);

/* A joint of Walter's Cortex alone: its step generator, and the drive law in front of it. */
typedef struct hil_joint_row {
    float measured_deg, to_be_deg, integral, speed, acceleration, c0, cn, cmin;
    int32_t position, target, n, interval_us, dir;
} hil_joint_row;
typedef struct hil_joint_replay hil_joint_replay;
hil_joint_replay *hil_joint_replay_new(const hil_axis_params *params, double min_deg, double max_deg, double kP,
                                       double speed_rpm, double acceleration_rpm_per_s, int64_t origin_us,
                                       int64_t poll_us); /* NULL: no memory */
void hil_joint_replay_set(hil_joint_replay *p, int what, double value); /* 0: full speed, 1: acceleration, 2: target */
void hil_joint_replay_set_up(hil_joint_replay *p); /* full speed and acceleration as its settings make them */
void hil_joint_replay_move(hil_joint_replay *p, double to_deg, uint32_t now_ms, uint32_t duration_ms);
/* A sample by an ideal encoder, or (measured not NaN) with this angle. */
void hil_joint_replay_sample(hil_joint_replay *p, double measured_deg, uint32_t now_ms);
/* Polls every poll_us, counted from origin_us, from from_us on and before until_us, up to one step; answers its time,
   -1: none. *dir: 1 or -1. */
int64_t hil_joint_replay_step(hil_joint_replay *p, int64_t from_us, int64_t until_us, int *dir);
double hil_joint_replay_deg(const hil_joint_replay *p); /* where it is */
void hil_joint_replay_place(hil_joint_replay *p, double deg); /* something else has brought it there */
void hil_joint_replay_read(const hil_joint_replay *p, hil_joint_row *row);
void hil_joint_replay_free(hil_joint_replay *p);

#endif
