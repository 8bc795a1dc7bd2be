/* What can be wrong with an axis, and an encoder that reads from a script instead of the shaft. */
#include <math.h>

#include "axis.h"
#include "core.h"
#include "hil_core.h"
#include "law.h"
#include "law/pin_bank.h"

int hil_axis_script_encoder(hil_core *c, int axis, int n, const int64_t *at_ns, const int64_t *raw, int linear)
{
    return encoder_script(&c->axes[axis].encoder, n, at_ns, raw, linear);
}

double hil_axis_supply_V(const hil_core *c, int axis)
{
    const hil_axis *a = &c->axes[axis];
    return a->is_full ? a->full.motor.supply_V : 0;
}

/* The encoder's count, whether or not its line is open. */
static int count_without_line(hil_axis *a, int64_t t_ns)
{
    int is_open = a->fault.is_line_open;
    a->fault.is_line_open = 0;
    int raw = law_raw(a, t_ns);
    a->fault.is_line_open = is_open;
    return raw;
}

int hil_axis_fault(hil_core *c, int axis, int what, double value)
{
    int64_t now_ns;
    hil_axis *a = core_axis_stirred(c, axis, &now_ns);
    axis_fault *f = &a->fault;
    if (!isfinite(value)) return -1;
    axis_node(a, now_ns);
    switch (what) {
    case HIL_FAULT_JAM:
        f->is_jammed = value != 0;
        if (a->is_full) full_jam(&a->full, f->is_jammed);
        else plant_jam(&a->plant, f->is_jammed);
        break;
    case HIL_FAULT_OPEN_A: f->is_open_a = value != 0; break;
    case HIL_FAULT_OPEN_B: f->is_open_b = value != 0; break;
    case HIL_FAULT_SWAPPED_A: f->is_swapped_a = value != 0; break;
    case HIL_FAULT_SWAPPED_B: f->is_swapped_b = value != 0; break;
    case HIL_FAULT_SLIP: f->slip_counts = (int32_t)fmin(fmax(value, -16383), 16383); break;
    case HIL_FAULT_NOISE: f->noise_counts = fmin(fmax(value, 0), 16384); break;
    case HIL_FAULT_NOISE_SEED: f->noise_key = full_hash((uint64_t)fmin(fmax(value, 0), 0x1p53)); break;
    case HIL_FAULT_SUPPLY:
        if (!a->is_full || value < 0) return -1;
        a->full.motor.supply_V = value;
        break;
    case HIL_FAULT_SHIFT:
        if (fabs(value) > 1e6) return -1;
        if (f->is_jammed) break;
        if (a->is_full) a->full.moving.state.rev += value;
        else a->plant.moving.rev += value;
        if (a->is_full) full_locate(&a->full.moving);
        break;
    case HIL_FAULT_LOAD:
        f->load_Nm = value;
        shaft_set_load(a);
        break;
    case HIL_FAULT_FREEZE:
        if (value != 0 && !f->is_frozen) f->frozen_raw = count_without_line(a, now_ns);
        f->is_frozen = value != 0;
        break;
    case HIL_FAULT_OPEN_LINE: f->is_line_open = value != 0; break;
    case HIL_FAULT_SILENT: f->silent_rate = fmin(fmax(value, 0), 1); break;
    case HIL_FAULT_CLOCK_ERROR:
    case HIL_FAULT_STUCK_LOW:
    case HIL_FAULT_STUCK_HIGH: return pin_bank_fault(c, a, what, value, now_ns);
    default: return -1;
    }
    shaft_sum_faults(a);
    a->law->drive(a);
    return 0;
}
