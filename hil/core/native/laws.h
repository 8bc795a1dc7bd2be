/* All control laws, by their numbers in abi.def. */
#ifndef HIL_LAWS_H
#define HIL_LAWS_H

#include "law.h"

extern const law *const laws[HIL_LAWS];

#endif
