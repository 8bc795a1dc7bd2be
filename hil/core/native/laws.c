#include "laws.h"

const law *const laws[HIL_LAWS] = {
#define LAW(name, value, python, meaning) [value] = &python##_law,
#include "abi.def"
};
