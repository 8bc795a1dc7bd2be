/* All control laws, by their numbers in abi.def. */
#ifndef HIL_LAWS_H
#define HIL_LAWS_H

#include "law/a3967.h"
#include "law/as5047d.h"
#include "law/own_fields.h"
#include "law/pin_bank.h"
#include "law/servo.h"
#include "law/smoothed_pin.h"
#include "law/stepper.h"
#include "law/walter.h"

extern const law *const laws[HIL_LAWS];

#endif
