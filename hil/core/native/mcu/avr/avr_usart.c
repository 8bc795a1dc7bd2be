#include "avr_usart.h"

#include "avr_clocked.h"
#include "avr_frame.h"
#include "avr_interrupt.h"
#include "avr_receiver.h"
#include "avr_registers.h"
#include "avr_sender.h"
#include "avr_time.h"

void avr_usart_sent(avr *m, uint64_t at)
{
    avr_usart *u = &m->usart;
    if (avr_is_clocked(m)) {
        avr_clocked_event(m, at);
        return;
    }
    int was_sending = u->is_sending;
    u->is_sending = 0;
    m->due[AVR_PART_SEND] = AVR_NEVER;
    int is_pending = u->is_waiting && (m->data[UCSR0B] & TXEN || !(m->data[UCSR0A] & UDRE)); /* that too goes out when it is turned off */
    if (is_pending) avr_sender_begin(m, avr_frame_bit(m), at);
    else if (was_sending) m->data[UCSR0A] |= TXC;
    avr_sender_show(m, at);
    avr_ask(m);
}

static void send(avr *m, uint8_t value, uint64_t at)
{
    avr_usart *u = &m->usart;
    if (!(m->data[UCSR0A] & UDRE)) return; /* ignored: DS40002061, UDRn */
    u->waiting = (uint16_t)(value | (m->data[UCSR0B] & TXB8) << 8);
    u->is_waiting = 1;
    if (!(m->data[UCSR0B] & TXEN)) return; /* the last one goes out when it is turned on */
    m->data[UCSR0A] &= (uint8_t)~UDRE;
    if (avr_is_clocked(m)) avr_clocked_look(m, at);
    else if (!u->is_sending) avr_due(m, AVR_PART_SEND, at + 1);
    avr_ask(m);
}

/* Bits that are over keep their length; those to come get another one. */
static void rate_changes(avr *m, uint64_t at)
{
    avr_usart *u = &m->usart;
    uint32_t bit = avr_frame_bit(m);
    avr_receiver_rate(m, at);
    if (!u->is_sending || !bit) return;
    unsigned now = avr_sender_over(m, at);
    u->bit_from += (uint64_t)bit * (now - u->bits_over);
    u->bits_over = (uint8_t)now;
}

static void rate_changed(avr *m, uint64_t at)
{
    avr_usart *u = &m->usart;
    if (avr_is_clocked(m)) {
        m->due[AVR_PART_RECEIVE] = AVR_NEVER;
        avr_clocked_look(m, at);
        return;
    }
    if (u->is_receiving) avr_receiver_resume(m, at);
    else avr_receiver_look(m, at);
    avr_sender_schedule(m);
    if (u->is_sending && m->due[AVR_PART_SEND] <= at) avr_due(m, AVR_PART_SEND, at + 1);
    avr_sender_show(m, at);
}

/* What is under way in the mode before is lost. */
static void mode_changes(avr *m, uint64_t at)
{
    avr_usart *u = &m->usart;
    u->is_sending = u->is_receiving = u->is_clock_high = 0;
    u->looked = avr_outer(m, at);
    m->due[AVR_PART_SEND] = AVR_NEVER;
}

static void control(avr *m, uint8_t value, uint64_t at)
{
    uint8_t was = m->data[UCSR0B];
    rate_changes(m, at);
    m->data[UCSR0B] = (uint8_t)((value & ~RXB8) | (was & RXB8));
    if ((value ^ was) & RXEN) avr_receiver_enable(m, value & RXEN, at);
    if (value & ~was & TXEN && m->usart.is_waiting && !m->usart.is_sending) {
        m->data[UCSR0A] &= (uint8_t)~UDRE;
        if (!avr_is_clocked(m)) avr_due(m, AVR_PART_SEND, at + 1);
    }
    rate_changed(m, at);
    avr_ask(m);
}

uint8_t avr_usart_load(avr *m, unsigned address, uint64_t at)
{
    (void)at;
    return address == UDR0 ? avr_receiver_read(m) : m->data[address];
}

void avr_usart_store(avr *m, unsigned address, uint8_t value, uint64_t at)
{
    uint8_t *status = &m->data[UCSR0A];
    int is_other;
    switch (address) {
    case UDR0: send(m, value, at); break;
    case UCSR0A:
        is_other = (*status ^ value) & U2X;
        if (is_other) rate_changes(m, at);
        *status = (uint8_t)((*status & ~(value & TXC) & ~(U2X | MPCM)) | (value & (U2X | MPCM)));
        if (is_other) rate_changed(m, at);
        avr_ask(m);
        break;
    case UCSR0B: control(m, value, at); break;
    case UCSR0C: case UBRR0L: case UBRR0H:
        rate_changes(m, at);
        if (address == UCSR0C && (m->data[UCSR0C] ^ value) & UMSEL) mode_changes(m, at);
        m->data[address] = address == UBRR0H ? value & 15 : value;
        rate_changed(m, at);
        break;
    default: break;
    }
}

void avr_usart_shift(avr *m, uint64_t clocks)
{
    m->usart.bit_from += clocks;
    m->usart.bit_in_from += clocks;
}
