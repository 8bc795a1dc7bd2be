#include "avr_clocked.h"

#include "avr_frame.h"
#include "avr_interrupt.h"
#include "avr_line.h"
#include "avr_pins.h"
#include "avr_receiver.h"
#include "avr_sender.h"
#include "avr_time.h"

enum { XCK = 1 << 4 /* of port D */, BYTE_HALVES = 16 };

/* Clocks of half a period: table Equations for Calculating Baud Rate Register Setting, synchronous master mode. */
static uint64_t half(const avr *m) { return avr_frame_divider(m); }

static int is_enabled(const avr *m) { return m->data[UCSR0B] & (RXEN | TXEN) || m->usart.is_sending; }

/* What was written before the transmitter was turned off goes out, too. */
static int may_begin(const avr *m) { return m->usart.is_waiting && (m->data[UCSR0B] & TXEN || !(m->data[UCSR0A] & UDRE)); }

/* In SPI only a frame makes the clock run; else it runs while the USART is on, by this chip or by another. */
static int has_own_clock(const avr *m) { return avr_is_spi(m) ? m->usart.is_sending : is_enabled(m) && m->data[DDRD] & XCK; }

static int level_in(const avr *m, uint64_t at)
{
    return avr_pins_read(m, AVR_PORT_D, at) & 1 && avr_line_level(&m->usart, avr_outer(m, at));
}

static void show_clock(avr *m, uint64_t at)
{
    avr_pins_own(m, AVR_PORT_D, XCK, avr_is_clocked(m) && is_enabled(m), m->usart.is_clock_high);
    avr_sender_show(m, at);
}

/* ---- SPI ---- */

static int is_lowest_first(const avr *m) { return m->data[UCSR0C] & UDORD; }

static void put_bit(avr *m)
{
    avr_usart *u = &m->usart;
    unsigned n = (u->halves + 1u) / 2;
    u->levels = (uint16_t)(u->frame.bits >> (is_lowest_first(m) ? n : 7 - n) & 1);
}

static void begin_byte(avr *m, uint64_t at)
{
    avr_usart *u = &m->usart;
    avr_receiver_begins(m, at);
    u->frame.bits = u->waiting & 0xff;
    u->is_waiting = 0;
    u->is_sending = 1;
    u->halves = 0;
    u->bits_over = 0;
    u->levels = 1;
    m->data[UCSR0A] |= UDRE;
    if (!(m->data[UCSR0C] & UCPHA)) put_bit(m);
    avr_due(m, AVR_PART_SEND, at + half(m));
}

static void end_byte(avr *m, uint64_t at)
{
    avr_usart *u = &m->usart;
    u->is_sending = 0;
    if (m->data[UCSR0B] & RXEN) avr_receiver_put(m, u->shifted, 0); /* FE, DOR and UPE are unused */
    if (may_begin(m)) {
        begin_byte(m, at);
    } else {
        m->data[UCSR0A] |= TXC;
    }
}

static void byte_half(avr *m, uint64_t at)
{
    avr_usart *u = &m->usart;
    int is_leading = !(u->halves & 1), is_taken = is_leading != (m->data[UCSR0C] & UCPHA ? 1 : 0);
    u->is_clock_high = is_leading != (m->data[UCSR0C] & UCPOL);
    if (is_taken) u->shifted = (uint16_t)(is_lowest_first(m) ? u->shifted >> 1 | level_in(m, at) << 7 : (u->shifted << 1 | level_in(m, at)) & 0xff);
    else if (u->halves < BYTE_HALVES - 1) put_bit(m);
    if (++u->halves < BYTE_HALVES) avr_due(m, AVR_PART_SEND, at + half(m));
    else end_byte(m, at);
}

/* ---- synchronous frames ---- */

static void bit_out(avr *m, uint64_t at)
{
    avr_usart *u = &m->usart;
    uint64_t period = at - u->bit_from;
    if (period > UINT16_MAX) period = UINT16_MAX; /* the clock has stood still */
    u->bit_from = at;
    if (u->is_sending && ++u->bits_over < u->frame_bits) return;
    if (may_begin(m)) {
        avr_sender_begin(m, (uint32_t)(m->data[DDRD] & XCK ? 2 * half(m) : period), at);
    } else if (u->is_sending) {
        u->is_sending = 0;
        m->data[UCSR0A] |= TXC;
    }
}

static void bit_in(avr *m, uint64_t at)
{
    if (m->data[UCSR0B] & RXEN) avr_receiver_take(m, level_in(m, at), at);
}

static void frame_edge(avr *m, int is_high, uint64_t at)
{
    if (is_high == !(m->data[UCSR0C] & UCPOL)) bit_out(m, at); /* table UCPOL0 Bit Settings */
    else bit_in(m, at);
}

/* ---- */

void avr_clocked_event(avr *m, uint64_t at)
{
    avr_usart *u = &m->usart;
    m->due[AVR_PART_SEND] = AVR_NEVER;
    if (avr_is_spi(m)) {
        if (u->is_sending) byte_half(m, at);
        else if (may_begin(m)) begin_byte(m, at);
    } else if (has_own_clock(m)) {
        u->is_clock_high = !u->is_clock_high;
        frame_edge(m, u->is_clock_high, at);
        avr_due(m, AVR_PART_SEND, at + half(m));
    }
    show_clock(m, at);
    avr_ask(m);
}

void avr_clocked_edge(avr *m, int is_high, uint64_t at)
{
    if (avr_is_spi(m) || m->data[DDRD] & XCK || !is_enabled(m) || m->data[PRR] & PRUSART) return;
    frame_edge(m, is_high, at);
    show_clock(m, at);
    avr_ask(m);
}

void avr_clocked_look(avr *m, uint64_t at)
{
    avr_usart *u = &m->usart;
    int is_due = m->due[AVR_PART_SEND] != AVR_NEVER || m->data[PRR] & PRUSART;
    if (avr_is_spi(m) && !u->is_sending) {
        u->is_clock_high = m->data[UCSR0C] & UCPOL;
        if (may_begin(m) && !is_due) avr_due(m, AVR_PART_SEND, at + 1);
    } else if (has_own_clock(m) && !is_due) {
        avr_due(m, AVR_PART_SEND, at + half(m));
    }
    show_clock(m, at);
}
