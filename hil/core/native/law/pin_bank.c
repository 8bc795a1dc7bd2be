#include "pin_bank.h"

#include <stdlib.h>
#include <string.h>

#include "../core.h"
#include "../hil_core.h"

const pin_bank *pin_bank_view(const hil_axis *a)
{
    static const pin_bank none = {0};
    return a->law == &pin_bank_law ? a->own : &none;
}

static int level_of(const pin_bank *b, int pin) { return b->driven >> pin & 1 ? b->out.levels[pin] : b->outside[pin]; }

int pin_bank_levels(const pin_bank *b)
{
    int levels = 0;
    for (int pin = 0; pin < HIL_BANK_PINS; pin++) levels |= level_of(b, pin) << pin;
    return levels;
}

static void plan(hil_axis *a)
{
    const pin_bank *b = a->own;
    a->law_next_ns = b->fall_ns < b->rise_ns ? b->fall_ns : b->rise_ns;
    a->is_telling = a->law_next_ns != HIL_FOREVER;
}

/* ---- a train ---- */

static void enter_row(pin_bank *b)
{
    b->row_left = b->row < b->n_rows ? b->rows[b->row].pulses : 0;
}

/* When the pulse after one at at_ns rises; rows without pulses are no time. */
static void find_next(pin_bank *b, int64_t at_ns)
{
    while (b->row < b->n_rows && !b->row_left) {
        b->row++;
        enter_row(b);
    }
    b->rise_ns = b->row < b->n_rows ? at_ns + b->rows[b->row].period_ns : HIL_FOREVER;
}

/* Its memory stays: a thread in real time may be here. */
static void end_train(pin_bank *b)
{
    b->n_rows = b->row = 0;
    b->row_left = b->left = 0;
    b->rise_ns = b->fall_ns = HIL_FOREVER;
}

static void rise(hil_core *c, pin_bank *b, int64_t at_ns)
{
    outputs_set(c, &b->out, b->pin, 1, at_ns);
    b->fall_ns = at_ns + b->rows[b->row].high_ns;
    b->sent++;
    b->left--;
    b->row_left--;
    find_next(b, at_ns);
}

static int64_t step(hil_core *c, hil_axis *a, int64_t until_ns)
{
    pin_bank *b = a->own;
    for (int64_t edges = 0;; edges++) {
        int64_t at_ns = a->law_next_ns;
        if (b->fall_ns == at_ns) {
            outputs_set(c, &b->out, b->pin, 0, at_ns);
            b->fall_ns = HIL_FOREVER;
            if (b->rise_ns == HIL_FOREVER) {
                end_train(b);
                core_post(c, (int)(a - c->axes), at_ns, HIL_EVENT_PULSES_ENDED, b->pin);
            }
        } else rise(c, b, at_ns);
        plan(a);
        if (a->law_next_ns > until_ns || a->law_next_ns == HIL_FOREVER) return edges;
    }
}

static int64_t pulses_of(int n, const hil_pulses *rows)
{
    int64_t pulses = 0;
    for (int i = 0; i < n; i++) pulses += rows[i].pulses;
    return pulses;
}

int hil_bank_pulses(hil_core *c, int axis, int pin, int n, const hil_pulses *rows)
{
    int64_t now_ns, pulses = pulses_of(n, rows);
    hil_axis *a = core_axis_stirred(c, axis, &now_ns);
    pin_bank *b = a->own;
    hil_pulses *copy = pulses ? malloc((size_t)n * sizeof *copy) : NULL;
    if (pulses && !copy) return -1;
    if (b->fall_ns != HIL_FOREVER) outputs_set(c, &b->out, b->pin, 0, now_ns);
    end_train(b);
    free(b->rows);
    b->rows = copy;
    if (pulses) {
        memcpy(copy, rows, (size_t)n * sizeof *copy);
        b->n_rows = n;
        b->left = pulses;
        b->pin = pin;
        b->driven |= 1 << pin;
        enter_row(b);
        find_next(b, now_ns);
    }
    plan(a);
    return 0;
}

/* ---- levels ---- */

void hil_bank_write(hil_core *c, int axis, int pin, int level)
{
    int64_t now_ns;
    hil_axis *a = core_axis_stirred(c, axis, &now_ns);
    pin_bank *b = a->own;
    if (level < 0) b->driven &= ~(1 << pin);
    else b->driven |= 1 << pin;
    outputs_set(c, &b->out, pin, level < 0 ? b->outside[pin] : level != 0, now_ns);
}

int hil_bank_read(const hil_core *c, int axis, int pin) { return level_of(pin_bank_view(&c->axes[axis]), pin); }

static void set_pin(hil_core *c, hil_axis *a, int pin, int level, int64_t at_ns)
{
    pin_bank *b = a->own;
    b->outside[pin] = level;
    if (!(b->driven >> pin & 1)) outputs_set(c, &b->out, pin, level, at_ns);
}

/* ---- its life ---- */

static double max_current_A(const hil_axis_params *params)
{
    (void)params;
    return 0;
}

static void open_bank(hil_axis *a, const hil_axis_params *params)
{
    (void)params;
    pin_bank *b = a->own;
    b->rise_ns = b->fall_ns = HIL_FOREVER;
}

static void close_bank(hil_axis *a)
{
    pin_bank *b = a->own;
    free(b->rows);
    b->rows = NULL;
    outputs_close(&b->out);
}

/* All pins are inputs. */
static void power_up(hil_core *c, hil_axis *a, int64_t now_ns)
{
    pin_bank *b = a->own;
    end_train(b);
    b->driven = 0;
    b->sent = 0;
    for (int pin = 0; pin < HIL_BANK_PINS; pin++) outputs_set(c, &b->out, pin, b->outside[pin], now_ns);
    plan(a);
}

static void drive(hil_axis *a) { (void)a; }

static int set(hil_axis *a, hil_field field, double value, int64_t now_ns)
{
    (void)a, (void)field, (void)value, (void)now_ns;
    return -1;
}

static outputs *outputs_of(hil_axis *a)
{
    pin_bank *b = a->own;
    return &b->out;
}

const law pin_bank_law = {
    .bytes = sizeof(pin_bank),
    .kind = HIL_KIND_PIN_BANK,
    .events = 4, /* a train's end, and some that are begun and end while it waits to be taken */
    .max_current_A = max_current_A,
    .open = open_bank,
    .close = close_bank,
    .power_up = power_up,
    .step = step,
    .drive = drive,
    .pin = set_pin,
    .set = set,
    .outputs = outputs_of,
};
