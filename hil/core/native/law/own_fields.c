#include "own_fields.h"

static double max_current_A(const hil_axis_params *params)
{
    (void)params;
    return 0;
}

static void open_fields(hil_axis *a, const hil_axis_params *params) { (void)a, (void)params; }

static void close_fields(hil_axis *a) { (void)a; }

static void power_up(hil_core *c, hil_axis *a, int64_t now_ns) { (void)c, (void)a, (void)now_ns; }

static int64_t step(hil_core *c, hil_axis *a, int64_t until_ns)
{
    (void)c, (void)a, (void)until_ns; /* it does nothing by itself */
    return 0;
}

static void drive(hil_axis *a) { (void)a; }

static void set_pin(hil_core *c, hil_axis *a, int pin, int level, int64_t at_ns)
{
    (void)c, (void)a, (void)pin, (void)level, (void)at_ns; /* it has none */
}

static int set(hil_axis *a, hil_field field, double value, int64_t now_ns)
{
    (void)a, (void)field, (void)value, (void)now_ns; /* cells are the axis's */
    return -1;
}

const law own_fields_law = {
    .bytes = sizeof(int), /* of nothing: an arena's parts have a size */
    .kind = HIL_KIND_OWN_FIELDS,
    .events = 1,
    .max_current_A = max_current_A,
    .open = open_fields,
    .close = close_fields,
    .power_up = power_up,
    .step = step,
    .drive = drive,
    .pin = set_pin,
    .set = set,
    .is_passive = 1,
};
