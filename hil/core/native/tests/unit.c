#include "check.h"

check_counts check_state;

void law_tests(void);
void plant_tests(void);
void full_tests(void);
void axis_tests(void);
void groups_tests(void);
void batch_tests(void);
void follow_tests(void);
void source_tests(void);
void motion_tests(void);
void stepper_tests(void);
void watchdog_tests(void);
void packet_tests(void);
void fault_tests(void);
void trajectory_tests(void);
void spline_tests(void);
void joint_tests(void);
void pty_lines_tests(void);

int main(int argc, char **argv)
{
    law_tests();
    plant_tests();
    full_tests();
    axis_tests();
    groups_tests();
    batch_tests();
    follow_tests();
    source_tests();
    motion_tests();
    stepper_tests();
    watchdog_tests();
    packet_tests();
    fault_tests();
    trajectory_tests();
    spline_tests();
    joint_tests();
    pty_lines_tests();
    return check_report("unit", argc > 1 ? argv[1] : NULL);
}
