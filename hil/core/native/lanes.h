/* Lanes: axes of a kind that move together, one in each lane of a vector. */
#ifndef HIL_LANES_H
#define HIL_LANES_H

#include "state.h"

/* Lengths of a control step, and of the plants' last steps in it: one even, one odd. */
#define STEP_NS (MECHADUINO_STEP_NUM_NS / MECHADUINO_STEP_DEN)
#define LONGER_EVERY 6 /* of six, the last one is 1 ns longer */
_Static_assert(STEP_NS * MECHADUINO_STEP_DEN + MECHADUINO_STEP_DEN / LONGER_EVERY == MECHADUINO_STEP_NUM_NS,
               "a sixth of a ns more");
_Static_assert(STEP_NS % 2 == 0, "the longer ones are odd");
_Static_assert(PLANT_STEP_NS > STEP_NS + 1, "one step of the simple plant");
_Static_assert((FULL_WINDOW - 1) * FULL_STEP_NS < STEP_NS && FULL_WINDOW * FULL_STEP_NS > STEP_NS + 1,
               "a window of the full plant");
_Static_assert(FULL_STEP_NS % 2 == 0, "what is left of a control step is odd when the control step is");

/* So many vectors at a time, where there are axes for more than one: while one waits for its results, the processor works
   on the other. */
#define ROWS 2
#define MOST_SEATS (ROWS * 8)

typedef struct lane {
    hil_axis *axis;
    int64_t steps; /* control steps to make */
} lane;

/* n control steps of axes that fit, up to ROWS vectors of them. In empty seats the first axis moves once more, for nothing. */
typedef void batch_run(hil_core *c, const lane *lanes, int seated, int64_t n);

#endif
