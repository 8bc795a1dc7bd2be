/* Many groups at a time: axes of a kind move together, one in each lane of a vector. */
#ifndef HIL_CORE_BATCH_H
#define HIL_CORE_BATCH_H

#include "state.h"

hil_lanes batch_widest(void); /* of those that this processor has */

#define BATCH_GROUPS 64 /* so many are kept from the loop thread at a time: some tens of us */

/* As hil_group_advance for each of up to BATCH_GROUPS groups, all of them the caller's. What they do is the
   same, bit for bit. */
void batch_advance(hil_core *c, const int *groups, int n, int64_t until_ns);

#endif
