#include "avr_receiver.h"

#include "avr_frame.h"
#include "avr_interrupt.h"
#include "avr_line.h"
#include "avr_registers.h"
#include "avr_time.h"

/* Samples of a bit, and the last of the three that decide. */
static unsigned samples(const avr *m) { return m->data[UCSR0A] & U2X ? 8 : 16; }
static unsigned decided(const avr *m) { return m->data[UCSR0A] & U2X ? 6 : 10; }

/* Bit `ahead` from the one that began at bit_in_from: when its last sample is taken. */
static uint64_t decided_at(const avr *m, unsigned ahead)
{
    uint32_t bit = avr_frame_bit(m);
    return m->usart.bit_in_from + (uint64_t)bit * ahead + bit / samples(m) * decided(m);
}

/* Start, data, parity, the first stop bit. */
static unsigned bits_of_frame(const avr *m) { return (unsigned)avr_frame_bits(m) + 2; }

static int majority(const avr *m, unsigned ahead)
{
    uint32_t sample = avr_frame_bit(m) / samples(m);
    uint64_t last = decided_at(m, ahead);
    int ones = 0;
    for (unsigned i = 0; i < 3; i++) ones += avr_line_level(&m->usart, avr_outer(m, last - i * sample));
    return ones >= 2;
}

/* A character as it is, where its sender's clock is near enough that each sample falls into its bit. */
static int is_plain(const avr *m, const avr_character *c)
{
    int64_t bit = (int64_t)avr_frame_bit(m) << 8 << m->clock_shift, off = (int64_t)c->bit_cycles_256 - bit;
    return c->cycle == m->usart.edge && m->usart.wire && !m->usart.wire_count && m->usart.bits_in == 0 && !c->is_broken &&
           c->length == avr_frame_bits(m) && (off < 0 ? -off : off) * 40 < bit;
}

/* Takes bits that are decided at a clock. */
static void take_bits(avr *m, uint64_t at)
{
    avr_usart *u = &m->usart;
    unsigned all = bits_of_frame(m), ahead = 0;
    const avr_character *first = &u->heard[u->heard_first];
    if (u->heard_count && at >= decided_at(m, all - 1) && is_plain(m, first)) {
        u->shifted = (uint16_t)(first->bits << 1 | 1u << (all - 1));
        u->bits_in = (uint8_t)all;
        return;
    }
    for (; u->bits_in < all && decided_at(m, ahead) <= at; ahead++, u->bits_in++) {
        if (majority(m, ahead)) u->shifted |= (uint16_t)(1u << u->bits_in);
        else u->shifted &= (uint16_t)~(1u << u->bits_in);
    }
    u->bit_in_from += (uint64_t)avr_frame_bit(m) * ahead;
}

void avr_receiver_show(avr *m)
{
    const avr_usart *u = &m->usart;
    uint8_t *status = &m->data[UCSR0A];
    *status &= (uint8_t) ~(RXC | FE | DOR | UPE);
    m->data[UCSR0B] &= (uint8_t)~RXB8;
    if (u->buffered) {
        *status |= RXC | u->errors[0];
        if (u->buffer[0] >> 8) m->data[UCSR0B] |= RXB8;
    }
    avr_ask(m);
}

void avr_receiver_put(avr *m, uint16_t value, uint8_t errors)
{
    avr_usart *u = &m->usart;
    if (u->buffered == 2) {
        u->is_kept = 1;
        u->kept = value;
        u->kept_errors = errors;
        return;
    }
    u->buffer[u->buffered] = value;
    u->errors[u->buffered++] = errors;
    avr_receiver_show(m);
}

/* A frame is in: `shifted` has it, start bit lowest. */
static void frame_in(avr *m)
{
    avr_usart *u = &m->usart;
    int data_bits = avr_frame_data_bits(m), frame = avr_frame_bits(m);
    unsigned data = u->shifted >> 1 & ((1u << data_bits) - 1), stop = u->shifted >> (frame + 1) & 1;
    uint8_t errors = u->is_lost ? DOR : 0;
    int is_address = data_bits == 9 ? data >> 8 & 1 : stop;
    if (m->data[UCSR0A] & MPCM && !is_address) return;
    if (!stop) errors |= FE;
    if (frame > data_bits && (u->shifted >> frame & 1) != (unsigned)avr_frame_parity(m, data)) errors |= UPE;
    u->is_lost = 0;
    avr_receiver_put(m, (uint16_t)data, errors);
}

void avr_receiver_begins(avr *m, uint64_t at)
{
    avr_usart *u = &m->usart;
    u->is_receiving = 1;
    u->bits_in = 0;
    u->shifted = 0;
    u->bit_in_from = at;
    if (u->is_kept) {
        u->is_kept = 0;
        u->is_lost = 1;
        avr_note_once(m, AVR_NOTE_OVERRUN, (uint8_t)u->kept);
    }
}

void avr_receiver_take(avr *m, int bit, uint64_t at)
{
    avr_usart *u = &m->usart;
    if (!u->is_receiving) {
        if (!bit) avr_receiver_begins(m, at), u->bits_in = 1;
        return;
    }
    u->shifted |= (uint16_t)(bit << u->bits_in);
    if (++u->bits_in < bits_of_frame(m)) return;
    u->is_receiving = 0;
    frame_in(m);
}

static void schedule(avr *m, uint64_t at)
{
    avr_usart *u = &m->usart;
    uint64_t due = AVR_NEVER;
    if (!(m->data[UCSR0B] & RXEN) || !avr_frame_bit(m) || m->data[PRR] & PRUSART) due = AVR_NEVER; /* off, or bits are taken at edges of XCK */
    else if (u->is_receiving) due = decided_at(m, bits_of_frame(m) - 1u - u->bits_in);
    else if ((u->edge = avr_line_falls(u, u->looked)) != AVR_NEVER) due = avr_inner(m, u->edge);
    avr_due(m, AVR_PART_RECEIVE, due != AVR_NEVER && due <= at ? at + 1 : due);
}

void avr_receiver_look(avr *m, uint64_t at)
{
    if (!m->usart.is_receiving) schedule(m, at);
}

void avr_receiver_event(avr *m, uint64_t at)
{
    avr_usart *u = &m->usart;
    if (!u->is_receiving) {
        avr_receiver_begins(m, avr_inner(m, u->edge));
    } else {
        unsigned all = bits_of_frame(m);
        uint64_t start_decided = decided_at(m, 0);
        int is_whole = u->bits_in == 0;
        take_bits(m, at);
        if (u->bits_in < all) {
            schedule(m, at);
            return;
        }
        int is_false = u->shifted & 1;
        u->is_receiving = 0;
        u->looked = avr_outer(m, is_false && is_whole ? start_decided : at) + 1; /* a false start: look on at once */
        if (!is_false) frame_in(m);
        avr_line_forget(u, u->looked);
    }
    schedule(m, at);
}

void avr_receiver_rate(avr *m, uint64_t at)
{
    if (m->usart.is_receiving && avr_frame_bit(m)) take_bits(m, at);
}

void avr_receiver_resume(avr *m, uint64_t at)
{
    schedule(m, at);
}

void avr_receiver_enable(avr *m, int is_on, uint64_t at)
{
    avr_usart *u = &m->usart;
    if (!is_on) {
        u->buffered = u->is_kept = u->is_lost = u->is_receiving = 0;
        avr_receiver_show(m);
    } else if (!u->is_receiving) {
        u->looked = avr_outer(m, at);
    }
    avr_line_forget(u, avr_outer(m, at) - 2);
    schedule(m, at);
}

uint8_t avr_receiver_read(avr *m)
{
    avr_usart *u = &m->usart;
    uint8_t value = (uint8_t)u->buffer[0];
    if (!u->buffered) return value;
    u->buffered--;
    u->buffer[0] = u->buffer[1];
    u->errors[0] = u->errors[1];
    if (u->is_kept) {
        u->is_kept = 0;
        avr_receiver_put(m, u->kept, u->kept_errors);
    }
    avr_receiver_show(m);
    return value;
}
