/* Lanes for processors with vectors of four. */
#ifndef HIL_BATCH_AVX2_H
#define HIL_BATCH_AVX2_H

#include "lanes.h"

batch_run simple_batch_avx2, full_batch_avx2;

#endif
