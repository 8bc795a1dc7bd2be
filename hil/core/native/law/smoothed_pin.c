#include "smoothed_pin.h"

#include <math.h>

#include "../core.h"

double smoothed_mean_V(const pin_bank *b, int pin)
{
    const bank_processor *p = &b->processor;
    if (p->stuck >> pin & 1) return p->vcc_V * (p->stuck_high >> pin & 1);
    if (!p->is_running) return p->vcc_V * (b->out.levels[pin] > 0);
    enum avr_drive drive = avr_driven(&p->chip, pin);
    double duty = drive == AVR_LOW || drive == AVR_HIGH ? avr_duty(&p->chip, pin) : -1;
    return p->vcc_V * (duty < 0 ? avr_level(&p->chip, pin) : duty);
}

static double decayed(double to_V, double from_V, double rc_s, int64_t ns) { return to_V + (from_V - to_V) * exp(-1e-9 * (double)ns / rc_s); }

static double output_V(const smoothed_pin *s, int64_t at_ns)
{
    if (at_ns >= s->from_ns) return decayed(s->to_V, s->from_V, s->rc_s, at_ns - s->from_ns);
    int64_t before_ns = at_ns > s->before_ns ? at_ns - s->before_ns : 0;
    return decayed(s->before_to_V, s->before_from_V, s->rc_s, before_ns);
}

int smoothed_add(pin_bank *b, int pin, double rc_s, int64_t now_ns)
{
    for (int i = 0; i < b->n_smoothed; i++)
        if (b->smoothed[i].pin == pin && b->smoothed[i].rc_s == rc_s) return i;
    if (b->n_smoothed == MOST_SMOOTHED) return -1;
    double volts = smoothed_mean_V(b, pin);
    b->smoothed[b->n_smoothed] = (smoothed_pin){pin, rc_s, volts, volts, now_ns, volts, volts, now_ns};
    return b->n_smoothed++;
}

void smoothed_look(pin_bank *b, int64_t at_ns)
{
    for (int i = 0; i < b->n_smoothed; i++) {
        smoothed_pin *s = &b->smoothed[i];
        double to_V = smoothed_mean_V(b, s->pin);
        if (to_V == s->to_V) continue;
        double from_V = output_V(s, at_ns);
        *s = (smoothed_pin){s->pin, s->rc_s, to_V, from_V, at_ns, s->to_V, s->from_V, s->from_ns};
    }
}

double smoothed_V(hil_core *c, int axis, hil_field number, int64_t at_ns)
{
    const pin_bank *b = c->axes[axis].own;
    return output_V(&b->smoothed[number], at_ns);
}
