/* batch_lanes.h for any processor. */
#include "batch_any.h"

#define REAL_LANES 4
#define TARGET
#define SIMPLE_BATCH simple_batch_any
#define FULL_BATCH full_batch_any
#include "batch_lanes.h"
