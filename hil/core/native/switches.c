#include "switches.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "core.h"
#include "hil_core.h"
#include "law.h"
#include "pins.h"
#include "view.h"

/* Toggles of a contact that bounces, after the first closing or opening: an even number, so that it ends as it began. */
enum { LEAST_PAIRS = 1, MORE_PAIRS = 3, MOST_TOGGLES = 2 * (LEAST_PAIRS + MORE_PAIRS) };

typedef struct contact {
    hil_switch is;
    double from_rev, to_rev, slack_rev, every_rev;
    double shift_rev; /* the fault: it sits so much farther up */
    int held;         /* the fault: HIL_CONTACT_OPEN, HIL_CONTACT_CLOSED, or 0 */
    int told_level;   /* of its pin; -1: not yet */
    atomic_int seen;  /* as active by what reads the contact; other threads look at it */
    int is_inside; /* the cam holds it */
    int is_active; /* as is_inside, but for bounces */
    uint64_t changes; /* of is_inside since the start: each draws its own bounce */
    int64_t toggles_ns[MOST_TOGGLES];
    int toggle, n_toggles;
} contact;

struct switch_list {
    int n, rests; /* rests: the shaft rested at the last look, too */
    contact contacts[HIL_SWITCHES];
};

static double uniform(uint64_t key) { return (double)(full_hash(key) >> 11) * 0x1p-53; }

/* The angle with whole turns of a cam that repeats taken off, so that it is nearest to the cam's middle. */
static double nearest_rev(const contact *x, double rev)
{
    rev -= x->shift_rev;
    if (!(x->every_rev > 0)) return rev;
    double turns = (rev - 0.5 * (x->from_rev + x->to_rev)) / x->every_rev;
    return rev - x->every_rev * nearbyint(turns);
}

static int is_held(const contact *x, double rev)
{
    double slack = x->is_inside ? x->slack_rev : 0, at = nearest_rev(x, rev);
    return at >= x->from_rev - slack && at <= x->to_rev + slack;
}

/* How far it is to the next edge in the direction of motion; INFINITY: there is none. */
static double ahead_rev(const contact *x, double rev, int is_up)
{
    double at = nearest_rev(x, rev), to_go;
    if (x->is_inside) to_go = is_up ? x->to_rev + x->slack_rev - at : at - (x->from_rev - x->slack_rev);
    else to_go = is_up ? x->from_rev - at : at - x->to_rev;
    if (to_go < 0 && x->every_rev > 0) to_go += x->every_rev;
    return to_go < 0 ? INFINITY : to_go;
}

/* What the contact does now, to its pin and to a drive's card. */
static void tell(hil_core *c, contact *x, int64_t at_ns)
{
    int is_closed = x->held ? x->held == HIL_CONTACT_CLOSED : x->is_active == !x->is.opens;
    int level = is_closed ? x->is.closed_level : !x->is.closed_level;
    atomic_store_explicit(&x->seen, is_closed == !x->is.opens, memory_order_relaxed);
    if (x->is.to_axis >= 0 && level != x->told_level) pins_set(c, x->is.to_axis, x->is.to_pin, x->told_level = level, at_ns);
}

/* A bounce of its own for each change: so many toggles within half of the longest time up to all of it. */
static void begin_bounce(contact *x, int64_t at_ns)
{
    uint64_t key = full_hash(x->is.seed + x->changes);
    double gaps[MOST_TOGGLES + 1], sum = 0, so_far = 0;
    double length_ns = (double)x->is.bounce_ns * (0.5 + 0.5 * uniform(key));
    x->toggle = x->n_toggles = 0;
    if (x->is.bounce_ns <= 0) return;
    int n = 2 * (LEAST_PAIRS + (int)(uniform(key + 1) * (MORE_PAIRS + 1)));
    if (n > MOST_TOGGLES) n = MOST_TOGGLES;
    for (int i = 0; i <= n; i++) sum += gaps[i] = 0.05 + uniform(key + 2 + (uint64_t)i);
    for (int i = 0; i < n; i++) {
        so_far += gaps[i];
        x->toggles_ns[i] = at_ns + 1 + i + (int64_t)(length_ns * so_far / sum);
    }
    x->n_toggles = n;
}

static void turn(hil_core *c, contact *x, int64_t at_ns)
{
    x->is_inside = !x->is_inside;
    x->changes++;
    begin_bounce(x, at_ns);
    if (x->is_active == x->is_inside) return;
    x->is_active = x->is_inside;
    tell(c, x, at_ns);
}

static int64_t earlier(int64_t a, int64_t b) { return a < b ? a : b; }

static int64_t next_look_ns(const switch_list *s, int64_t at_ns, double rev, double rev_per_s)
{
    int64_t next_ns = (at_ns / SWITCH_LOOK_NS + 1) * SWITCH_LOOK_NS;
    for (int i = 0; i < s->n && rev_per_s != 0; i++) {
        double in_ns = ceil(ahead_rev(&s->contacts[i], rev, rev_per_s > 0) / fabs(rev_per_s) * 1e9);
        if (in_ns < (double)(next_ns - at_ns)) next_ns = at_ns + (int64_t)fmax(in_ns, SWITCH_LEAST_NS);
    }
    return next_ns;
}

static int is_at_rest(const hil_axis *a) { return (a->is_full ? a->full.at_rest : a->plant.at_rest) && !a->is_turned; }

void switches_look(hil_core *c, hil_axis *a)
{
    switch_list *s = a->switches;
    int64_t at_ns = a->switch_next_ns, next_ns = (at_ns / SWITCH_LOOK_NS + 1) * SWITCH_LOOK_NS;
    int rests = is_at_rest(a) && !a->law->show;
    if (!(rests && s->rests)) {
        double rev, rev_per_s;
        view_shaft(a, at_ns, &rev, &rev_per_s);
        for (int i = 0; i < s->n; i++)
            if (is_held(&s->contacts[i], rev) != s->contacts[i].is_inside) turn(c, &s->contacts[i], at_ns);
        next_ns = next_look_ns(s, at_ns, rev, rev_per_s);
    }
    s->rests = rests;
    for (int i = 0; i < s->n; i++) {
        contact *x = &s->contacts[i];
        for (; x->toggle < x->n_toggles && x->toggles_ns[x->toggle] <= at_ns; x->toggle++) {
            x->is_active = !x->is_active;
            tell(c, x, at_ns);
        }
        if (x->toggle < x->n_toggles) next_ns = earlier(next_ns, x->toggles_ns[x->toggle]);
    }
    a->switch_next_ns = next_ns;
}

int hil_switch_add(hil_core *c, int axis, const hil_switch *given)
{
    int64_t now_ns;
    double rev, rev_per_s;
    hil_axis *a = core_axis_stirred(c, axis, &now_ns);
    if (!a->switches && !(a->switches = calloc(1, sizeof *a->switches))) return -1;
    switch_list *s = a->switches;
    if (s->n == HIL_SWITCHES) return -1;
    contact *x = &s->contacts[s->n++];
    *x = (contact){.is = *given, .told_level = -1, .from_rev = given->from_deg / 360, .to_rev = given->to_deg / 360,
                   .slack_rev = given->hysteresis_deg / 360, .every_rev = given->every_deg / 360};
    view_shaft(a, now_ns, &rev, &rev_per_s);
    x->is_inside = x->is_active = is_held(x, rev);
    s->rests = 0;
    a->switch_next_ns = now_ns + 1;
    view_plan(a);
    core_join(c, axis);
    if (given->to_axis >= 0) core_join(c, given->to_axis);
    tell(c, x, now_ns);
    return s->n - 1;
}

int hil_switch_fault(hil_core *c, int axis, int which, int held, double shift_deg)
{
    int64_t now_ns;
    hil_axis *a = core_axis_stirred(c, axis, &now_ns);
    switch_list *s = a->switches;
    if (!s || which < 0 || which >= s->n || held < 0 || held > HIL_CONTACT_CLOSED || !isfinite(shift_deg)) return -1;
    contact *x = &s->contacts[which];
    x->shift_rev = shift_deg / 360;
    x->held = held;
    tell(c, x, now_ns);
    s->rests = 0;
    if (a->switch_next_ns > now_ns + 1) a->switch_next_ns = now_ns + 1;
    view_plan(a);
    return 0;
}

int hil_switch_is_active(const hil_core *c, int axis, int which)
{
    const switch_list *s = c->axes[axis].switches;
    return s && which < s->n && atomic_load_explicit(&s->contacts[which].seen, memory_order_relaxed);
}

void switches_close(hil_axis *a)
{
    free(a->switches);
    a->switches = NULL;
}
