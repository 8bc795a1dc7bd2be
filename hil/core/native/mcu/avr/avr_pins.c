#include "avr_pins.h"

#include "avr_registers.h"
#include "avr_time.h"

static const uint16_t PINS_OF[3] = {PINB, PINC, PIND};
static const int FIRST[3] = {8, 14, 0}; /* number of a port's bit 0 */
static const int BITS[3] = {6, 6, 8};

uint8_t avr_pins_disabled(const avr *m, int port)
{
    return port == AVR_PORT_C ? m->data[DIDR0] & 0x3f : port == AVR_PORT_D ? (uint8_t)(m->data[DIDR1] << 6) : 0;
}

uint8_t avr_pins_cared(const avr *m, int port)
{
    const uint8_t *d = m->data;
    uint8_t cared = d[PCMSK0 + port] & (uint8_t)~avr_pins_disabled(m, port);
    if (port == AVR_PORT_B) return (uint8_t)(cared | 1 | (d[SPCR] & SPE ? 0x2c : 0)); /* ICP1; SS, MOSI, SCK */
    if (port == AVR_PORT_C) return (uint8_t)(cared | (d[TWCR] & TWEN ? 0x30 : 0));
    if (d[EICRA] & 3 || d[EIMSK] & 1) cared |= 4;
    if (d[EICRA] & 12 || d[EIMSK] & 2) cared |= 8;
    if ((d[TCCR0B] & 7) >= 6 || (d[UCSR0C] & UMSEL && !(d[DDRD] & 16))) cared |= 16; /* T0, XCK */
    if ((d[TCCR1B] & 7) >= 6) cared |= 32;
    if ((m->adc.is_comparator_used && !(d[ACSR] & ACD)) || (d[ADCSRA] & ADATE && (d[ADCSRB] & ADTS) == 1)) cared |= 0xc0; /* AIN0, AIN1 */
    return cared;
}

static void changed(avr *m, int port, uint8_t level, uint64_t at)
{
    avr_port *p = &m->port[port];
    uint8_t changes = p->level ^ level, cared = avr_pins_cared(m, port);
    if (p->changed != at) {
        p->before = p->level;
        p->changed = at;
    }
    p->level = level;
    p->seen = (uint8_t)((p->seen & cared) | (level & ~cared));
    if (!(changes & cared)) return;
    for (int i = m->edge_count; i-- > 0;) { /* of one clock, the last level counts */
        avr_edge *e = &m->edges[(m->edge_first + i) % AVR_EDGES];
        if (e->due != at + AVR_EDGE_CLOCKS) break;
        if (e->port == port) {
            e->level = level;
            e->cared |= cared;
            return;
        }
    }
    if (m->edge_count == AVR_EDGES) return;
    m->edges[(m->edge_first + m->edge_count++) % AVR_EDGES] = (avr_edge){at + AVR_EDGE_CLOCKS, (uint8_t)port, level, cared};
    if (m->edge_count == 1) avr_due(m, AVR_PART_PINS, at + AVR_EDGE_CLOCKS);
}

void avr_pins_refresh(avr *m, int port, uint64_t at)
{
    avr_port *p = &m->port[port];
    uint8_t latch = m->data[PINS_OF[port] + 2], direction = m->data[PINS_OF[port] + 1];
    uint8_t driven = (uint8_t)((direction | p->as_output) & ~p->as_input);
    uint8_t value = (uint8_t)((latch & ~p->own) | (p->own_level & p->own));
    uint8_t pulled = m->data[MCUCR] & PUD ? 0 : latch;
    uint8_t level = (uint8_t)((driven & value) | (~driven & ((p->outside & p->forced) | (~p->outside & pulled))));
    p->driven = driven;
    p->value = value;
    m->changed_pins |= (uint32_t)((1 << BITS[port]) - 1) << FIRST[port];
    if (m->changed_pins & m->watched) m->attention = 0;
    if (level != p->level) changed(m, port, level, at);
}

void avr_pins_own(avr *m, int port, uint8_t bits, int is_own, int level)
{
    avr_port *p = &m->port[port];
    p->own = (uint8_t)(is_own ? p->own | bits : p->own & ~bits);
    p->own_level = (uint8_t)(level ? p->own_level | bits : p->own_level & ~bits);
}

void avr_pins_direct(avr *m, int port, uint8_t bits, int as_output, int as_input)
{
    avr_port *p = &m->port[port];
    p->as_output = (uint8_t)(as_output ? p->as_output | bits : p->as_output & ~bits);
    p->as_input = (uint8_t)(as_input ? p->as_input | bits : p->as_input & ~bits);
}

enum avr_drive avr_pins_drive(const avr *m, int port, uint8_t bit)
{
    const avr_port *p = &m->port[port];
    if (p->driven & bit) return p->value & bit ? AVR_HIGH : AVR_LOW;
    return m->data[PINS_OF[port] + 2] & bit && !(m->data[MCUCR] & PUD) ? AVR_PULLED_UP : AVR_OPEN;
}
