#include "avr_interrupt.h"

#include "avr_pins.h"
#include "avr_registers.h"

/* COMPA, COMPB, OVF: in this order, by bits 1, 2, 0 of TIFR and TIMSK. */
static uint32_t of_timer(uint8_t flags, int first) { return (uint32_t)((flags >> 1 & 3) | (flags & TOV) << 2) << first; }

static uint32_t if_so(int is_so, int vector) { return (uint32_t)(is_so != 0) << vector; }

/* INTn with ISC 0 asks as long as its pin is low. */
static uint32_t of_level(const avr *m, int n)
{
    int is_level = !(m->data[EICRA] >> 2 * n & 3), is_low = !(m->port[AVR_PORT_D].seen >> (2 + n) & 1);
    return if_so(m->data[EIMSK] >> n & 1 && (is_level ? is_low : m->data[EIFR] >> n & 1), VECTOR_INT0 + n);
}

void avr_ask(avr *m)
{
    const uint8_t *d = m->data;
    uint8_t serial = d[UCSR0A] & d[UCSR0B] & (RXC | TXC | UDRE);
    uint8_t one = d[TIFR1] & d[TIMSK1];
    m->asking = of_level(m, 0) | of_level(m, 1) | (uint32_t)(d[PCIFR] & d[PCICR] & 7) << VECTOR_PCINT0 |
                if_so(d[WDTCSR] & WDIF && d[WDTCSR] & WDIE, VECTOR_WDT) | of_timer(d[TIFR2] & d[TIMSK2], VECTOR_T2_COMPA) |
                if_so(one & ICF1, VECTOR_T1_CAPT) | of_timer(one, VECTOR_T1_COMPA) |
                of_timer(d[TIFR0] & d[TIMSK0], VECTOR_T0_COMPA) | if_so(d[SPSR] & SPIF && d[SPCR] & SPIE, VECTOR_SPI) |
                if_so(serial & RXC, VECTOR_RX) | if_so(serial & UDRE, VECTOR_UDRE) | if_so(serial & TXC, VECTOR_TX) |
                if_so(d[ADCSRA] & ADIF && d[ADCSRA] & ADIE, VECTOR_ADC) |
                if_so(d[EECR] & EERIE && !(d[EECR] & EEPE), VECTOR_EE_READY) |
                if_so(d[ACSR] & ACI && d[ACSR] & ACIE, VECTOR_COMPARATOR) |
                if_so(d[TWCR] & TWINT && d[TWCR] & TWIE, VECTOR_TWI) |
                if_so(d[SPMCSR] & SPMIE && !(d[SPMCSR] & SPMEN), VECTOR_SPM_READY);
    if (m->asking) m->attention = 0;
}

void avr_interrupt_edges(avr *m, int port, uint8_t level, uint8_t before)
{
    uint8_t changes = level ^ before, *d = m->data;
    if (changes & d[PCMSK0 + port]) d[PCIFR] |= (uint8_t)(1 << port);
    for (int n = 0; n < 2 && port == AVR_PORT_D && !m->is_frozen; n++) { /* edges need the I/O clock */
        int bit = 2 + n, sense = d[EICRA] >> 2 * n & 3;
        if (changes >> bit & 1 && (sense == 1 || sense == (level >> bit & 1) + 2)) d[EIFR] |= (uint8_t)(1 << n);
    }
    avr_ask(m);
}
