/* batch_lanes.h for what most processors have: vectors of four. Not with fused multiply-add, which rounds
   differently. */
#ifdef __x86_64__
#include "batch_avx2.h"

#ifndef __clang__
#pragma GCC target("avx2")
#endif
#define REAL_LANES 4
#define TARGET __attribute__((target("avx2")))
#define SIMPLE_BATCH simple_batch_avx2
#define FULL_BATCH full_batch_avx2
#include "batch_lanes.h"
#endif
