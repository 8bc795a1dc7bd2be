/* The joints of Walter's Cortex, and the main loop that they have in common, which the first of them holds. */
#ifndef HIL_LAW_WALTER_H
#define HIL_LAW_WALTER_H

#include "../control/joint.h"
#include "../law.h"

enum { WALTER_STEPPERS = 5, WALTER_SAMPLE_MS = 20, WALTER_PASS_US = 10, WALTER_PULSE_US = 2, WALTER_MOST_FAILURES = 5 };

/* What the loop does until it is told something else. */
enum { WALTER_STOPPED, WALTER_RUNS, WALTER_POLLS };

typedef struct walter_board {
    int mode, steppers; /* steppers: how many are known to the loop, the first ones */
    int has_24V;
    int64_t origin_ns; /* the power-up, from which its clocks count */
    int64_t cursor_us; /* where it is: when its next pass or poll begins */
    int64_t second_us; /* of a wait behind another: when it begins; 0: there is none */
    int64_t now_ms;    /* that timers and laws of the latest pass go by */
    hil_axis *axes[WALTER_STEPPERS];
} walter_board;

typedef struct walter_axis {
    walter_joint joint;
    walter_board board; /* of the first axis; others do not use theirs */
    hil_axis *first;    /* NULL: the board has not started */
    double deg, step_deg, mount_deg, holding_Nm; /* where the joint is; how far a pulse moves it; what the encoder shows at 0 */
    int64_t pulses;
    int is_stepper, is_enabled, is_connected, is_passed, is_up;
    int last_count;
    int knob_counts, has_lights; /* around the board */
    uint16_t sampled_ms;
    uint8_t failures;
} walter_axis;

extern const law walter_law;

const walter_axis *walter_view(const hil_axis *a); /* of another law: all zeros */
double walter_to_be_deg(const hil_axis *a, int64_t now_ns);
int walter_is_powered(const hil_axis *a);
int64_t walter_ramp_left_ms(const hil_axis *a, int64_t now_ns);

#endif
