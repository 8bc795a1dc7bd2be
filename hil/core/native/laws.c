#include "laws.h"

#include "law/a3967.h"
#include "law/pin_bank.h"
#include "law/servo.h"
#include "law/stepper.h"
#include "law/walter.h"

const law *const laws[HIL_LAWS] = {
#define LAW(name, value, python, meaning) [value] = &python##_law,
#include "abi.def"
};
