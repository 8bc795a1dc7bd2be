/* batch_lanes.h for processors with AVX-512: vectors of eight. Not with fused multiply-add, which rounds
   differently. */
#ifdef __x86_64__
#include "batch_avx512.h"

#ifndef __clang__
#pragma GCC target("avx512f,avx512dq,avx512vl,avx512bw")
#endif
#define REAL_LANES 8
#define TARGET __attribute__((target("avx512f,avx512dq,avx512vl,avx512bw")))
#define SIMPLE_BATCH simple_batch_avx512
#define FULL_BATCH full_batch_avx512
#include "batch_lanes.h"
#endif
