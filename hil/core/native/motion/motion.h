/* The SAC's motion engine: the queue and what runs it, pulse for pulse. Pure: time is an argument.

   Times are whole half-microseconds (the board's timer counts at 2 MHz) since simulated time 0. An engine does
   nothing by itself: whoever drives it calls motion_run at motion_next, and in between what the
   firmware asks for. docs/decisions/0010-motion-engine.md says how the manual was read. */
#ifndef HIL_MOTION_H
#define HIL_MOTION_H

#include "engine.h"

void motion_init(motion *m, const motion_setup *setup); /* power-up: an empty queue, standing by */
void motion_configure(motion *m, const motion_setup *setup, int64_t now); /* ends all motion */
int64_t motion_next(const motion *m); /* when something happens next; MOTION_NEVER: not by itself */
int64_t motion_tells(const motion *m); /* no command begins or ends before; MOTION_NEVER: none does by itself */
int motion_run(motion *m);            /* what happens then; 1: a pulse */

void motion_enqueue(motion *m, int slot, int64_t now);
void motion_once(motion *m, int slot, int64_t now); /* slot 0: continuous */
void motion_retarget(motion *m, uint32_t rpm, uint32_t cycle_us, int64_t now);
int motion_single(motion *m, int is_ccw, int64_t now); /* 1: a pulse was made */
void motion_stop(motion *m, int64_t now);
void motion_stop_gracefully(motion *m, int32_t dec_hundredths, int64_t now);
void motion_next_command(motion *m, int is_graceful, int64_t now);
void motion_finish(motion *m, int64_t now);
void motion_loop_bounds(motion *m, int start, int finish, int64_t now); /* 0: leave that one */
void motion_loop_passes(motion *m, int64_t passes);
void motion_loop_array(motion *m, int64_t passes, int64_t now);
void motion_release_sync(motion *m, int64_t now);
void motion_clock(motion *m, int64_t clock_Hz, int64_t now);

#endif
