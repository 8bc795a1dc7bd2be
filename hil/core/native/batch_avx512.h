/* Lanes for processors with vectors of eight. */
#ifndef HIL_BATCH_AVX512_H
#define HIL_BATCH_AVX512_H

#include "lanes.h"

batch_run simple_batch_avx512, full_batch_avx512;

#endif
