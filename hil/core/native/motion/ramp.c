#include "ramp.h"

#include <math.h>

enum { NO_RAMP = 99900 };
static const double PI = 3.14159265358979323846;

static int is_none(int64_t acc_hundredths) { return acc_hundredths <= 0 || acc_hundredths >= NO_RAMP; }

int64_t ramp_harmonic_steps(int64_t from_rpm, int64_t to_rpm, int64_t acc_hundredths)
{
    if (is_none(acc_hundredths)) return 0;
    int64_t change = to_rpm > from_rpm ? to_rpm - from_rpm : from_rpm - to_rpm;
    return 100 * change / acc_hundredths;
}

/* V^2 / (2 alpha acc), with alpha = 2 pi / steps_per_rev; the order of the operations is part of the result. */
int64_t ramp_linear_steps(int64_t rpm, int64_t acc_hundredths, int64_t steps_per_rev)
{
    if (is_none(acc_hundredths)) return 0;
    double v = (double)rpm * 2 * PI / 60, alpha = 2 * PI / (double)steps_per_rev;
    double steps = v * v / (2 * alpha * ((double)acc_hundredths / 100));
    return steps < 0x1p62 ? (int64_t)steps : INT64_C(1) << 62;
}

void ramp_harmonic(ramp *r, int64_t f, int64_t start_v100, int64_t slope100)
{
    r->is_linear = 0;
    r->list = 0;
    r->f100 = f * 100;
    r->v100 = start_v100;
    r->slope100 = slope100;
}

void ramp_linear_from_stop(ramp *r, int64_t acc_hundredths, int64_t steps_per_rev)
{
    double alpha = 2 * PI / (double)steps_per_rev;
    r->is_linear = 1;
    r->list = 0;
    r->c = 0.676 * 1000000 * sqrt(2 * alpha / ((double)acc_hundredths / 100));
    r->n = 0;
}

void ramp_linear_from(ramp *r, int64_t first_us, int64_t n1)
{
    r->is_linear = 1;
    r->list = 0;
    r->c = (double)first_us;
    r->n = n1;
}

static double after(double c, int64_t n) { return c - 2 * c / (double)(4 * n + 1); }

/* c_n is proportional to Gamma(n + 3/4) / Gamma(n + 5/4) = (1 - 1 / (64 w^2) + ...) / sqrt(w), w = n + 1/2. */
static double scaled(double c, double w, double to_w)
{
    return c * sqrt(w / to_w) * ((1 - 1 / (64 * to_w * to_w)) / (1 - 1 / (64 * w * w)));
}

void ramp_reverse(ramp *r, int64_t length, ramp_list *list)
{
    int64_t exact = length < RAMP_EXACT ? length : RAMP_EXACT, n = r->n;
    r->list = list;
    r->index = length;
    list->spacing = exact / RAMP_MARKS + 1;
    list->window = exact;
    double c = r->c;
    for (int64_t i = 0, mark = 0; i < exact; i++) {
        if (i == mark * list->spacing) list->marks[mark++] = c;
        c = after(c, ++n);
    }
    list->far_c = c;
    list->far_w = (double)n + 0.5;
}

static double reversed_value(ramp *r)
{
    ramp_list *list = r->list;
    int64_t at = --r->index;
    if (at >= RAMP_EXACT) return scaled(list->far_c, list->far_w, (double)(r->n + at) + 0.5);
    if (at < list->window) {
        int64_t mark = at / list->spacing, i = mark * list->spacing;
        list->window = at - RAMP_MARKS + 1 > i ? at - RAMP_MARKS + 1 : i;
        double c = list->marks[mark];
        for (int64_t n = r->n + i; i <= at; i++) {
            if (i >= list->window) list->values[i - list->window] = c;
            c = after(c, ++n);
        }
    }
    return list->values[at - list->window];
}

int64_t ramp_next_us(ramp *r)
{
    if (!r->is_linear) {
        int64_t period_us = r->f100 / (r->v100 > 0 ? r->v100 : 1);
        r->v100 += r->slope100;
        return period_us;
    }
    if (r->list) return (int64_t)reversed_value(r);
    int64_t period_us = (int64_t)r->c;
    r->c = after(r->c, ++r->n);
    return period_us;
}
