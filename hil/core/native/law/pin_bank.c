#include "pin_bank.h"

#include <stdlib.h>
#include <string.h>

#include "../core.h"
#include "../hil_core.h"
#include "smoothed_pin.h"

const pin_bank *pin_bank_view(const hil_axis *a)
{
    static const pin_bank none = {0};
    return a->law == &pin_bank_law ? a->own : &none;
}

static int level_of(const pin_bank *b, int pin)
{
    if (b->processor.is_running) return avr_level(&b->processor.chip, pin);
    return b->driven >> pin & 1 ? b->out.levels[pin] > 0 : b->outside[pin];
}

int pin_bank_levels(const pin_bank *b)
{
    int levels = 0;
    for (int pin = 0; pin < HIL_BANK_PINS; pin++) levels |= level_of(b, pin) << pin;
    return levels;
}

void pin_bank_plan(hil_axis *a)
{
    const pin_bank *b = a->own;
    if (b->processor.is_running) a->law_next_ns = bank_processor_next_ns(&b->processor);
    else a->law_next_ns = b->fall_ns < b->rise_ns ? b->fall_ns : b->rise_ns;
    a->is_telling = a->law_next_ns != HIL_FOREVER;
}

static void put(hil_core *c, pin_bank *b, int pin, int level, int64_t at_ns)
{
    outputs_set(c, &b->out, pin, level, at_ns);
    smoothed_look(b, at_ns);
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
    put(c, b, b->pin, 1, at_ns);
    b->fall_ns = at_ns + b->rows[b->row].high_ns;
    b->sent++;
    b->left--;
    b->row_left--;
    find_next(b, at_ns);
}

static int64_t step(hil_core *c, hil_axis *a, int64_t until_ns)
{
    pin_bank *b = a->own;
    if (b->processor.is_running) {
        int64_t work = bank_processor_run(c, a, until_ns);
        pin_bank_plan(a);
        return work;
    }
    for (int64_t edges = 0;; edges++) {
        int64_t at_ns = a->law_next_ns;
        if (b->fall_ns == at_ns) {
            put(c, b, b->pin, 0, at_ns);
            b->fall_ns = HIL_FOREVER;
            if (b->rise_ns == HIL_FOREVER) {
                end_train(b);
                core_post(c, (int)(a - c->axes), at_ns, HIL_EVENT_PULSES_ENDED, b->pin);
            }
        } else rise(c, b, at_ns);
        pin_bank_plan(a);
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
    if (b->fall_ns != HIL_FOREVER) put(c, b, b->pin, 0, now_ns);
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
    pin_bank_plan(a);
    return 0;
}

/* ---- levels ---- */

/* Of one that the board does not drive. */
static int level_of_input(const hil_axis *a, int pin)
{
    const pin_bank *b = a->own;
    return a->inputs.known >> pin & 1 ? b->outside[pin] : OUTPUT_OPEN;
}

void hil_bank_write(hil_core *c, int axis, int pin, int level)
{
    int64_t now_ns;
    hil_axis *a = core_axis_stirred(c, axis, &now_ns);
    pin_bank *b = a->own;
    if (level < 0) b->driven &= ~(1 << pin);
    else b->driven |= 1 << pin;
    put(c, b, pin, level < 0 ? level_of_input(a, pin) : level != 0, now_ns);
}

int hil_bank_read(const hil_core *c, int axis, int pin) { return level_of(pin_bank_view(&c->axes[axis]), pin); }

static void set_pin(hil_core *c, hil_axis *a, int pin, int level, int64_t at_ns)
{
    pin_bank *b = a->own;
    b->outside[pin] = level;
    if (b->processor.is_running) {
        bank_processor_pin(c, a, pin, at_ns);
        pin_bank_plan(a);
    } else if (!(b->driven >> pin & 1)) put(c, b, pin, level_of_input(a, pin), at_ns);
}

int pin_bank_fault(hil_core *c, hil_axis *a, int what, double value, int64_t now_ns)
{
    if (a->law != &pin_bank_law) return -1;
    pin_bank *b = a->own;
    bank_processor *p = &b->processor;
    int32_t pins = (int32_t)value, low = p->stuck & ~p->stuck_high;
    switch (what) {
    case HIL_FAULT_CLOCK_ERROR:
        if (value < -50 || value > 50) return -1;
        bank_processor_set_zero(p, now_ns);
        p->clock_error_pct = value;
        bank_processor_set_clock(p);
        break;
    case HIL_FAULT_STUCK_LOW:
        p->stuck = pins | p->stuck_high;
        break;
    default:
        p->stuck_high = pins;
        p->stuck = pins | low;
        break;
    }
    if (p->is_running)
        for (int pin = 0; pin < HIL_BANK_PINS; pin++) bank_processor_pin(c, a, pin, now_ns);
    pin_bank_plan(a);
    return 0;
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
    bank_processor_open(&b->processor);
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
    bank_processor_power_up(a, &b->processor);
    b->driven = 0;
    b->sent = 0;
    for (int pin = 0; pin < HIL_BANK_PINS; pin++) put(c, b, pin, level_of_input(a, pin), now_ns);
    pin_bank_plan(a);
}

static void drive(hil_axis *a) { (void)a; }

static int set(hil_axis *a, hil_field field, double value, int64_t now_ns)
{
    pin_bank *b = a->own;
    bank_processor *p = &b->processor;
    if (field >= HIL_FIELD_a0_V && field <= HIL_FIELD_a7_V) {
        p->analog[field - HIL_FIELD_a0_V].volts = value;
        return 0;
    }
    if (field != HIL_FIELD_vcc_V) return -1;
    bank_processor_supply(p, value, p->aref_V == p->vcc_V ? value : p->aref_V); /* a reference of its own stays */
    smoothed_look(b, now_ns);
    return 0;
}

static outputs *outputs_of(hil_axis *a)
{
    pin_bank *b = a->own;
    return &b->out;
}

static void look(hil_axis *a, int64_t now_ns)
{
    pin_bank *b = a->own;
    if (b->processor.is_running) bank_processor_look(a, now_ns);
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
    .look = look,
};
