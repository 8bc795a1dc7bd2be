/* A board without a motor: its axis does nothing, and has cells for fields of the board's own. */
#ifndef HIL_LAW_OWN_FIELDS_H
#define HIL_LAW_OWN_FIELDS_H

#include "../law.h"

extern const law own_fields_law;

#endif
