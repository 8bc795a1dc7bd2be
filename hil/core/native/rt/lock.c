#include "lock.h"

#include <errno.h>
#include <sys/mman.h>

/* Only what is open: a slot has over 100 KiB, and half of them are spare. */
int rt_lock_axis(const hil_core *c, int axis) { return mlock(&c->axes[axis], sizeof c->axes[axis]) ? errno : 0; }

int rt_lock_group(const hil_core *c, int group) { return mlock(&c->groups[group], sizeof c->groups[group]) ? errno : 0; }
