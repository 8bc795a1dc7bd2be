#include "atmega328p.h"

#include <string.h>

#include "avr_adc.h"
#include "avr_clocked.h"
#include "avr_crystal.h"
#include "avr_decode.h"
#include "avr_frame.h"
#include "avr_line.h"
#include "avr_pins.h"
#include "avr_receiver.h"
#include "avr_registers.h"
#include "avr_run.h"
#include "avr_time.h"
#include "avr_timer.h"
#include "avr_watchdog.h"

/* The clock at the world's cycle. */
static uint64_t now(const avr *m) { return avr_inner(m, m->cycle); }

void avr_open(avr *m)
{
    memset(m, 0, sizeof(*m));
    memset(m->flash, 0xff, sizeof(m->flash));
    memset(m->eeprom, 0xff, sizeof(m->eeprom));
    m->hz = 16e6;
    m->vcc_volts = m->aref_volts = 5;
    m->stack_floor = 0x100;
    m->usart.wire = 1;
    avr_fuses(m, 0xff, 0xdf, 0xfd, 0x3f);
    avr_decode(m, 0, AVR_FLASH_WORDS);
    for (int pin = 0; pin < AVR_PINS; pin++) m->told[pin] = AVR_OPEN;
    for (int part = 0; part < AVR_PARTS; part++) m->due[part] = AVR_NEVER;
}

void avr_clock(avr *m, double hz)
{
    avr_timer_advance(m, 2, now(m));
    avr_crystal_rebase(m);
    m->hz = hz;
    avr_timer_advance(m, 2, now(m));
}

void avr_crystal_at(avr *m, uint32_t hz, int is_clock)
{
    avr_timer_advance(m, 2, now(m));
    avr_crystal_rebase(m);
    m->crystal.hz = hz;
    m->crystal.is_clock = is_clock != 0;
    avr_timer_gates(m, now(m));
}

void avr_fuses(avr *m, int low, int high, int extended, int lock)
{
    m->fuses[0] = (uint8_t)low;
    m->fuses[1] = (uint8_t)high;
    m->fuses[2] = (uint8_t)extended;
    m->lock = (uint8_t)lock;
}

void avr_load_flash(avr *m, uint32_t byte, const uint8_t *data, uint32_t n)
{
    if (byte >= AVR_FLASH_BYTES) return;
    if (n > AVR_FLASH_BYTES - byte) n = AVR_FLASH_BYTES - byte;
    for (uint32_t i = 0; i < n; i++) {
        uint16_t *word = &m->flash[(byte + i) / 2];
        *word = (byte + i) & 1 ? (uint16_t)((*word & 0xff) | data[i] << 8) : (uint16_t)((*word & 0xff00) | data[i]);
    }
    if (n) avr_decode(m, byte / 2, n / 2 + 1);
}

void avr_load_eeprom(avr *m, uint32_t byte, const uint8_t *data, uint32_t n)
{
    for (uint32_t i = 0; i < n && byte + i < AVR_EEPROM_BYTES; i++) m->eeprom[byte + i] = data[i];
}

uint64_t avr_start_up(const avr *m) { return avr_run_start_up(m); }

void avr_reset(avr *m, int causes, uint64_t start_up)
{
    uint64_t at = now(m);
    avr_run_reset(m, causes, at, at + start_up);
    m->watchdog_loops = 0;
}

uint64_t avr_run(avr *m, uint64_t until, const avr_world *world)
{
    static const avr_world nobody;
    if (until < m->cycle) return m->cycle;
    avr_run_until(m, until, world ? world : &nobody);
    if (!m->is_stopped) m->cycle = until;
    else if (avr_outer(m, m->reached) > m->cycle) m->cycle = avr_outer(m, m->reached);
    return m->cycle;
}

void avr_stop(avr *m)
{
    m->is_stopped = 1;
    m->attention = 0;
}

uint64_t avr_next(const avr *m)
{
    uint64_t next = AVR_NEVER;
    if (!m->is_running) return AVR_NEVER;
    for (int part = 0; part < AVR_PARTS; part++)
        if (m->due[part] < next) next = m->due[part];
    if (!m->asleep && m->t < next) next = m->t;
    if (next == AVR_NEVER) return AVR_NEVER;
    return avr_outer(m, next) > m->cycle ? avr_outer(m, next) : m->cycle;
}

void avr_pin(avr *m, int pin, int level)
{
    if (pin < 0 || pin >= AVR_PINS) return;
    avr_port *p = &m->port[avr_port_of(pin)];
    uint8_t bit = (uint8_t)(1 << avr_bit_of(pin));
    p->outside = (uint8_t)(level >= 0 ? p->outside | bit : p->outside & ~bit);
    p->forced = (uint8_t)(level > 0 ? p->forced | bit : p->forced & ~bit);
    avr_pins_refresh(m, avr_port_of(pin), now(m));
    if (pin > 0) return;
    avr_line_wire(&m->usart, level != 0, m->cycle);
    avr_receiver_look(m, now(m));
}

void avr_volts(avr *m, int channel, double volts)
{
    if (channel < 0 || channel >= AVR_CHANNELS) return;
    m->volts[channel] = volts;
    avr_comparator_look(m, now(m));
}

void avr_supply(avr *m, double vcc_volts, double aref_volts)
{
    m->vcc_volts = vcc_volts;
    m->aref_volts = aref_volts;
}

int avr_hear(avr *m, const avr_character *c)
{
    avr_usart *u = &m->usart;
    if (c->bit_cycles_256 < 256 || c->length > 10) return -1;
    if (!u->is_receiving && m->cycle > 2) avr_line_forget(u, m->cycle - 2);
    if (u->heard_count == AVR_HEARD) return -1;
    u->heard[(u->heard_first + u->heard_count++) % AVR_HEARD] = *c;
    avr_receiver_look(m, now(m));
    avr_due(m, AVR_PART_LINE, now(m) + 1);
    return 0;
}

void avr_retract(avr *m, uint64_t after)
{
    avr_usart *u = &m->usart;
    while (u->heard_count && u->heard[(u->heard_first + u->heard_count - 1) % AVR_HEARD].cycle > after) u->heard_count--;
    avr_receiver_look(m, now(m));
}

void avr_watch(avr *m, uint32_t pins)
{
    m->changed_pins |= pins & ~m->watched & ((1u << AVR_PINS) - 1);
    m->watched = pins;
    avr_due(m, AVR_PART_LINE, now(m) + 1);
}

void avr_tell_means(avr *m, int is_told) { m->is_mean_told = (uint8_t)is_told; }

void avr_stack_floor(avr *m, uint16_t address) { m->stack_floor = address; }

void avr_break_at(avr *m, uint32_t byte, int is_on)
{
    uint32_t word = byte / 2;
    if (word >= AVR_FLASH_WORDS) return;
    uint8_t bit = (uint8_t)(1 << word % 8);
    m->breaks[word / 8] = (uint8_t)(is_on ? m->breaks[word / 8] | bit : m->breaks[word / 8] & ~bit);
    avr_decode(m, word, 1);
}

int avr_is_at_break(const avr *m) { return m->is_at_break; }

uint16_t avr_stack_lowest(const avr *m) { return m->stack_lowest; }

int avr_level(const avr *m, int pin) { return m->port[avr_port_of(pin)].level >> avr_bit_of(pin) & 1; }

enum avr_drive avr_driven(const avr *m, int pin) { return avr_pins_drive(m, avr_port_of(pin), (uint8_t)(1 << avr_bit_of(pin))); }

double avr_duty(const avr *m, int pin) { return avr_timer_duty(m, pin); }

int avr_is_sending(const avr *m) { return (m->data[UCSR0B] & TXEN || m->usart.is_sending) && !avr_is_spi(m); }

uint32_t avr_bit_cycles(const avr *m)
{
    int is_on = m->data[UCSR0B] & (RXEN | TXEN) && !avr_is_spi(m);
    return !is_on ? 0 : (avr_is_clocked(m) ? 2 * avr_frame_divider(m) : avr_frame_bit(m)) << m->clock_shift;
}

int avr_framing(const avr *m) { return avr_frame_framing(m); }

/* Registers that a part has: reading them counts on to now, which does not show, and sets TEMP or the ADC's lock, which are put
   back. Of 16 bits the high byte is that of the register, not TEMP. */
static uint8_t peek_part(avr *m, uint16_t address)
{
    uint8_t temp = m->temp, is_locked = m->adc.is_locked, got;
    if (address == ADCL || address == ADCH) got = avr_adc_load(m, address);
    else got = avr_timer_load(m, address, now(m));
    if (address == TCNT1H || address == ICR1H) {
        avr_timer_load(m, address - 1u, now(m));
        got = m->temp;
    }
    m->temp = temp;
    m->adc.is_locked = is_locked;
    return got;
}

uint8_t avr_peek(const avr *m, uint16_t address)
{
    switch (address) {
    case SREG: return m->sreg;
    case SPL: return (uint8_t)m->sp;
    case SPH: return (uint8_t)(m->sp >> 8);
    case PINB: case PINC: case PIND: return m->port[(address - PINB) / 3].level;
    case UDR0: return (uint8_t)m->usart.buffer[0];
    case TCNT0: case OCR0A: case OCR0B: case TCNT2: case OCR2A: case OCR2B: case OCR1AL: case OCR1AH: case OCR1BL: case OCR1BH:
    case TCNT1L: case TCNT1H: case ICR1L: case ICR1H: case ADCL: case ADCH: return peek_part((avr *)m, address);
    default: return address < AVR_DATA_BYTES ? m->data[address] : 0;
    }
}

void avr_poke(avr *m, uint16_t address, uint8_t value)
{
    if (address == SREG) m->sreg = value;
    else if (address == SPL) m->sp = (uint16_t)((m->sp & 0xff00) | value);
    else if (address == SPH) m->sp = (uint16_t)((m->sp & 0xff) | value << 8);
    else if (address < AVR_DATA_BYTES) m->data[address] = value;
    if (address == WDTCSR) avr_watchdog_restart(m, now(m));
    m->attention = 0;
}
