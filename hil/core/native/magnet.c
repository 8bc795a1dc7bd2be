/* Magnets of encoders on shafts of other axes. */
#include "core.h"
#include "hil_core.h"
#include "law/as5047d.h"

int hil_magnet(hil_core *c, int axis, int of_axis, int is_reversed, double zero_deg)
{
    int64_t now_ns;
    hil_axis *a = core_axis_stirred(c, axis, &now_ns);
    if (a->law != &as5047d_law) return -1;
    core_join(c, axis);
    core_join(c, of_axis);
    as5047d_place(a, of_axis - axis, is_reversed ? -1 : 1, zero_deg / 360, now_ns);
    return 0;
}
