#include "bank_processor.h"

#include <string.h>

#include "../core.h"
#include "../mcu/avr/avr_debug.h"
#include "smoothed_pin.h"

enum { NS = 1000000000 };
enum { MCUSR = 0x54, WDTCSR = 0x60 }; /* DS40002061, 36 */
enum { CYCLES_OF_WORK = 50 };         /* take some 50 ns, what group.c counts as one */

/* ---- time ---- */

static int64_t ns_of(const bank_processor *p, uint64_t cycle)
{
    int64_t d = (int64_t)(cycle - p->zero_cycle);
    return p->zero_ns + d / p->hz * NS + d % p->hz * NS / p->hz;
}

/* The last cycle that is not after a time. */
uint64_t bank_processor_cycle(const bank_processor *p, int64_t at_ns)
{
    int64_t d = at_ns - p->zero_ns;
    return p->zero_cycle + (uint64_t)(d / NS * p->hz + ((d % NS + 1) * p->hz - 1) / NS);
}

uint64_t bank_processor_now(const bank_processor *p, int64_t now_ns)
{
    uint64_t cycle = bank_processor_cycle(p, now_ns);
    int is_idle = p->is_running && !p->chip.debug.is_halted && bank_processor_next_ns(p) > now_ns;
    return is_idle && cycle > p->chip.cycle ? cycle : p->chip.cycle;
}

void bank_processor_set_zero(bank_processor *p, int64_t now_ns)
{
    p->chip.cycle = bank_processor_now(p, now_ns);
    p->zero_ns = now_ns;
    p->zero_cycle = p->chip.cycle;
}

int64_t bank_processor_next_ns(const bank_processor *p)
{
    if (!p->is_running || p->chip.debug.is_halted) return HIL_FOREVER;
    uint64_t next = avr_next(&p->chip), after = p->chip.cycle + 1;
    if (p->n_waiting && p->waiting[p->first_waiting].cycle < next) next = p->waiting[p->first_waiting].cycle;
    return next == UINT64_MAX ? HIL_FOREVER : ns_of(p, next < after ? after : next);
}

/* ---- what comes out ---- */

typedef struct run {
    hil_core *c;
    hil_axis *a;
    bank_processor *p;
} run;

/* Others of its group may have to do something because of it: they are looked at before it goes on. */
static void stop(const run *r)
{
    r->a->has_stopped = 1;
    avr_stop(&r->p->chip);
}

static void tell(const run *r, int64_t at_ns, int kind, double value)
{
    core_post(r->c, (int)(r->a - r->c->axes), at_ns, kind, value);
    stop(r);
}

int bank_processor_outside(const hil_axis *a, const pin_bank *b, int pin)
{
    if (b->processor.stuck >> pin & 1) return b->processor.stuck_high >> pin & 1;
    return a->inputs.known >> pin & 1 ? b->outside[pin] : -1;
}

static int level_of(const hil_axis *a, const pin_bank *b, int pin, enum avr_drive drive)
{
    int level = bank_processor_outside(a, b, pin);
    int is_driven = drive == AVR_LOW || drive == AVR_HIGH;
    if (is_driven && !(b->processor.stuck >> pin & 1)) return drive == AVR_HIGH;
    return level >= 0 ? level : drive == AVR_PULLED_UP ? 1 : OUTPUT_OPEN;
}

static void show(const run *r, int pin, enum avr_drive drive, int64_t at_ns)
{
    pin_bank *b = r->a->own;
    int is_driven = drive == AVR_LOW || drive == AVR_HIGH;
    b->driven = is_driven ? b->driven | 1 << pin : b->driven & ~(1 << pin);
    outputs_set(r->c, &b->out, pin, level_of(r->a, b, pin, drive), at_ns);
}

static void on_pin(void *self, int pin, enum avr_drive drive, uint64_t cycle)
{
    const run *r = self;
    pin_bank *b = r->a->own;
    int was_high = b->out.levels[pin] > 0;
    show(r, pin, drive, ns_of(r->p, cycle));
    int is_high = b->out.levels[pin] > 0;
    if (outputs_is_wired(&b->out, pin)) stop(r);
    if (pin == r->p->driver_pin && is_high != was_high) tell(r, ns_of(r->p, cycle), HIL_EVENT_LINE_DRIVER, is_high);
}

/* Framing in 7 bits, what follows the start bit in 10, cycles of a bit; hil/core/core_processor.py takes it apart. */
static void on_sent(void *self, const avr_character *sent)
{
    const run *r = self;
    double packed = sent->bits + 1024.0 * (sent->framing + 128.0 * sent->bit_cycles_256);
    tell(r, ns_of(r->p, sent->cycle), HIL_EVENT_SENT, packed);
}

double bank_processor_volts(hil_core *c, const bank_processor *p, int channel, int64_t at_ns)
{
    const analog_input *from = &p->analog[channel];
    return from->volts + (from->field ? from->gain * from->field(c, from->axis, from->number, at_ns) : 0);
}

static double on_volts(void *self, int channel, uint64_t cycle)
{
    const run *r = self;
    return bank_processor_volts(r->c, r->p, channel, ns_of(r->p, cycle));
}

static void on_means(void *self, uint64_t cycle)
{
    const run *r = self;
    smoothed_look(r->a->own, ns_of(r->p, cycle));
}

static void on_reset(void *self, enum avr_cause cause, uint64_t cycle)
{
    const run *r = self;
    if (r->p->has_boot) { /* Optiboot reads and clears MCUSR, and turns the watchdog off */
        avr_poke(&r->p->chip, MCUSR, 0);
        avr_poke(&r->p->chip, WDTCSR, 0);
        avr_jump(&r->p->chip, 0);
    }
    smoothed_look(r->a->own, ns_of(r->p, cycle));
    tell(r, ns_of(r->p, cycle), HIL_EVENT_CHIP_RESET, cause);
}

static void on_note(void *self, enum avr_note note, uint32_t value, uint64_t cycle)
{
    const run *r = self;
    tell(r, ns_of(r->p, cycle), HIL_EVENT_PROGRAM_NOTE, note + 256.0 * value);
}

static void on_stored(void *self, int address, uint64_t cycle)
{
    const run *r = self;
    tell(r, ns_of(r->p, cycle), HIL_EVENT_EEPROM_WRITTEN, address);
}

/* Its program has written a page of its own flash. */
static int on_spm(void *self, uint32_t page_byte, uint64_t cycle)
{
    const run *r = self;
    tell(r, ns_of(r->p, cycle), HIL_EVENT_FLASH_WRITTEN, page_byte);
    return 0;
}

/* ---- the line ---- */

int bank_processor_hear(bank_processor *p, const avr_character *heard)
{
    if (p->n_waiting == MOST_WAITING) return -1;
    p->waiting[(p->first_waiting + p->n_waiting++) % MOST_WAITING] = *heard;
    return 0;
}

void bank_processor_retract(bank_processor *p, uint64_t after)
{
    while (p->n_waiting && p->waiting[(p->first_waiting + p->n_waiting - 1) % MOST_WAITING].cycle > after) p->n_waiting--;
    avr_retract(&p->chip, after);
}

/* Hands over what the chip has room for. Answers how far it may run then: to where it has room again. */
static uint64_t hand_over(bank_processor *p, uint64_t until)
{
    for (; p->n_waiting; p->n_waiting--) {
        avr_character *next = &p->waiting[p->first_waiting];
        if (avr_hear(&p->chip, next)) return next->cycle < until ? next->cycle + 1 : until;
        p->first_waiting = (p->first_waiting + 1) % MOST_WAITING;
    }
    return until;
}

int64_t bank_processor_run(hil_core *c, hil_axis *a, int64_t until_ns)
{
    pin_bank *b = a->own;
    bank_processor *p = &b->processor;
    run r = {c, a, p};
    avr_world world = {.self = &r, .pin = on_pin, .sent = on_sent, .volts = on_volts, .means = on_means, .reset = on_reset,
                       .note = on_note, .spm = on_spm, .stored = on_stored};
    avr_tell_means(&p->chip, b->n_smoothed != 0);
    uint64_t before = p->chip.cycle, until = bank_processor_cycle(p, until_ns);
    if (until <= before || p->chip.debug.is_halted) return 0;
    uint64_t reached = before;
    while (reached < until && !a->has_stopped) {
        reached = avr_run(&p->chip, hand_over(p, until), &world);
        if (avr_is_at_break(&p->chip)) avr_halt(&p->chip);
        if (p->chip.debug.is_halted) tell(&r, ns_of(p, reached), HIL_EVENT_HALTED, 2 * p->chip.pc);
    }
    a->stopped_ns = ns_of(p, reached);
    return (int64_t)(reached - before) / CYCLES_OF_WORK;
}

/* ---- what comes in ---- */

static void watch_pins(pin_bank *b)
{
    int driver = b->processor.driver_pin;
    avr_watch(&b->processor.chip, (uint32_t)(b->out.watched | (driver < 0 ? 0 : 1 << driver)));
}

void bank_processor_pin(hil_core *c, hil_axis *a, int pin, int64_t at_ns)
{
    pin_bank *b = a->own;
    bank_processor *p = &b->processor;
    run r = {c, a, p};
    p->chip.cycle = bank_processor_now(p, at_ns);
    avr_pin(&p->chip, pin, bank_processor_outside(a, b, pin));
    show(&r, pin, avr_driven(&p->chip, pin), at_ns);
    smoothed_look(b, at_ns);
}

void bank_processor_show(hil_core *c, hil_axis *a, int64_t now_ns)
{
    pin_bank *b = a->own;
    run r = {c, a, &b->processor};
    watch_pins(b);
    for (int pin = 0; pin < AVR_PINS; pin++) show(&r, pin, r.p->is_running ? avr_driven(&r.p->chip, pin) : AVR_OPEN, now_ns);
    smoothed_look(b, now_ns);
}

void bank_processor_look(hil_axis *a, int64_t now_ns)
{
    (void)now_ns;
    pin_bank *b = a->own;
    avr *chip = &b->processor.chip;
    watch_pins(b);
    for (int pin = 0; pin < AVR_PINS; pin++) b->out.levels[pin] = level_of(a, b, pin, avr_driven(chip, pin));
}

/* ---- its life ---- */

void bank_processor_open(bank_processor *p)
{
    p->nominal_hz = 16000000; /* a Uno's */
    p->driver_pin = -1;
    p->vcc_V = p->aref_V = 5;
}

void bank_processor_set_clock(bank_processor *p)
{
    p->hz = (int64_t)(p->nominal_hz * (1 + p->clock_error_pct / 100) + 0.5);
    avr_clock(&p->chip, (double)p->hz);
}

void bank_processor_supply(bank_processor *p, double vcc_V, double aref_V)
{
    p->vcc_V = vcc_V;
    p->aref_V = aref_V;
    avr_supply(&p->chip, vcc_V, aref_V);
}

void bank_processor_power_up(hil_axis *a, bank_processor *p)
{
    p->is_running = a->is_processor = 0;
    p->n_waiting = 0;
    avr_debug debug = p->chip.debug; /* who debugs it stays, with the breakpoints: a flash that is loaded has them */
    uint8_t breaks[sizeof(p->chip.breaks)];
    memcpy(breaks, p->chip.breaks, sizeof(breaks));
    avr_open(&p->chip);
    p->chip.debug = debug;
    memcpy(p->chip.breaks, breaks, sizeof(breaks));
    bank_processor_set_clock(p);
    avr_supply(&p->chip, p->vcc_V, p->aref_V);
}
