#include "avr_sender.h"

#include "avr_frame.h"
#include "avr_pins.h"
#include "avr_registers.h"
#include "avr_time.h"

enum { RXD = 1, TXD = 2 }; /* bits of port D */

unsigned avr_sender_over(const avr *m, uint64_t at)
{
    const avr_usart *u = &m->usart;
    uint32_t bit = avr_frame_bit(m);
    at = avr_io_clock(m, at);
    if (m->data[PRR] & PRUSART && at > m->gated[AVR_PART_SEND]) at = m->gated[AVR_PART_SEND];
    if (at < u->bit_from) return u->bits_over; /* the crystal starts up */
    return bit ? u->bits_over + (unsigned)((at - u->bit_from) / bit) : u->bits_over;
}

int avr_sender_level(const avr *m, uint64_t at)
{
    const avr_usart *u = &m->usart;
    return !u->is_sending || u->levels >> avr_sender_over(m, at) & 1;
}

uint64_t avr_sender_next_level(const avr *m, uint64_t after)
{
    const avr_usart *u = &m->usart;
    if (!u->is_sending || !avr_frame_bit(m) || m->is_frozen) return AVR_NEVER;
    return u->bit_from + (uint64_t)avr_frame_bit(m) * (avr_sender_over(m, after) - u->bits_over + 1);
}

void avr_sender_show(avr *m, uint64_t at)
{
    int sends = m->data[UCSR0B] & TXEN || m->usart.is_sending;
    avr_pins_own(m, AVR_PORT_D, TXD, sends, avr_sender_level(m, at));
    avr_pins_direct(m, AVR_PORT_D, TXD, sends, 0);
    avr_pins_direct(m, AVR_PORT_D, RXD, 0, m->data[UCSR0B] & RXEN);
    avr_pins_refresh(m, AVR_PORT_D, at);
    avr_due(m, AVR_PART_LINE, at + 1);
}

void avr_sender_schedule(avr *m)
{
    const avr_usart *u = &m->usart;
    if (u->is_sending) avr_due(m, AVR_PART_SEND, avr_frame_bit(m) ? u->bit_from + (uint64_t)avr_frame_bit(m) * (u->frame_bits - u->bits_over) : AVR_NEVER);
}

void avr_sender_begin(avr *m, uint32_t bit_clocks, uint64_t at)
{
    avr_usart *u = &m->usart;
    int data_bits = avr_frame_data_bits(m), bits = avr_frame_bits(m), stops = m->data[UCSR0C] & USBS ? 2 : 1;
    unsigned data = u->waiting & ((1u << data_bits) - 1);
    if (bits > data_bits) data |= (unsigned)avr_frame_parity(m, data) << data_bits;
    u->frame = (avr_character){avr_outer(m, at), (bit_clocks << 8) << m->clock_shift, (uint16_t)data, (uint8_t)bits, 0,
                               (uint8_t)avr_frame_framing(m)};
    u->levels = (uint16_t)(data << 1 | 0xffffu << (bits + 1));
    u->frame_bits = (uint8_t)(1 + bits + stops);
    u->bits_over = 0;
    u->bit_from = at;
    u->is_waiting = 0;
    u->is_sending = 1;
    m->is_frame_new = 1;
    m->data[UCSR0A] |= UDRE;
    avr_sender_schedule(m);
}
