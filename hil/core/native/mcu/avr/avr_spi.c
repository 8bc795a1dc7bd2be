#include "avr_spi.h"

#include "avr_interrupt.h"
#include "avr_pins.h"
#include "avr_registers.h"
#include "avr_time.h"

enum { SS = 1 << 2, MOSI = 1 << 3, MISO = 1 << 4, SCK = 1 << 5 }; /* of port B */
enum { HALVES = 16 /* of a byte's bits */ };

static int is_master(const avr *m) { return m->data[SPCR] & MSTR; }

/* Clocks of half a bit: table Relationship Between SCK and the Oscillator Frequency. */
static uint64_t half(const avr *m)
{
    static const uint8_t shifts[4] = {1, 3, 5, 6};
    return 1ull << (shifts[m->data[SPCR] & 3] - (m->data[SPSR] & SPI2X ? 1 : 0));
}

static int bit_out(const avr *m) { return m->data[SPCR] & DORD ? m->spi.shifting & 1 : m->spi.shifting >> 7; }

static void bit_in(avr *m, int bit)
{
    uint8_t *shifting = &m->spi.shifting;
    *shifting = (uint8_t)(m->data[SPCR] & DORD ? *shifting >> 1 | bit << 7 : *shifting << 1 | bit);
}

/* Who drives which pin: table SPI Pin Overrides. Those that a part drives still need their DDR bit. */
static void show(avr *m, uint64_t at)
{
    const avr_spi *s = &m->spi;
    int is_on = m->data[SPCR] & SPE, master = is_on && is_master(m), slave = is_on && !is_master(m);
    avr_pins_own(m, AVR_PORT_B, MOSI, master, s->out);
    avr_pins_own(m, AVR_PORT_B, SCK, master, s->is_clock_high);
    avr_pins_own(m, AVR_PORT_B, MISO, slave, s->out);
    avr_pins_direct(m, AVR_PORT_B, MOSI | SCK | SS, 0, slave);
    if (master) avr_pins_direct(m, AVR_PORT_B, SS | MOSI | SCK, 0, 0);
    avr_pins_direct(m, AVR_PORT_B, MISO, 0, master || (slave && !s->is_selected));
    avr_pins_refresh(m, AVR_PORT_B, at);
}

static void done(avr *m)
{
    m->spi.received = m->spi.shifting;
    m->spi.halves = 0;
    m->data[SPSR] |= SPIF;
    avr_ask(m);
}

/* Half a bit on: each bit has a leading and a trailing edge of SCK; CPHA says at which one data is taken. */
void avr_spi_event(avr *m, uint64_t at)
{
    avr_spi *s = &m->spi;
    int is_leading = !(s->halves & 1), is_taken = is_leading != (m->data[SPCR] & CPHA ? 1 : 0);
    s->is_clock_high = is_leading != (m->data[SPCR] & CPOL ? 1 : 0);
    if (is_taken) s->is_high_in = avr_pins_read(m, AVR_PORT_B, at) / MISO & 1;
    if (is_taken && m->data[SPCR] & CPHA) bit_in(m, s->is_high_in);
    if (!is_taken) {
        if (!(m->data[SPCR] & CPHA)) bit_in(m, s->is_high_in);
        s->out = (uint8_t)bit_out(m);
    }
    s->halves++;
    avr_due(m, AVR_PART_SPI, s->halves < HALVES ? at + half(m) : AVR_NEVER);
    if (s->halves == HALVES) done(m);
    show(m, at);
}

void avr_spi_look(avr *m, uint64_t at)
{
    int is_low = !(m->port[AVR_PORT_B].level & SS);
    if (!(m->data[SPCR] & SPE) || !is_master(m) || m->data[DDRB] & SS || !is_low || m->data[PRR] & PRSPI) return;
    m->data[SPCR] &= (uint8_t)~MSTR;
    m->data[SPSR] |= SPIF;
    m->spi.halves = 0;
    m->spi.is_selected = 1;
    avr_due(m, AVR_PART_SPI, AVR_NEVER);
    avr_ask(m);
    show(m, at);
}

/* A slave goes by SCK while SS is low. */
void avr_spi_edges(avr *m, uint8_t level, uint8_t before, uint64_t at)
{
    avr_spi *s = &m->spi;
    uint8_t changes = level ^ before, control = m->data[SPCR];
    if (!(control & SPE) || m->data[PRR] & PRSPI) return;
    if (is_master(m)) {
        if (changes & before & SS) avr_spi_look(m, at);
        return;
    }
    if (changes & SS) {
        s->is_selected = !(level & SS);
        s->halves = 0;
        s->out = (uint8_t)bit_out(m);
    }
    if (changes & SCK && s->is_selected) {
        int is_leading = !(level & SCK) == !!(control & CPOL), is_taken = is_leading != (control & CPHA ? 1 : 0);
        if (is_taken) {
            bit_in(m, level / MOSI & 1);
            s->halves = (uint8_t)(s->halves + 2);
            if (s->halves == HALVES) done(m);
        } else {
            s->out = (uint8_t)bit_out(m);
        }
    }
    show(m, at);
}

uint8_t avr_spi_load(avr *m, unsigned address)
{
    if (address == SPSR) {
        m->spi.is_seen = m->data[SPSR] & (SPIF | WCOL);
        return m->data[SPSR];
    }
    if (address == SPDR) {
        m->data[SPSR] &= (uint8_t)~m->spi.is_seen;
        m->spi.is_seen = 0;
        avr_ask(m);
        return m->spi.received;
    }
    return m->data[address];
}

void avr_spi_store(avr *m, unsigned address, uint8_t value, uint64_t at)
{
    avr_spi *s = &m->spi;
    switch (address) {
    case SPCR:
        m->data[SPCR] = value;
        if (!(value & SPE)) {
            s->halves = 0;
            avr_due(m, AVR_PART_SPI, AVR_NEVER);
        }
        if (!s->halves) s->is_clock_high = value & CPOL ? 1 : 0;
        s->is_selected = !(m->port[AVR_PORT_B].level & SS);
        avr_spi_look(m, at);
        break;
    case SPSR: m->data[SPSR] = (uint8_t)((m->data[SPSR] & ~SPI2X) | (value & SPI2X)); break;
    case SPDR:
        m->data[SPSR] &= (uint8_t)~m->spi.is_seen;
        s->is_seen = 0;
        if (s->halves || m->due[AVR_PART_SPI] != AVR_NEVER) {
            m->data[SPSR] |= WCOL;
            break;
        }
        s->shifting = value;
        if (!(m->data[SPCR] & SPE)) break;
        if (is_master(m) || !(m->data[SPCR] & CPHA)) s->out = (uint8_t)bit_out(m);
        if (is_master(m)) avr_due(m, AVR_PART_SPI, at + half(m));
        break;
    default: break;
    }
    show(m, at);
    avr_ask(m);
}
