/* What programs and tools ask of the processor of a bank of pins: its memories, resets, its line, its voltages. */
#include <string.h>

#include "core.h"
#include "hil_core.h"
#include "law/pin_bank.h"
#include "law/smoothed_pin.h"
#include "mcu/avr/avr_debug.h"
#include "view.h"

static pin_bank *bank_of(hil_core *c, int axis, int64_t *now_ns) { return core_axis_stirred(c, axis, now_ns)->own; }

static bank_processor *processor_of(hil_core *c, int axis, int64_t *now_ns) { return &bank_of(c, axis, now_ns)->processor; }

static const avr *chip_of(hil_core *c, int axis)
{
    int64_t now_ns;
    return &((const pin_bank *)core_axis(c, axis, &now_ns)->own)->processor.chip;
}

static void begin(hil_core *c, int axis, int is_running, int64_t now_ns)
{
    hil_axis *a = &c->axes[axis];
    pin_bank *b = a->own;
    b->processor.is_running = a->is_processor = is_running;
    bank_processor_show(c, a, now_ns);
    pin_bank_plan(a);
}

void hil_processor_reset(hil_core *c, int axis, int causes, int64_t start_up_cycles)
{
    int64_t now_ns;
    pin_bank *b = bank_of(c, axis, &now_ns);
    bank_processor *p = &b->processor;
    bank_processor_set_zero(p, now_ns);
    avr_reset(&p->chip, causes, (uint64_t)start_up_cycles);
    if (p->has_boot) avr_jump(&p->chip, 0); /* to where its boot loader, which is not in the flash, goes */
    for (int pin = 0; pin < AVR_PINS; pin++) avr_pin(&p->chip, pin, bank_processor_outside(&c->axes[axis], b, pin));
    begin(c, axis, 1, now_ns);
}

void hil_processor_hold(hil_core *c, int axis)
{
    int64_t now_ns;
    bank_processor *p = processor_of(c, axis, &now_ns);
    p->chip.cycle = bank_processor_now(p, now_ns);
    begin(c, axis, 0, now_ns);
}

void hil_processor_clock(hil_core *c, int axis, int64_t hz)
{
    int64_t now_ns;
    pin_bank *b = bank_of(c, axis, &now_ns);
    bank_processor_set_zero(&b->processor, now_ns);
    b->processor.nominal_hz = (double)hz;
    bank_processor_set_clock(&b->processor);
    pin_bank_plan(&c->axes[axis]);
}

void hil_processor_supply(hil_core *c, int axis, double vcc_V, double aref_V)
{
    int64_t now_ns;
    pin_bank *b = bank_of(c, axis, &now_ns);
    bank_processor_supply(&b->processor, vcc_V, aref_V);
    smoothed_look(b, now_ns);
}

int64_t hil_processor_start_up(hil_core *c, int axis) { return (int64_t)avr_start_up(chip_of(c, axis)); }

void hil_processor_load(hil_core *c, int axis, int at, int n, const uint8_t *data)
{
    int64_t now_ns;
    avr_load_flash(&processor_of(c, axis, &now_ns)->chip, (uint32_t)at, data, (uint32_t)n);
}

void hil_processor_load_eeprom(hil_core *c, int axis, int at, int n, const uint8_t *data)
{
    int64_t now_ns;
    avr_load_eeprom(&processor_of(c, axis, &now_ns)->chip, (uint32_t)at, data, (uint32_t)n);
}

void hil_processor_set_fuses(hil_core *c, int axis, const uint8_t fuses[4], int has_boot)
{
    int64_t now_ns;
    bank_processor *p = processor_of(c, axis, &now_ns);
    avr_fuses(&p->chip, fuses[0], fuses[1], fuses[2], fuses[3]);
    p->has_boot = has_boot;
}

void hil_processor_read(hil_core *c, int axis, int memory, int at, int n, uint8_t *out)
{
    const avr *chip = chip_of(c, axis);
    if (memory == HIL_MEMORY_FLASH) memcpy(out, (const uint8_t *)chip->flash + at, (size_t)n);
    else if (memory == HIL_MEMORY_EEPROM) memcpy(out, chip->eeprom + at, (size_t)n);
    else
        for (int i = 0; i < n; i++) out[i] = avr_peek(chip, (uint16_t)(at + i));
}

int64_t hil_processor_cycles(hil_core *c, int axis)
{
    int64_t now_ns;
    const pin_bank *b = core_axis(c, axis, &now_ns)->own;
    return (int64_t)bank_processor_now(&b->processor, now_ns);
}

int64_t hil_processor_baud(hil_core *c, int axis)
{
    uint32_t bit_cycles = avr_bit_cycles(chip_of(c, axis));
    int64_t hz = (int64_t)chip_of(c, axis)->hz;
    return bit_cycles ? (hz + bit_cycles / 2) / bit_cycles : 0;
}

int hil_processor_framing(hil_core *c, int axis) { return avr_framing(chip_of(c, axis)); }

int hil_processor_pc(hil_core *c, int axis) { return 2 * chip_of(c, axis)->pc; }

int hil_processor_pin(hil_core *c, int axis, int pin, double *duty)
{
    const avr *chip = chip_of(c, axis);
    *duty = avr_duty(chip, pin);
    return (int)avr_driven(chip, pin) + 4 * avr_level(chip, pin);
}

void hil_processor_poke(hil_core *c, int axis, int address, int value)
{
    int64_t now_ns;
    avr_poke(&processor_of(c, axis, &now_ns)->chip, (uint16_t)address, (uint8_t)value);
}

int hil_processor_hear(hil_core *c, int axis, int64_t start_ns, double bit_ns, int bits, int length, int is_broken)
{
    int64_t now_ns;
    bank_processor *p = processor_of(c, axis, &now_ns);
    if (!p->is_running) return 0;
    p->chip.cycle = bank_processor_now(p, now_ns);
    avr_character heard = {
        .cycle = bank_processor_cycle(p, start_ns),
        .bit_cycles_256 = (uint32_t)(bit_ns * 256e-9 * (double)p->hz + 0.5),
        .bits = (uint16_t)bits,
        .length = (uint8_t)length,
        .is_broken = (uint8_t)is_broken,
    };
    int refused = bank_processor_hear(p, &heard);
    pin_bank_plan(&c->axes[axis]);
    return refused;
}

void hil_processor_retract(hil_core *c, int axis, int64_t after_ns)
{
    int64_t now_ns;
    bank_processor *p = processor_of(c, axis, &now_ns);
    bank_processor_retract(p, bank_processor_cycle(p, after_ns));
    pin_bank_plan(&c->axes[axis]);
}

void hil_processor_volts(hil_core *c, int axis, int channel, double volts)
{
    int64_t now_ns;
    processor_of(c, axis, &now_ns)->analog[channel].volts = volts;
}

void hil_processor_measure(hil_core *c, int axis, int channel, int of_axis, hil_field field, double gain, double volts)
{
    int64_t now_ns;
    core_join(c, axis);
    core_join(c, of_axis); /* nothing that happens to it is later than a sample */
    processor_of(c, axis, &now_ns)->analog[channel] = (analog_input){of_axis, field, gain, volts, view_field};
}

int hil_processor_smooth(hil_core *c, int axis, int channel, int of_axis, int pin, double rc_s, double gain, double volts)
{
    int64_t now_ns;
    pin_bank *source = bank_of(c, of_axis, &now_ns);
    int number = smoothed_add(source, pin, rc_s, now_ns);
    if (number < 0) return -1;
    processor_of(c, axis, &now_ns)->analog[channel] = (analog_input){of_axis, (hil_field)number, gain, volts, smoothed_V};
    return 0;
}

void hil_processor_drives_line(hil_core *c, int axis, int pin)
{
    int64_t now_ns;
    processor_of(c, axis, &now_ns)->driver_pin = pin;
    bank_processor_show(c, &c->axes[axis], now_ns);
}

/* ---- who debugs it ---- */

void hil_processor_break(hil_core *c, int axis, int byte, int is_on)
{
    int64_t now_ns;
    avr_break_at(&processor_of(c, axis, &now_ns)->chip, (uint32_t)byte, is_on);
}

void hil_processor_halt(hil_core *c, int axis)
{
    int64_t now_ns;
    avr_halt(&processor_of(c, axis, &now_ns)->chip);
    pin_bank_plan(&c->axes[axis]);
}

/* Where the group's time stood meanwhile, cycles are at the times at which they would have been without it. */
void hil_processor_go(hil_core *c, int axis, int is_step)
{
    int64_t now_ns;
    bank_processor *p = processor_of(c, axis, &now_ns);
    if (p->chip.debug.is_halted && bank_processor_cycle(p, now_ns) > p->chip.cycle) bank_processor_set_zero(p, now_ns);
    avr_go(&p->chip, is_step);
    pin_bank_plan(&c->axes[axis]);
}

int hil_processor_is_halted(hil_core *c, int axis) { return chip_of(c, axis)->debug.is_halted; }

void hil_processor_jump(hil_core *c, int axis, int byte)
{
    int64_t now_ns;
    avr_jump(&processor_of(c, axis, &now_ns)->chip, (uint32_t)byte);
}

void hil_processor_stack_floor(hil_core *c, int axis, int address)
{
    int64_t now_ns;
    avr_stack_floor(&processor_of(c, axis, &now_ns)->chip, (uint16_t)address);
}

int hil_processor_stack_lowest(hil_core *c, int axis) { return chip_of(c, axis)->stack_lowest; }

void hil_processor_count(hil_core *c, int axis, int n, const uint16_t *starts, int lap_at)
{
    int64_t now_ns;
    avr_count(&processor_of(c, axis, &now_ns)->chip, n, starts, lap_at);
}

int hil_processor_counted(hil_core *c, int axis, int n, uint64_t *spent, uint32_t *calls)
{
    const avr_debug *d = &chip_of(c, axis)->debug;
    n = n < d->functions ? n : d->functions;
    memcpy(spent, d->spent, (size_t)n * sizeof(*spent));
    memcpy(calls, d->calls, (size_t)n * sizeof(*calls));
    return n;
}

int64_t hil_processor_counted_clocks(hil_core *c, int axis)
{
    const avr *chip = chip_of(c, axis);
    return (int64_t)(chip->cycle - chip->debug.since);
}

int hil_processor_laps(hil_core *c, int axis, int n, uint32_t *laps)
{
    const avr_debug *d = &chip_of(c, axis)->debug;
    if (d->laps < (uint64_t)n) n = (int)d->laps;
    memcpy(laps, d->lap, (size_t)n * sizeof(*laps));
    return n;
}
