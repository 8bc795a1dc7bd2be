/* Frames of USART0, by its registers: DS40002061, USART0, Frame Formats. */
#ifndef HIL_AVR_FRAME_H
#define HIL_AVR_FRAME_H

#include "avr_registers.h"
#include "avr_state.h"

static inline uint32_t avr_frame_divider(const avr *m) { return ((m->data[UBRR0H] & 15u) << 8 | m->data[UBRR0L]) + 1; }

/* Clocks of a bit; 0: it goes by a clock at XCK (avr_clocked.h). */
static inline uint32_t avr_frame_bit(const avr *m)
{
    return m->data[UCSR0C] & UMSEL ? 0 : avr_frame_divider(m) * (m->data[UCSR0A] & U2X ? 8 : 16);
}

/* 5 to 9. */
static inline int avr_frame_data_bits(const avr *m)
{
    int size = (m->data[UCSR0C] & UCSZ) >> 1;
    return m->data[UCSR0B] & UCSZ2 ? 9 : 5 + size;
}

/* With parity. */
static inline int avr_frame_bits(const avr *m) { return avr_frame_data_bits(m) + (m->data[UCSR0C] & UPM ? 1 : 0); }

/* As avr_framing has it. */
static inline int avr_frame_framing(const avr *m)
{
    uint8_t control = m->data[UCSR0C];
    return avr_frame_data_bits(m) | (control & UPM) | (control & USBS ? AVR_TWO_STOPS : 0);
}

static inline int avr_frame_parity(const avr *m, unsigned data)
{
    return __builtin_parity(data) ^ ((m->data[UCSR0C] & UPM) == UPM); /* 3 is odd, 2 even */
}

#endif
