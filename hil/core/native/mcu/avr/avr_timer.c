#include "avr_timer.h"

#include "avr_crystal.h"
#include "avr_interrupt.h"
#include "avr_pins.h"
#include "avr_registers.h"
#include "avr_time.h"
#include "avr_waveform.h"

/* Where a timer's registers and pins are. */
static const struct place {
    uint16_t control, flags, enables;
    uint8_t port[2], bit[2]; /* of OCA, OCB */
    uint8_t part, prescaler, gate; /* gate: its bit of PRR */
    uint16_t max;
} PLACES[3] = {
    {TCCR0A, TIFR0, TIMSK0, {AVR_PORT_D, AVR_PORT_D}, {1 << 6, 1 << 5}, AVR_PART_TIMER0, 0, PRTIM0, 0xff},
    {TCCR1A, TIFR1, TIMSK1, {AVR_PORT_B, AVR_PORT_B}, {1 << 1, 1 << 2}, AVR_PART_TIMER1, 0, PRTIM1, 0xffff},
    {TCCR2A, TIFR2, TIMSK2, {AVR_PORT_B, AVR_PORT_D}, {1 << 3, 1 << 3}, AVR_PART_TIMER2, 1, PRTIM2, 0xff},
};

static const avr_waveform *waveform(const avr *m, int n) { return avr_waveform_of(n == 1, m->timer[n].mode); }

static uint16_t top_of(const avr *m, int n)
{
    const avr_waveform *w = waveform(m, n);
    return w->top ? w->top : w->is_top_capture ? m->timer[n].capture : m->timer[n].compare[0];
}

/* COM bits of OCA or OCB; 0: the pin is the port's. Toggling in a PWM mode is for OCA, and for some modes. */
static int action_of(const avr *m, int n, int i)
{
    const avr_waveform *w = waveform(m, n);
    int com = m->data[PLACES[n].control] >> (i ? 4 : 6) & 3;
    return com == 1 && w->shape != AVR_PLAIN && !(i == 0 && w->is_toggling) ? 0 : com;
}

static void show(avr *m, int n, uint64_t at)
{
    for (int i = 0; i < 2; i++) avr_pins_own(m, PLACES[n].port[i], PLACES[n].bit[i], action_of(m, n, i) != 0, m->timer[n].latch[i]);
    avr_pins_refresh(m, PLACES[n].port[0], at);
    if (PLACES[n].port[1] != PLACES[n].port[0]) avr_pins_refresh(m, PLACES[n].port[1], at);
}

/* Toggle, clear or set; the last two turned round where `is_other`. */
static void act(avr *m, int n, int i, int is_other)
{
    int action = action_of(m, n, i);
    uint8_t *latch = &m->timer[n].latch[i];
    if (action == 1) *latch ^= 1;
    else if (action) *latch = (uint8_t)((action == 3) != is_other);
}

static void update(avr *m, avr_timer *u)
{
    if (u->compare[0] != u->buffer[0] || u->compare[1] != u->buffer[1]) avr_mean_changes(m);
    u->compare[0] = u->buffer[0];
    u->compare[1] = u->buffer[1];
}

/* At TOP of a phase correct mode the level must be that of an upward match, also where a new compare value
   was passed already: DS40002061, Phase Correct PWM Mode. */
static void mend_at_top(avr *m, int n, uint16_t top)
{
    for (int i = 0; i < 2; i++)
        if (action_of(m, n, i) > 1 && m->timer[n].compare[i] < top) act(m, n, i, 0);
}

static void set_captured(avr *m)
{
    if (!(m->data[TIFR1] & ICF1)) m->timer_flags |= AVR_CAPTURED;
    m->data[TIFR1] |= ICF1;
}

/* One tick: what leaving the count's value does. */
static void tick(avr *m, int n, uint64_t at)
{
    avr_timer *u = &m->timer[n];
    const avr_waveform *w = waveform(m, n);
    uint16_t v = u->count, top = top_of(m, n), max = PLACES[n].max;
    uint8_t *flags = &m->data[PLACES[n].flags], were = *flags, latches = (uint8_t)(u->latch[0] | u->latch[1] << 1);
    int is_blocked = u->is_blocked;
    int is_top = v == top && !(is_blocked && !w->top), is_bottom = 0;
    u->is_blocked = 0;
    if (w->is_dual) {
        is_bottom = v == 0 && !(is_blocked && u->is_down);
        if (is_top) u->is_down = 1;
        else if (is_bottom) u->is_down = 0;
        u->count = is_top && is_bottom ? 0 : (uint16_t)((u->is_down ? v - 1 : v + 1) & max);
    } else {
        u->count = is_top ? 0 : (uint16_t)((v + 1) & max);
    }
    for (int i = 0; i < 2; i++) {
        if (is_blocked || v != u->compare[i]) continue;
        *flags |= (uint8_t)(OCFA << i);
        act(m, n, i, w->is_dual && u->is_down);
    }
    if (w->shape == AVR_PLAIN ? v == max : w->is_dual ? is_bottom : is_top) *flags |= TOV;
    if (is_top && w->is_top_capture) set_captured(m);
    if (w->shape == AVR_FAST && u->count == 0)
        for (int i = 0; i < 2; i++)
            if (action_of(m, n, i) > 1) act(m, n, i, 1);
    if ((is_top && (w->shape == AVR_FAST || w->shape == AVR_PHASE)) || (is_bottom && w->shape == AVR_FREQUENCY)) update(m, u);
    if (is_top && w->is_dual) mend_at_top(m, n, top);
    if (latches != (u->latch[0] | u->latch[1] << 1)) {
        show(m, n, at);
        if (action_of(m, n, 0) == 1 || action_of(m, n, 1) == 1) avr_mean_changes(m); /* it toggles */
    }
    if (were != *flags) avr_ask(m);
    m->timer_flags |= (uint16_t)((*flags & ~were & (TOV | OCFA | OCFB)) << 4 * n);
}

/* Whether leaving a compare value is seen: by its flag, or at its pin. */
static int is_seen(const avr *m, int n, int i) { return !(m->data[PLACES[n].flags] & OCFA << i) || action_of(m, n, i); }

static void nearer(uint32_t *least, uint32_t ticks)
{
    if (ticks < *least) *least = ticks;
}

/* Ticks to the next that does more than count. */
static uint32_t ticks_ahead(const avr *m, int n)
{
    const avr_timer *u = &m->timer[n];
    const avr_waveform *w = waveform(m, n);
    uint32_t v = u->count, top = top_of(m, n), least;
    if (u->is_blocked) return 1;
    if (w->is_dual && (v == top || v == 0)) return 1;
    if (w->is_dual && u->is_down) {
        least = v + 1;
        for (int i = 0; i < 2; i++)
            if (u->compare[i] <= v && is_seen(m, n, i)) nearer(&least, v - u->compare[i] + 1);
        if (top <= v) nearer(&least, v - top + 1);
        return least;
    }
    least = PLACES[n].max - v + 1;
    if (top >= v) nearer(&least, top - v + 1);
    for (int i = 0; i < 2; i++)
        if (u->compare[i] >= v && is_seen(m, n, i)) nearer(&least, u->compare[i] - v + 1);
    return least;
}

static int is_by_crystal(const avr *m, int n) { return n == 2 && avr_is_asynchronous(m); }

/* Ticks since its prescaler was 0, and the clock of one. */
static uint64_t ticks_at(const avr *m, int n, uint64_t at)
{
    uint8_t shift = m->timer[n].shift;
    return (is_by_crystal(m, n) ? avr_crystal_edges(m, at) - m->crystal.prescaler : at - m->prescaler[PLACES[n].prescaler]) >> shift;
}

static uint64_t clock_of(const avr *m, int n, uint64_t tick)
{
    uint64_t edges = tick << m->timer[n].shift;
    return is_by_crystal(m, n) ? avr_crystal_clock(m, m->crystal.prescaler + edges) : m->prescaler[PLACES[n].prescaler] + edges;
}

static void schedule(avr *m, int n)
{
    const avr_timer *u = &m->timer[n];
    uint64_t due = AVR_NEVER, update;
    if (u->is_ticking) due = clock_of(m, n, ticks_at(m, n, u->told) + ticks_ahead(m, n));
    if (n == 1 && u->capture_due < due) due = u->capture_due;
    if (is_by_crystal(m, n) && avr_crystal_next(m, &update) && update < due) due = update;
    avr_due(m, (enum avr_part)PLACES[n].part, due);
}

static void count_to(avr *m, int n, uint64_t at)
{
    avr_timer *u = &m->timer[n];
    if (!is_by_crystal(m, n) || m->is_crystal_frozen) at = avr_io_clock(m, at);
    if (at <= u->told) return; /* also while the crystal starts up: told is at its end then */
    if (u->is_ticking) {
        uint64_t done = ticks_at(m, n, u->told), all = ticks_at(m, n, at);
        while (done < all) {
            uint32_t ahead = ticks_ahead(m, n), left = all - done > UINT32_MAX ? UINT32_MAX : (uint32_t)(all - done);
            uint32_t plain = left < ahead ? left : ahead - 1;
            u->count = (uint16_t)(u->count + (waveform(m, n)->is_dual && u->is_down ? -plain : plain));
            done += plain;
            if (left >= ahead) tick(m, n, clock_of(m, n, ++done));
        }
    }
    u->told = at;
}

/* What leaving a compare value does is not looked for while its flag is set: from now on it is. */
void avr_timer_clear(avr *m, int n, uint8_t flags, uint64_t at)
{
    count_to(m, n, at);
    m->data[PLACES[n].flags] &= (uint8_t)~flags;
    schedule(m, n);
}

static void capture(avr *m)
{
    m->timer[1].capture = m->timer[1].count;
    set_captured(m);
    avr_ask(m);
}

static void store(avr *m, unsigned address, uint8_t value, uint64_t at);

/* What was written and has waited for its two edges is at work. */
static void update_registers(avr *m, uint64_t at)
{
    uint64_t due;
    for (unsigned address; (address = avr_crystal_next(m, &due)) && due <= at;) {
        count_to(m, 2, due);
        store(m, address, avr_crystal_take(m, address), due);
    }
}

void avr_timer_advance(avr *m, int n, uint64_t at)
{
    avr_timer *u = &m->timer[n];
    if (n == 1 && u->capture_due <= at) {
        count_to(m, n, u->capture_due);
        u->capture_due = AVR_NEVER;
        capture(m);
    }
    if (is_by_crystal(m, n)) update_registers(m, at);
    count_to(m, n, at);
    schedule(m, n);
}

void avr_timer_pulse(avr *m, int n, uint64_t at)
{
    if (m->data[PRR] & PLACES[n].gate) return;
    tick(m, n, at);
    m->timer[n].told = at;
}

void avr_timer_edge(avr *m, int level, uint64_t at)
{
    enum { CANCELLER_CLOCKS = 4 }; /* four equal samples: DS40002061, Noise Canceler */
    avr_timer *u = &m->timer[1];
    uint8_t control = m->data[TCCR1B];
    avr_timer_advance(m, 1, at);
    u->capture_due = AVR_NEVER;
    if (!waveform(m, 1)->is_top_capture && level == (control & ICES1) / ICES1) {
        if (control & ICNC1) u->capture_due = at + CANCELLER_CLOCKS;
        else capture(m);
    }
    schedule(m, 1);
}

/* WGM and CS as they are now. */
static void configure(avr *m, int n, uint64_t at)
{
    static const uint8_t synchronous[8] = {0, 0, 3, 6, 8, 10, 0, 0}, own[8] = {0, 0, 3, 5, 6, 7, 8, 10};
    avr_timer *u = &m->timer[n];
    uint8_t a = m->data[PLACES[n].control], b = m->data[PLACES[n].control + 1], clock = b & 7;
    int held = m->prescaler_held >> PLACES[n].prescaler & 1;
    u->mode = (uint8_t)((a & 3) | (n == 1 ? (b & 0x18) >> 1 : (b & 8) >> 1));
    u->shift = n == 2 ? own[clock] : synchronous[clock];
    u->is_ticking = clock && (n == 2 || clock < 6) && !(held && u->shift);
    if (is_by_crystal(m, n)) u->is_ticking &= (uint8_t)avr_crystal_runs(m); /* the other's gate does not stop it */
    else if (m->data[PRR] & PLACES[n].gate) u->is_ticking = 0;
    if (!waveform(m, n)->is_dual) u->is_down = 0;
    if (waveform(m, n)->shape == AVR_PLAIN) update(m, u);
    avr_mean_changes(m);
    show(m, n, at);
}

void avr_timer_gates(avr *m, uint64_t at)
{
    uint8_t *control = &m->data[GTCCR], resets = *control | m->prescaler_held; /* one that was held begins now */
    for (int n = 0; n < 3; n++) count_to(m, n, at);
    if (resets & PSRSYNC) m->prescaler[0] = at;
    if (resets & PSRASY) m->prescaler[1] = at, m->crystal.prescaler = avr_crystal_edges(m, at);
    m->prescaler_held = *control & TSM ? *control & (PSRSYNC | PSRASY) : 0;
    if (!(*control & TSM)) *control = 0;
    for (int n = 0; n < 3; n++) {
        configure(m, n, at);
        schedule(m, n);
    }
}

void avr_timer_shift(avr *m, uint64_t clocks)
{
    for (int i = 0; i < 2; i++) m->prescaler[i] += clocks;
    for (int n = 0; n < 3; n++) m->timer[n].told += is_by_crystal(m, n) && !m->is_crystal_frozen ? 0 : clocks;
    if (m->is_crystal_frozen) m->crystal.zero += clocks << m->clock_shift;
    if (m->timer[1].capture_due != AVR_NEVER) m->timer[1].capture_due += clocks;
}

/* FOC: as a match, without its flag; not in PWM. */
static void force(avr *m, int n, uint8_t value, uint64_t at)
{
    if (waveform(m, n)->shape != AVR_PLAIN) return;
    for (int i = 0; i < 2; i++)
        if (value & 0x80 >> i) act(m, n, i, 0);
    show(m, n, at);
}

static void set_count(avr *m, int n, uint16_t value)
{
    m->timer[n].count = value;
    m->timer[n].is_blocked = 1;
}

static void set_compare(avr *m, int n, int i, uint16_t value)
{
    avr_timer *u = &m->timer[n];
    u->buffer[i] = value;
    if (waveform(m, n)->shape == AVR_PLAIN) u->compare[i] = value;
}

static int timer_of(unsigned address) { return address < 0x50 ? 0 : address < 0xb0 ? 1 : 2; }

uint8_t avr_timer_load(avr *m, unsigned address, uint64_t at)
{
    avr_timer *u = &m->timer[timer_of(address)];
    switch (address) {
    case TCNT0: case TCNT2: count_to(m, timer_of(address), at); return (uint8_t)u->count;
    case OCR0A: return (uint8_t)u->buffer[0];
    case OCR0B: return (uint8_t)u->buffer[1];
    case OCR2A: return avr_crystal_read(m, address, (uint8_t)u->buffer[0]);
    case OCR2B: return avr_crystal_read(m, address, (uint8_t)u->buffer[1]);
    case TCCR2A: case TCCR2B: return avr_crystal_read(m, address, m->data[address]);
    case TCNT1L: count_to(m, 1, at); m->temp = (uint8_t)(u->count >> 8); return (uint8_t)u->count;
    case ICR1L: m->temp = (uint8_t)(u->capture >> 8); return (uint8_t)u->capture;
    case TCNT1H: case ICR1H: return m->temp;
    case OCR1AL: case OCR1BL: return (uint8_t)u->buffer[address == OCR1BL];
    case OCR1AH: case OCR1BH: return (uint8_t)(u->buffer[address == OCR1BH] >> 8);
    default: return m->data[address];
    }
}

static void store(avr *m, unsigned address, uint8_t value, uint64_t at)
{
    int n = timer_of(address);
    uint16_t wide = (uint16_t)(m->temp << 8 | value);
    switch (address) {
    case TCCR0A: case TCCR2A: case TCCR1A: m->data[address] = value & 0xf3; configure(m, n, at); break;
    case TCCR0B: case TCCR2B: m->data[address] = value & 0x0f; configure(m, n, at); force(m, n, value, at); break;
    case TCCR1B: m->data[address] = value & 0xdf; configure(m, n, at); break;
    case TCCR1C: force(m, n, value, at); break;
    case TCNT0: case TCNT2: set_count(m, n, value); break;
    case OCR0A: case OCR2A: set_compare(m, n, 0, value); break;
    case OCR0B: case OCR2B: set_compare(m, n, 1, value); break;
    case TCNT1H: case ICR1H: case OCR1AH: case OCR1BH: m->temp = value; break;
    case TCNT1L: set_count(m, n, wide); break;
    case ICR1L: if (waveform(m, n)->is_top_capture) m->timer[n].capture = wide, avr_mean_changes(m); break;
    case OCR1AL: case OCR1BL: set_compare(m, n, address == OCR1BL, wide); break;
    default: break;
    }
}

void avr_timer_store(avr *m, unsigned address, uint8_t value, uint64_t at)
{
    int n = timer_of(address);
    count_to(m, n, at);
    if (n != 2 || !avr_crystal_delays(m, address, value, at)) store(m, address, value, at);
    schedule(m, n);
}

double avr_timer_duty(const avr *m, int pin)
{
    for (int n = 0; n < 3; n++)
        for (int i = 0; i < 2; i++) {
            const avr_waveform *w = waveform(m, n);
            int action = action_of(m, n, i);
            if (PLACES[n].port[i] != avr_port_of(pin) || PLACES[n].bit[i] != 1 << avr_bit_of(pin)) continue;
            if (w->shape == AVR_PLAIN || action < 2 || !m->timer[n].is_ticking) continue;
            double top = top_of(m, n), on = m->timer[n].compare[i], part = w->is_dual ? on / top : (on + 1) / (top + 1);
            if (!(part < 1)) part = 1;
            return action == 2 ? part : 1 - part;
        }
    return -1;
}
