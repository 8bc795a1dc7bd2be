/* A control law as an axis holds it: by pointer, with memory of its own. laws.h has all of them.

   What it does by itself it says in its axis: when next, and the flags beside that (state.h). */
#ifndef HIL_LAW_H
#define HIL_LAW_H

#include "outputs.h"
#include "shaft.h"

struct law {
    size_t bytes; /* of its memory, which is locked with the axis */
    int kind;     /* HIL_KIND_*: of its fields */
    int32_t pulled_up; /* inputs that are high where nothing drives them, a bit each; others are low */
    int events;   /* room in the ring of its group */
    double (*max_current_A)(const hil_axis_params *params); /* of a coil */
    void (*open)(hil_axis *a, const hil_axis_params *params); /* its memory is all zeros, its axis has its plant */
    void (*close)(hil_axis *a);                               /* gives back what it has taken since */
    void (*power_up)(hil_core *c, hil_axis *a, int64_t now_ns);
    /* Does all that is due up to and at until_ns, which is not before law_next_ns. Returns the number of
       things done, less one. */
    int64_t (*step)(hil_core *c, hil_axis *a, int64_t until_ns);
    int64_t (*tells_ns)(const hil_axis *a); /* it posts no event of its own before. NULL: before its next step */
    void (*drive)(hil_axis *a); /* at a node: the currents that it has told before, as a fault has begun or ended */
    void (*turn)(hil_axis *a); /* at a node, when is_turned: the currents of now. NULL: it never is */
    void (*pin)(hil_core *c, hil_axis *a, int pin, int level, int64_t at_ns); /* a level, which may be as it was */
    int (*set)(hil_axis *a, hil_field field, double value, int64_t now_ns); /* -1: no field that it can set */
    /* A call of its own (abi.def). NULL: there is none. */
    double (*act)(hil_core *c, hil_axis *a, int call, double x, double y, double z);
    void (*show)(hil_axis *a); /* into its view, after the plant has filled it. NULL: the plant shows all */
    outputs *(*outputs)(hil_axis *a); /* NULL: it has none */
    int (*count)(hil_axis *a, int64_t t_ns); /* what its encoder reads of another axis's shaft. NULL: it reads its own axis's */
    void (*warm)(hil_axis *a, int64_t at_ns); /* a look at its driver's heat, at heat_next_ns. NULL: it asks for none */
    int is_passive; /* its outputs change at edges of its inputs, and at nothing else */
    void (*look)(hil_axis *a, int64_t now_ns); /* called before and after the watchers of its outputs change. NULL: need not know */
};

/* The plant's whole steps up to t_ns. Currents that a law has turned change at the plant's own nodes, the first one
   after: what a pulse costs does not depend on the plant, and the plant's motion not on who looked when.
   docs/decisions/0010-motion-engine.md */
static inline void law_plant(hil_axis *a, int64_t t_ns)
{
    if (a->is_turned) {
        int64_t node_ns = shaft_next_node_ns(a);
        if (node_ns > t_ns) return;
        shaft_run(a, node_ns);
        a->law->turn(a);
        a->is_turned = 0;
    }
    shaft_run(a, t_ns);
}

/* What its encoder reads, of whichever shaft. */
static inline int law_raw(hil_axis *a, int64_t t_ns)
{
    int raw = a->law->count ? shaft_blind_raw(a, t_ns) : shaft_raw(a, t_ns);
    return a->law->count && raw < 0 ? a->law->count(a, t_ns) : raw;
}

/* Where the memory of an axis's law is, whichever it has. */
static inline void *law_place(const hil_core *c, hil_law law, int axis)
{
    return c->laws[law].first + c->laws[law].stride * (size_t)axis;
}

#endif
