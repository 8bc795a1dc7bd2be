#include "avr_io.h"

#include "avr_adc.h"
#include "avr_clocked.h"
#include "avr_crystal.h"
#include "avr_line.h"
#include "avr_pins.h"
#include "avr_power.h"
#include "avr_registers.h"
#include "avr_sender.h"
#include "avr_spi.h"
#include "avr_time.h"
#include "avr_timer.h"
#include "avr_twi.h"
#include "avr_usart.h"

enum { ARMED_CLOCKS = 4 }; /* of timed sequences */

/* Bit of PRR that stops what a register belongs to: it is unreadable then. */
static uint8_t gate_of(unsigned address)
{
    switch (address) {
    case TCCR0A: case TCCR0B: case TCNT0: case OCR0A: case OCR0B: return PRTIM0;
    case TCCR2A: case TCCR2B: case TCNT2: case OCR2A: case OCR2B: return PRTIM2;
    case SPCR: case SPSR: case SPDR: return PRSPI;
    case ADCL: case ADCH: case ADCSRA: case ADMUX: return PRADC;
    default: break;
    }
    if (address >= TCCR1A && address <= OCR1BH) return PRTIM1;
    if (address >= TWBR && address <= TWAMR) return PRTWI;
    return address >= UCSR0A && address <= UDR0 ? PRUSART : 0;
}

static int is_off(const avr *m, unsigned address)
{
    uint8_t off = m->data[PRR];
    return off && off & gate_of(address) & (avr_is_asynchronous(m) ? ~PRTIM2 : 0xff);
}

/* PIND has the serial line in it, too. */
static uint8_t load_pins(avr *m, int port, uint64_t at)
{
    uint8_t level = avr_pins_read(m, port, at) & (uint8_t)~avr_pins_disabled(m, port);
    if (port != AVR_PORT_D || !at) return level;
    if (m->usart.heard_count && !(m->port[AVR_PORT_D].driven & 1) && !avr_line_level(&m->usart, avr_outer(m, at - 1))) level &= 0xfe;
    if (m->usart.is_sending && !avr_is_clocked(m) && at > m->port[AVR_PORT_D].changed) level = (uint8_t)((level & ~2) | avr_sender_level(m, at - 1) << 1);
    return level;
}

/* A register whose bit begins a timed sequence: the bit goes when that is over. */
static uint8_t armed(avr *m, unsigned address, uint8_t bit, uint64_t until, uint64_t at)
{
    if (at >= until) m->data[address] &= (uint8_t)~bit;
    return m->data[address];
}

uint8_t avr_load(avr *m, unsigned address, uint64_t at)
{
    if (address >= AVR_DATA_BYTES) return 0;
    if (address < 0x20 || address >= 0x100) return m->data[address];
    if (is_off(m, address)) return 0;
    switch (address) {
    case PINB: return load_pins(m, AVR_PORT_B, at);
    case PINC: return load_pins(m, AVR_PORT_C, at);
    case PIND: return load_pins(m, AVR_PORT_D, at);
    case SREG: return m->sreg;
    case SPL: return (uint8_t)m->sp;
    case SPH: return (uint8_t)(m->sp >> 8);
    case TCNT0: case OCR0A: case OCR0B: case TCNT2: case OCR2A: case OCR2B: case TCCR2A: case TCCR2B: case TCNT1L: case TCNT1H: case ICR1L:
    case ICR1H: case OCR1AL: case OCR1AH: case OCR1BL: case OCR1BH: return avr_timer_load(m, address, at);
    case UDR0: return avr_usart_load(m, address, at);
    case ADCL: case ADCH: return avr_adc_load(m, address);
    case SPSR: case SPDR: return avr_spi_load(m, address);
    case ACSR: avr_comparator_use(m, at); return m->data[ACSR];
    case EECR: return armed(m, address, EEMPE, m->eeprom_armed, at);
    case WDTCSR: return armed(m, address, WDCE, m->watchdog_armed, at);
    case MCUCR: return armed(m, address, IVCE, m->ivsel_armed, at);
    case CLKPR: return (uint8_t)(m->data[CLKPR] | (at < m->clkpr_armed ? CLKPCE : 0));
    default: return m->data[address];
    }
}

static void toggle(avr *m, int port, uint8_t bits, uint64_t at)
{
    static const uint16_t latches[3] = {PORTB, PORTC, PORTD};
    m->data[latches[port]] ^= bits;
    avr_pins_refresh(m, port, at);
}

static void cleared(avr *m, unsigned address, uint8_t bits)
{
    m->data[address] &= (uint8_t)~bits;
    avr_ask(m);
}

static void store_sreg(avr *m, uint8_t value)
{
    if (value & ~m->sreg & FLAG_I) m->is_held = 1, m->attention = 0;
    m->sreg = value;
}

/* IVSEL changes within a timed sequence; no interrupt is entered in it, nor before the instruction after its end. */
static void store_mcucr(avr *m, uint8_t value, uint64_t at)
{
    uint8_t was = m->data[MCUCR], kept = was & IVCE && at <= m->ivsel_armed && !(value & IVCE) ? value & IVSEL : was & IVSEL;
    int is_over = was & IVCE && !(value & IVCE);
    m->data[MCUCR] = (uint8_t)((value & (PUD | IVCE)) | kept);
    m->ivsel_armed = value & IVCE ? at + ARMED_CLOCKS : 0;
    if (is_over) m->is_held = 1, m->attention = 0;
    for (int port = 0; port < 3; port++) avr_pins_refresh(m, port, at);
}

/* From the next clock on, clocks have another length. What counts them goes on counting; what has an oscillator of its own takes
   the time that it takes. */
static void store_clkpr(avr *m, uint8_t value, uint64_t at)
{
    if (value == CLKPCE) {
        if (at >= m->clkpr_armed) m->clkpr_armed = at + ARMED_CLOCKS; /* written again within them, it has no longer */
    } else if (!(value & CLKPCE) && at <= m->clkpr_armed) {
        static const enum avr_part own_oscillators[3] = {AVR_PART_EEPROM, AVR_PART_SPM, AVR_PART_WATCHDOG};
        int was = m->clock_shift;
        avr_set_clock_shift(m, value & 15, at);
        for (int i = 0; i < 3; i++) {
            uint64_t *due = &m->due[own_oscillators[i]];
            if (*due != AVR_NEVER) *due = at + (((*due - at) << was) >> m->clock_shift);
        }
        m->data[CLKPR] = value & 15;
        m->clkpr_armed = 0;
    }
}

/* A register that says what asks for an interrupt. */
static void store_asking(avr *m, unsigned address, uint8_t value)
{
    m->data[address] = value;
    avr_ask(m);
}

void avr_store(avr *m, unsigned address, uint8_t value, uint64_t at)
{
    if (address >= AVR_DATA_BYTES) return;
    if (address < 0x20 || address >= 0x100) {
        m->data[address] = value;
        return;
    }
    if (is_off(m, address)) return;
    if (address <= PORTD) avr_mean_changes(m);
    switch (address) {
    case PINB: toggle(m, AVR_PORT_B, value, at); break;
    case PINC: toggle(m, AVR_PORT_C, value & 0x7f, at); break;
    case PIND: toggle(m, AVR_PORT_D, value, at); break;
    case PORTB: m->data[address] = value; avr_pins_refresh(m, AVR_PORT_B, at); break;
    case DDRB:
        m->data[address] = value;
        avr_pins_refresh(m, AVR_PORT_B, at);
        avr_spi_look(m, at);
        break;
    case DDRC: case PORTC: m->data[address] = value & 0x7f; avr_pins_refresh(m, AVR_PORT_C, at); break;
    case PORTD: m->data[address] = value; avr_pins_refresh(m, AVR_PORT_D, at); break;
    case DDRD:
        m->data[address] = value;
        avr_pins_refresh(m, AVR_PORT_D, at);
        if (avr_is_clocked(m)) avr_clocked_look(m, at);
        break;
    case TIFR0: case TIFR1: case TIFR2: avr_timer_clear(m, (int)address - TIFR0, value, at); avr_ask(m); break;
    case PCIFR: cleared(m, address, value & 7); break;
    case EIFR: cleared(m, address, value & 3); break;
    case EIMSK: store_asking(m, address, value & 3); break;
    case EICRA:
        for (int n = 0; n < 2; n++) m->data[EIFR] &= (uint8_t)~(!(value >> 2 * n & 3) << n); /* of a level there is no flag */
        store_asking(m, address, value & 15);
        break;
    case PCMSK0: case PCMSK2: store_asking(m, address, value); break;
    case PCMSK1: store_asking(m, address, value & 0x7f); break;
    case PCICR: case TIMSK0: case TIMSK2: store_asking(m, address, value & 7); break;
    case TIMSK1: store_asking(m, address, value & 0x27); break;
    case GTCCR: m->data[address] = value; avr_timer_gates(m, at); break;
    case ASSR:
        avr_timer_advance(m, 2, at);
        m->data[address] = (uint8_t)((value & (EXCLK | AS2)) | (value & AS2 ? m->data[ASSR] & ~(EXCLK | AS2) : 0));
        avr_timer_gates(m, at);
        break;
    case PRR: avr_power_store(m, value, at); break;
    case TCCR0A: case TCCR0B: case TCNT0: case OCR0A: case OCR0B: case TCCR2A: case TCCR2B: case TCNT2: case OCR2A: case OCR2B:
    case TCCR1A: case TCCR1B: case TCCR1C: case TCNT1L: case TCNT1H: case ICR1L: case ICR1H: case OCR1AL: case OCR1AH: case OCR1BL:
    case OCR1BH: avr_timer_store(m, address, value, at); break;
    case EECR: avr_eeprom_store(m, value, at); break;
    case EEDR: case EEARL: if (!(m->data[EECR] & EEPE)) m->data[address] = value; break;
    case EEARH: if (!(m->data[EECR] & EEPE)) m->data[address] = value & 3; break;
    case SMCR: m->data[address] = value & 15; break;
    case MCUSR: m->data[address] &= value; break; /* flags are cleared by writing 0 */
    case MCUCR: store_mcucr(m, value, at); break;
    case SPMCSR: avr_spm_store(m, value, at); break;
    case SPL: m->sp = (uint16_t)((m->sp & 0xff00) | value); break;
    case SPH: m->sp = (uint16_t)((m->sp & 0xff) | value << 8); break;
    case SREG: store_sreg(m, value); break;
    case WDTCSR: avr_watchdog_store(m, value, at); break;
    case CLKPR: store_clkpr(m, value, at); break;
    case ADCL: case ADCH: break;
    case SPCR: case SPSR: case SPDR: avr_spi_store(m, address, value, at); break;
    case TWBR: case TWSR: case TWAR: case TWDR: case TWCR: case TWAMR: avr_twi_store(m, address, value, at); break;
    case ADCSRA: case ADCSRB: case ADMUX: avr_adc_store(m, address, value, at); break;
    case ACSR:
        m->data[ACSR] = (uint8_t)((value & ~(ACO | ACI)) | (m->data[ACSR] & ACO) | (m->data[ACSR] & ~value & ACI));
        avr_comparator_use(m, at);
        avr_ask(m);
        break;
    case UCSR0A: case UCSR0B: case UCSR0C: case UBRR0L: case UBRR0H: case UDR0: avr_usart_store(m, address, value, at); break;
    default: m->data[address] = value; break;
    }
}

void avr_set_bit(avr *m, unsigned address, uint8_t bit, uint64_t at)
{
    switch (address) {
    case PINB: case PINC: case PIND: case TIFR0: case TIFR1: case TIFR2: case PCIFR: case EIFR: avr_store(m, address, bit, at); break;
    default: avr_store(m, address, avr_load(m, address, at - 1) | bit, at); break;
    }
}

void avr_clear_bit(avr *m, unsigned address, uint8_t bit, uint64_t at)
{
    switch (address) {
    case PINB: case PINC: case PIND: case TIFR0: case TIFR1: case TIFR2: case PCIFR: case EIFR: break;
    default: avr_store(m, address, avr_load(m, address, at - 1) & (uint8_t)~bit, at); break;
    }
}
