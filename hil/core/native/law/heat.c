#include "heat.h"

#include "../types.h"

#define LEVEL 12 /* times its time of warming up: a millidegree is left of the way */

void heat_open(heat *h, const heat_limits *limits, double ambient_degC)
{
    *h = (heat){.limits = limits, .ambient_degC = ambient_degC, .junction_degC = ambient_degC, .at_ns = HIL_FOREVER};
}

void heat_begin(heat *h, int64_t now_ns)
{
    if (h->at_ns == HIL_FOREVER) h->at_ns = now_ns;
}

/* exp(-x) of plain operations: the same bits on every machine. */
static double decay(double x)
{
    if (x > 40) return 0;
    int halved = 0;
    for (; x > 0.25; halved++) x *= 0.5;
    double left = (12 - 6 * x + x * x) / (12 + 6 * x + x * x);
    for (; halved; halved--) left *= left;
    return left;
}

static double settled_degC(const heat *h) { return h->ambient_degC + h->limits->K_per_W * h->power_W; }

double heat_degC(const heat *h, int64_t now_ns)
{
    if (!h->limits) return 0;
    double settled = settled_degC(h);
    return settled + (h->junction_degC - settled) * decay((double)(now_ns - h->at_ns) * 1e-9 / h->limits->warming_s);
}

void heat_to(heat *h, int64_t now_ns)
{
    h->junction_degC = heat_degC(h, now_ns);
    h->at_ns = now_ns;
    if (!h->is_too_hot && h->junction_degC > h->limits->hot_degC) {
        h->is_too_hot = 1;
        h->trips++;
        h->hot_at_ns = now_ns;
    }
    if (h->is_too_hot && h->junction_degC < h->limits->cool_degC) {
        h->is_too_hot = 0;
        h->cool_at_ns = now_ns;
    }
}

int heat_is_level(const heat *h, int64_t now_ns)
{
    return !h->limits || (double)(now_ns - h->at_ns) > LEVEL * 1e9 * h->limits->warming_s;
}

int heat_is_on_its_way(const heat *h) { return h->is_too_hot || settled_degC(h) > h->limits->hot_degC; }
