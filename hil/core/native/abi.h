/* Constants and enumerations that C and Python both know: abi.def as C. */
#ifndef HIL_ABI_H
#define HIL_ABI_H

enum {
#define NUMBER(name, value, meaning) name = value,
#include "abi.def"
};

/* Control laws, by the names that profiles give them. */
typedef enum hil_law {
#define LAW(name, value, python, meaning) HIL_LAW_##name = value,
#include "abi.def"
    HIL_LAWS /* after the last, which is the largest */
} hil_law;

/* How axes move together. */
typedef enum hil_lanes {
#define LANES_OF(name, value, python, meaning) HIL_LANES_##name = value,
#include "abi.def"
    HIL_LANES_MOST /* after the last, which is the widest */
} hil_lanes;

/* Kinds of axis that have a field. */
enum {
#define KIND(name, value, python, meaning) HIL_KIND_##name = value,
#include "abi.def"
};

typedef enum hil_event_kind {
#define EVENT(name, value, python, meaning) HIL_EVENT_##name = value,
#include "abi.def"
} hil_event_kind;

enum {
#define MEMORY(name, value, python, meaning) HIL_MEMORY_##name = value,
#include "abi.def"
};

enum {
#define FAULT(name, value, python, meaning) HIL_FAULT_##name = value,
#include "abi.def"
};

/* Pins: inputs of a servo, a stepper and a driver, those of a microcontroller and of a chip on SPI, and a stepper's outputs. */
enum {
#define SERVO_INPUT(name, value, python, meaning) HIL_SERVO_IN_##name = value,
#include "abi.def"
};
enum {
#define STEPPER_INPUT(name, value, python, meaning) HIL_IN_##name = value,
#include "abi.def"
};
enum {
#define DRIVER_INPUT(name, value, python, meaning) HIL_DRIVER_IN_##name = value,
#include "abi.def"
    HIL_DRIVER_INPUTS /* after the last, which is the largest */
};
enum {
#define BANK_PIN(name, value, python, meaning) HIL_PIN_##name = value,
#include "abi.def"
    HIL_BANK_PINS /* after the last, which is the largest; there are less */
};
enum {
#define SPI_INPUT(name, value, python, meaning) HIL_SPI_IN_##name = value,
#include "abi.def"
    HIL_SPI_INPUTS /* after the last, which is the largest */
};
enum {
#define SPI_OUTPUT(name, value, python, meaning) HIL_SPI_OUT_##name = value,
#include "abi.def"
};
enum {
#define OUTPUT(name, value, python, meaning) HIL_OUT_##name = value,
#include "abi.def"
    HIL_OUTPUTS /* after the last, which is the largest */
};

/* Of a motion engine. */
enum {
#define STATE(name, value, python, meaning) MOTION_##name = value,
#include "abi.def"
};
typedef enum hil_motion_call {
#define CALL(name, value, python, meaning) HIL_MOTION_##name = value,
#include "abi.def"
} hil_motion_call;

/* Of a servo's firmware (law/servo.c). */
typedef enum hil_servo_call {
#define SERVO_CALL(name, value, python, meaning) HIL_SERVO_CALL_##name = value,
#include "abi.def"
} hil_servo_call;

/* Of the board of a joint (law/walter.c), which tells them apart by their order: the loop's, a joint's, of its motion, of its bus. */
typedef enum hil_walter_call {
#define WALTER_CALL(name, value, python, meaning) HIL_WALTER_##name = value,
#include "abi.def"
} hil_walter_call;

#endif
