#include "avr_run.h"

#include <string.h>

#include "avr_adc.h"
#include "avr_clocked.h"
#include "avr_debug.h"
#include "avr_decode.h"
#include "avr_execute.h"
#include "avr_interrupt.h"
#include "avr_io.h"
#include "avr_line.h"
#include "avr_memory.h"
#include "avr_pins.h"
#include "avr_receiver.h"
#include "avr_registers.h"
#include "avr_sender.h"
#include "avr_sleep.h"
#include "avr_spi.h"
#include "avr_time.h"
#include "avr_timer.h"
#include "avr_twi.h"
#include "avr_usart.h"
#include "avr_watchdog.h"

enum { LONGEST = 4 /* clocks of an instruction */, LOOPS = 2 /* resets of the watchdog, one after the other, that are told */ };

/* CKSEL 1111, SUT 11, the Uno's: 16384 clocks and 65 ms; less with faster fuses: table Start-up Times for the Low Power
   Crystal Oscillator. CKSEL 0010 is the RC oscillator: table Start-up Times for the Internal Calibrated RC Oscillator. */
uint64_t avr_run_start_up(const avr *m)
{
    static const double seconds[4] = {65e-3, 0, 4.1e-3, 65e-3}, rc_seconds[4] = {0, 4.1e-3, 65e-3, 65e-3};
    int sut = m->fuses[0] >> 4 & 3;
    int is_rc = (m->fuses[0] & 15) == 2, shift = m->fuses[0] & 0x80 ? 0 : 3; /* CKDIV8 */
    uint64_t waits = (uint64_t)((is_rc ? rc_seconds : seconds)[sut] * m->hz + 0.5) >> shift;
    return (is_rc ? 0 : sut == 0 ? 1024 : 16384) + 14 + waits;
}

void avr_run_reset(avr *m, int causes, uint64_t at, uint64_t begins)
{
    uint8_t status = m->data[MCUSR] | (uint8_t)causes;
    avr_character heard[AVR_HEARD];
    avr_usart line = m->usart;
    memcpy(heard, m->usart.heard, sizeof(heard));
    memset(m->data + 0x20, 0, 0x100 - 0x20);
    memset(m->timer, 0, sizeof(m->timer));
    memset(&m->usart, 0, sizeof(m->usart));
    memset(&m->adc, 0, sizeof(m->adc));
    memset(&m->spi, 0, sizeof(m->spi));
    memset(&m->twi, 0, sizeof(m->twi));
    memset(m->page, 0xff, sizeof(m->page));
    memcpy(m->usart.heard, heard, sizeof(heard));
    m->usart.heard_first = line.heard_first, m->usart.heard_count = line.heard_count;
    m->usart.wire = line.wire, m->usart.wire_last = line.wire_last, m->usart.wire_count = line.wire_count;
    memcpy(m->usart.wire_at, line.wire_at, sizeof(line.wire_at));
    m->data[MCUSR] = causes ? status : 0;
    m->data[UCSR0A] = UDRE;
    m->data[UCSR0C] = UCSZ;
    m->data[TWSR] = 0xf8;
    m->data[TWDR] = 0xff;
    m->data[TWAR] = 0xfe;
    m->data[OSCCAL] = 0x80;
    if (m->data[MCUSR] & WDRF) m->data[WDTCSR] = WDE;
    avr_set_clock_shift(m, m->fuses[0] & 0x80 ? 0 : 3, at); /* CKDIV8 */
    m->data[CLKPR] = m->clock_shift;
    m->pc = m->fuses[1] & 1 ? 0 : (uint16_t)avr_boot_start(m); /* BOOTRST */
    m->sp = AVR_DATA_BYTES - 1;
    m->sreg = 0;
    m->is_held = m->planned = m->entered = m->asleep = m->is_frozen = m->is_crystal_frozen = 0;
    m->noted = 0;
    m->stack_lowest = AVR_DATA_BYTES - 1;
    m->is_at_break = m->is_passing = 0;
    m->edge_count = 0;
    m->temp = 0;
    m->timer_flags = 0;
    m->prescaler_held = 0;
    m->timer[1].capture_due = AVR_NEVER;
    m->eeprom_armed = m->watchdog_armed = m->clkpr_armed = m->ivsel_armed = m->spm_armed = 0;
    for (int i = 0; i < 2; i++) m->prescaler[i] = begins;
    for (int n = 0; n < 3; n++) m->timer[n].told = begins;
    for (int part = 0; part < AVR_PARTS; part++) m->due[part] = AVR_NEVER;
    for (int port = 0; port < 3; port++) {
        avr_port *p = &m->port[port];
        p->as_output = p->as_input = p->own = p->own_level = 0;
        avr_pins_refresh(m, port, at);
        p->seen = p->level;
    }
    m->edge_count = 0;
    m->due[AVR_PART_PINS] = AVR_NEVER;
    avr_ask(m);
    avr_watchdog_restart(m, begins);
    m->t = begins;
    m->is_running = 1;
    m->attention = 0;
}

static int is_d1_told(const avr *m) { return (m->watched & (2 | 1u << 20)) == 2 || avr_is_spi(m); }

/* Levels at D0 and D1 go to their port while a frame is on its way and something looks at them. */
static void line_event(avr *m, uint64_t at)
{
    avr_usart *u = &m->usart;
    uint64_t due = AVR_NEVER;
    int is_looked_at = is_d1_told(m) || m->data[PCMSK2] & 2;
    if (is_looked_at && (m->data[UCSR0B] & TXEN || u->is_sending)) {
        avr_pins_own(m, AVR_PORT_D, 2, 1, avr_sender_level(m, at));
        due = avr_sender_next_level(m, at);
    }
    if (m->data[PCMSK2] & 1) {
        avr_port *p = &m->port[AVR_PORT_D];
        int level = avr_line_level(u, avr_outer(m, at));
        uint64_t next = avr_line_next(u, avr_outer(m, at));
        p->forced = (uint8_t)((p->forced & ~1) | level);
        if (u->heard_count) p->outside |= 1;
        if (next != AVR_NEVER && avr_inner(m, next) < due) due = avr_inner(m, next);
    }
    avr_pins_refresh(m, AVR_PORT_D, at);
    avr_due(m, AVR_PART_LINE, due);
}

static void pins_event(avr *m, uint64_t at)
{
    while (m->edge_count && m->edges[m->edge_first].due <= at) {
        avr_edge e = m->edges[m->edge_first];
        avr_port *p = &m->port[e.port];
        uint8_t before = p->seen, level = (uint8_t)((e.level & e.cared) | (before & ~e.cared)), changes = before ^ level, control;
        m->edge_first = (uint8_t)((m->edge_first + 1) % AVR_EDGES);
        m->edge_count--;
        p->seen = level;
        uint8_t external = m->data[EIFR] & 1;
        avr_interrupt_edges(m, e.port, level, before);
        if (~external & m->data[EIFR] & 1) avr_adc_trigger(m, 0, 1, 0, at);
        if (e.port == AVR_PORT_C && changes & 0x30) avr_twi_edges(m, level, before, at);
        if (m->is_frozen) continue;
        if (e.port == AVR_PORT_B && changes & 0x24) avr_spi_edges(m, level, before, at);
        if (e.port == AVR_PORT_B && changes & 1 && !(m->data[ACSR] & ACIC)) avr_timer_edge(m, level & 1, at);
        for (int n = 0; n < 2 && e.port == AVR_PORT_D; n++) {
            control = m->data[n ? TCCR1B : TCCR0B] & 7;
            if (changes >> (4 + n) & 1 && control == 6 + (level >> (4 + n) & 1)) avr_timer_pulse(m, n, at);
        }
        if (e.port == AVR_PORT_D && changes & 16 && avr_is_clocked(m)) avr_clocked_edge(m, level >> 4 & 1, at);
        if (e.port == AVR_PORT_D && changes & 0xc0) avr_comparator_look(m, at);
    }
    avr_due(m, AVR_PART_PINS, m->edge_count ? m->edges[m->edge_first].due : AVR_NEVER);
}

static void reset_by_watchdog(avr *m, uint64_t at)
{
    int loops = m->watchdog_loops < 255 ? m->watchdog_loops + 1 : 255;
    uint8_t notes = m->notes;
    avr_run_reset(m, AVR_WATCHDOG, at, at + avr_run_start_up(m));
    m->notes = notes;
    m->watchdog_loops = (uint8_t)loops;
    m->reset_cause = AVR_WATCHDOG;
    if (loops == LOOPS) avr_note_once(m, AVR_NOTE_WATCHDOG_LOOP, (uint16_t)loops);
}

static void event(avr *m, int part, uint64_t at, const avr_world *world)
{
    int channel;
    switch (part) {
    case AVR_PART_PINS: pins_event(m, at); break;
    case AVR_PART_TIMER0: case AVR_PART_TIMER1: case AVR_PART_TIMER2: avr_timer_advance(m, part - AVR_PART_TIMER0, at); break;
    case AVR_PART_SEND: avr_usart_sent(m, at); break;
    case AVR_PART_RECEIVE: avr_receiver_event(m, at); break;
    case AVR_PART_LINE: line_event(m, at); break;
    case AVR_PART_SPI: avr_spi_event(m, at); break;
    case AVR_PART_TWI: avr_twi_event(m, at); break;
    case AVR_PART_ADC:
        channel = avr_adc_samples(m);
        if (channel >= 0 && world->volts) m->volts[channel] = world->volts(world->self, channel, avr_outer(m, at));
        avr_adc_event(m, at);
        break;
    case AVR_PART_COMPARATOR:
        channel = avr_comparator_channel(m);
        if (channel >= 0 && world->volts) m->volts[channel] = world->volts(world->self, channel, avr_outer(m, at));
        avr_comparator_event(m, world->volts != NULL, at);
        break;
    case AVR_PART_EEPROM: avr_eeprom_event(m, at); break;
    case AVR_PART_SPM: avr_spm_event(m, at); break;
    case AVR_PART_WATCHDOG: if (avr_watchdog_event(m, at)) reset_by_watchdog(m, at); break;
    default: m->due[part] = AVR_NEVER; break;
    }
    if (m->timer_flags) {
        uint16_t risen = m->timer_flags;
        m->timer_flags = 0;
        avr_adc_trigger(m, risen, 0, 0, at);
    }
}

/* The world hears of what has changed by a clock. */
static void tell(avr *m, const avr_world *world, uint64_t at)
{
    uint64_t cycle = avr_outer(m, at);
    uint32_t pins = m->changed_pins & m->watched;
    m->cycle = cycle; /* what the world does at once, as by avr_pin, it does now */
    if (!is_d1_told(m) && (m->data[UCSR0B] & TXEN || m->usart.is_sending)) pins &= ~2u;
    m->changed_pins = 0;
    m->reached = at;
    if (m->reset_cause) {
        enum avr_cause cause = (enum avr_cause)m->reset_cause;
        m->reset_cause = 0;
        if (world->reset) world->reset(world->self, cause, cycle);
    }
    while (pins) {
        int pin = __builtin_ctz(pins);
        pins &= pins - 1;
        enum avr_drive drive = avr_pins_drive(m, avr_port_of(pin), (uint8_t)(1 << avr_bit_of(pin)));
        if (m->told[pin] == drive) continue;
        m->told[pin] = (uint8_t)drive;
        if (world->pin) world->pin(world->self, pin, drive, cycle);
    }
    if (m->is_mean_new) {
        m->is_mean_new = 0;
        if (world->means) world->means(world->self, cycle);
    }
    if (m->is_frame_new) {
        m->is_frame_new = 0;
        if (world->sent) world->sent(world->self, &m->usart.frame);
    }
    if (m->is_page_new) {
        m->is_page_new = 0;
        if (world->spm) world->spm(world->self, m->page_byte, cycle);
    }
    if (m->is_cell_new) {
        m->is_cell_new = 0;
        if (world->stored) world->stored(world->self, avr_eeprom_address(m), cycle);
    }
    while (m->notes) {
        int note = __builtin_ctz(m->notes);
        m->notes &= (uint8_t)(m->notes - 1);
        if (world->note) world->note(world->self, (enum avr_note)note, m->note_values[note], cycle);
    }
}

static uint64_t least_due(const avr *m)
{
    uint64_t least = AVR_NEVER;
    for (int part = 0; part < AVR_PARTS; part++)
        if (m->due[part] < least) least = m->due[part];
    return least;
}

/* All that parts do at one clock. */
static void events(avr *m, uint64_t at, const avr_world *world)
{
    for (int part = 0; part < AVR_PARTS; part++)
        if (m->due[part] <= at) event(m, part, at, world);
    if (m->asleep && m->asking & m->waking && m->sreg & FLAG_I) avr_wake(m, at);
    tell(m, world, at);
}

/* What asked has been heard, at m->t. RXC, UDRE, TWINT, EE_READY, SPM_READY and a low level ask until what they ask for is done. */
static void taken(avr *m, int vector)
{
    uint8_t *d = m->data;
    static const uint8_t timers[3] = {OCFA, OCFB, TOV};
    switch (vector) {
    case VECTOR_INT0: case VECTOR_INT1: d[EIFR] &= (uint8_t)~(1 << (vector - VECTOR_INT0)); break;
    case VECTOR_PCINT0: case VECTOR_PCINT1: case VECTOR_PCINT2: d[PCIFR] &= (uint8_t)~(1 << (vector - VECTOR_PCINT0)); break;
    case VECTOR_WDT: d[WDTCSR] &= (uint8_t) ~(d[WDTCSR] & WDE ? WDIF | WDIE : WDIF); break;
    case VECTOR_T2_COMPA: case VECTOR_T2_COMPB: case VECTOR_T2_OVF: avr_timer_clear(m, 2, timers[vector - VECTOR_T2_COMPA], m->t); break;
    case VECTOR_T1_CAPT: avr_timer_clear(m, 1, ICF1, m->t); break;
    case VECTOR_T1_COMPA: case VECTOR_T1_COMPB: case VECTOR_T1_OVF: avr_timer_clear(m, 1, timers[vector - VECTOR_T1_COMPA], m->t); break;
    case VECTOR_T0_COMPA: case VECTOR_T0_COMPB: case VECTOR_T0_OVF: avr_timer_clear(m, 0, timers[vector - VECTOR_T0_COMPA], m->t); break;
    case VECTOR_SPI: d[SPSR] &= (uint8_t)~SPIF; break;
    case VECTOR_TX: d[UCSR0A] &= (uint8_t)~TXC; break;
    case VECTOR_ADC: d[ADCSRA] &= (uint8_t)~ADIF; break;
    case VECTOR_COMPARATOR: d[ACSR] &= (uint8_t)~ACI; break;
    default: break;
    }
    avr_ask(m);
}

/* What begins at t, and how long it takes, is settled by what is at t: nothing that happens in between changes it. */
static void plan(avr *m)
{
    int may_enter = m->sreg & FLAG_I && m->asking && !m->is_held && m->t >= m->ivsel_armed;
    m->is_held = 0;
    m->entered = may_enter ? (uint8_t)__builtin_ctz(m->asking) : 0;
    if (may_enter) taken(m, m->entered); /* what rises while it is entered, stays */
    m->planned = (uint8_t)(may_enter ? 4 : avr_length(m));
}

static void perform(avr *m)
{
    int planned = m->planned, kind = avr_kind_of(avr_op_at(m, m->pc));
    uint64_t began = m->t;
    unsigned pc = m->entered ? m->entered * 2u : m->pc;
    m->planned = 0;
    m->attention = 0;
    if (m->entered) {
        m->is_passing = 0;
        avr_enter(m, m->entered);
        m->entered = 0;
    } else if (kind == OP_SBIC || kind == OP_SBIS) { /* its bit was looked at when it began */
        m->is_passing = 0;
        m->pc = (m->pc + planned) & (AVR_FLASH_WORDS - 1);
        m->t += (uint64_t)planned;
    } else {
        avr_execute(m);
    }
    if (m->debug.is_counting) avr_debug_counted(m, pc, began);
}

/* Instructions alone, up to a clock: each is counted, and before the next it may halt. */
static void run_debugged(avr *m, uint64_t end)
{
    do {
        uint64_t began = m->t;
        unsigned pc = m->pc;
        m->attention = 1; /* one; what it does may ask for a look */
        avr_execute(m);
        if (m->debug.is_counting && m->t > began) avr_debug_counted(m, pc, began);
    } while (m->attention && m->t < end && !m->is_stopped && !avr_debug_halts(m));
}

/* The next thing up to a clock; 0: there is none. */
static int step(avr *m, uint64_t end, const avr_world *world)
{
    uint64_t event = least_due(m);
    if (m->asleep || m->t > end || event <= m->t) {
        if (event > end) return 0;
        events(m, event, world);
        return 1;
    }
    if (!m->planned) {
        if (m->debug.is_on && avr_debug_halts(m)) return 0;
        uint64_t free = event - 1 < end ? event - 1 : end; /* up to it there are instructions alone */
        int is_calm = !m->is_held && !(m->asking && m->sreg & FLAG_I);
        if (is_calm && free >= LONGEST && m->t <= free - LONGEST) {
            m->attention = free - LONGEST + 1;
            if (m->debug.is_on) run_debugged(m, m->attention);
            else avr_execute(m);
            goto told;
        }
        uint8_t was_held = m->is_held;
        plan(m);
        if (!m->entered && avr_kind_of(m->ops[m->pc]) == OP_BREAK && !m->is_passing) {
            m->is_held = was_held;
            m->planned = 0;
            m->reached = m->t;
            m->is_at_break = m->is_stopped = 1;
            return 1;
        }
        event = least_due(m); /* a flag that was cleared is looked for again */
    }
    uint64_t over = m->t + m->planned, last = over;
    int kind = avr_kind_of(avr_op_at(m, m->pc));
    if (!m->entered && !avr_is_writing(kind)) last--;
    if (over > end) last = end;
    if (event <= last) {
        events(m, event, world);
        return 1;
    }
    if (over > end) return 0;
    perform(m);
told:
    m->reached = m->t;
    if (m->asleep && m->asking & m->waking && m->sreg & FLAG_I) avr_wake(m, m->t);
    if ((m->changed_pins & m->watched) || m->is_frame_new || m->is_page_new || m->is_cell_new || m->notes) tell(m, world, m->reached);
    return 1;
}

void avr_run_until(avr *m, uint64_t until, const avr_world *world)
{
    m->is_stopped = 0;
    if (!m->is_running) return;
    m->is_passing |= m->is_at_break;
    m->is_at_break = 0;
    tell(m, world, avr_inner(m, m->cycle));
    while (!m->is_stopped) {
        if (until < m->clock_base) break;
        uint64_t end = m->clock_from + ((until - m->clock_base) >> m->clock_shift);
        if (!step(m, end, world)) break;
    }
}
