/* Lanes for any processor. */
#ifndef HIL_BATCH_ANY_H
#define HIL_BATCH_ANY_H

#include "lanes.h"

batch_run simple_batch_any, full_batch_any;

#endif
