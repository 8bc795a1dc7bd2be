/* Keeps what the real-time thread touches in memory: 0 or an errno. */
#ifndef HIL_RT_LOCK_H
#define HIL_RT_LOCK_H

#include "../state.h"

int rt_lock_axis(const hil_core *c, int axis);
int rt_lock_group(const hil_core *c, int group);

#endif
