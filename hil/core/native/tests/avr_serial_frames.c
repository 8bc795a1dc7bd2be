/* USART0: frames and their faults. DS40002061, USART0. */
#include "avr_lab.h"

enum { BIT = 16, EIGHT = UCSZ, NINE = 9, ERRORS = FE | DOR | UPE };

static avr_lab lab;

/* UBRR 0, or U2X and UBRR 1: 16 clocks a bit, as many data bits. */
static void open_with(unsigned bits, unsigned more, int is_double)
{
    lab_open(&lab);
    put(&lab, UCSR0C, more | (bits == NINE ? 6 : (bits - 5) << 1));
    if (is_double) put(&lab, UCSR0A, U2X), put(&lab, UBRR0L, 1);
    put(&lab, UCSR0B, (unsigned)(RXEN | TXEN) | (bits == NINE ? UCSZ2 : 0));
    avr_pin(&lab.chip, D, 1);
    lab_run(&lab, 10);
}

static int hear(unsigned bits, unsigned length, int is_broken)
{
    avr_character c = {lab.chip.cycle + 1, BIT * 256, (uint16_t)bits, (uint8_t)length, (uint8_t)is_broken, 0};
    int answer = avr_hear(&lab.chip, &c);
    lab_run(&lab, BIT * (length + 2) + BIT);
    return answer;
}

static void each_length_of_frame(void)
{
    for (int is_double = 0; is_double < 2; is_double++)
        for (unsigned bits = 5; bits <= NINE; bits++)
            for (unsigned parity = 0; parity < 4; parity++) {
                if (parity == 1) continue; /* reserved */
                open_with(bits, parity << 4 | USBS, is_double);
                unsigned data = 0x155u & ((1u << bits) - 1), odd = (unsigned)__builtin_parity(data) ^ (parity == 3);
                unsigned frame = data | (parity ? odd << bits : 0), length = bits + (parity ? 1 : 0);
                if (bits == NINE) put(&lab, UCSR0B, (unsigned)(RXEN | TXEN | UCSZ2) | (data >> 8 & 1 ? 1 : 0));
                put(&lab, UDR0, data);
                uint64_t begun = lab.chip.cycle + 1;
                CHECK_INT(until_bits(&lab, UCSR0A, TXC, TXC, 1000), 1 + BIT * (length + 3)); /* two stop bits */
                CHECK_INT(lab.frame[0].cycle, begun);
                CHECK_INT(lab.frame[0].bits, frame);
                CHECK_INT(lab.frame[0].length, length);
                CHECK_INT(lab.frame[0].framing, bits | parity << 4 | AVR_TWO_STOPS);
                CHECK_INT(hear(frame, length, 0), 0);
                CHECK_INT(get(&lab, UCSR0A) & (RXC | ERRORS), RXC);
                CHECK_INT(get(&lab, UCSR0B) & RXB8, bits == NINE && data >> 8 ? RXB8 : 0);
                CHECK_INT(get(&lab, UDR0), data & 0xff);
                if (parity) {
                    hear(frame ^ 1, length, 0);
                    CHECK_INT(get(&lab, UCSR0A) & ERRORS, UPE);
                }
            }
}

static void a_frame_without_stop_bit_is_an_error_of_its_byte(void)
{
    open_with(8, 0, 0);
    hear(0x41, 8, 1), hear(0x42, 8, 0);
    CHECK_INT(get(&lab, UCSR0A) & (RXC | ERRORS), RXC | FE);
    CHECK_INT(get(&lab, UDR0), 0x41);
    CHECK_INT(get(&lab, UCSR0A) & (RXC | ERRORS), RXC);
    CHECK_INT(get(&lab, UDR0), 0x42);
}

static void a_break_is_a_zero_without_stop_bit_once(void)
{
    open_with(8, 0, 0);
    avr_pin(&lab.chip, D, 0);
    lab_run(&lab, 40 * BIT);
    avr_pin(&lab.chip, D, 1);
    lab_run(&lab, 20 * BIT);
    CHECK_INT(get(&lab, UCSR0A) & (RXC | ERRORS), RXC | FE);
    CHECK_INT(get(&lab, UDR0), 0);
    CHECK_INT(get(&lab, UCSR0A) & RXC, 0);
}

static void the_fourth_byte_is_an_overrun(void)
{
    open_with(8, 0, 0);
    for (unsigned n = 0; n < 4; n++) hear(0x31 + n, 8, 0);
    CHECK_INT(get(&lab, UDR0), 0x31);
    CHECK_INT(get(&lab, UDR0), 0x32);
    CHECK_INT(get(&lab, UCSR0A) & (RXC | ERRORS), RXC | DOR);
    CHECK_INT(get(&lab, UDR0), 0x34);
    CHECK_INT(get(&lab, UCSR0A) & RXC, 0);
}

/* One of the three samples in the middle of a bit is wrong: the others decide. Two of them are. */
static void a_bit_is_by_majority(void)
{
    for (int is_double = 0; is_double < 2; is_double++)
        for (unsigned wrong = 1; wrong < 3; wrong++) {
            open_with(8, 0, is_double);
            uint64_t sample = is_double ? 2 : 1, start = lab.chip.cycle;
            avr_pin(&lab.chip, D, 0);
            lab_until(&lab, start + BIT);
            avr_pin(&lab.chip, D, 1); /* FFh from here on, but for a gap in bit 2 */
            lab_until(&lab, start + 3 * BIT + (is_double ? 4 : 8) * sample);
            avr_pin(&lab.chip, D, 0);
            lab_run(&lab, wrong * sample);
            avr_pin(&lab.chip, D, 1);
            lab_run(&lab, 20 * BIT);
            CHECK_INT(get(&lab, UDR0), wrong == 1 ? 0xff : 0xfb);
        }
}

static void a_short_low_is_no_start_bit(void)
{
    open_with(8, 0, 0);
    avr_pin(&lab.chip, D, 0);
    lab_run(&lab, 6);
    avr_pin(&lab.chip, D, 1);
    lab_run(&lab, 20 * BIT);
    CHECK_INT(get(&lab, UCSR0A) & RXC, 0);
}

static void frames_of_data_pass_a_slave_of_several(void)
{
    for (unsigned bits = 8; bits <= NINE; bits++) {
        open_with(bits, 0, 0);
        put(&lab, UCSR0A, MPCM);
        if (bits == NINE) hear(0x012, 9, 0), hear(0x134, 9, 0);
        else hear(0x12, 8, 1), hear(0x34, 8, 0); /* the first stop bit says so */
        CHECK_INT(get(&lab, UCSR0A) & RXC, RXC);
        CHECK_INT(get(&lab, UDR0), 0x34);
        CHECK_INT(get(&lab, UCSR0A) & RXC, 0);
        put(&lab, UCSR0A, 0);
        hear(0x56, bits, 0);
        CHECK_INT(get(&lab, UDR0), 0x56);
    }
}

static void txc_is_cleared_by_one_or_by_its_interrupt(void)
{
    open_with(8, 0, 0);
    CHECK_INT(get(&lab, UCSR0A) & (TXC | UDRE), UDRE);
    put(&lab, UDR0, 1), until_bits(&lab, UCSR0A, TXC, TXC, 1000);
    put(&lab, UCSR0A, TXC);
    CHECK_INT(get(&lab, UCSR0A) & TXC, 0);
    put(&lab, UDR0, 1), put(&lab, UCSR0B, RXEN | TXEN | TXCIE), until_bits(&lab, UCSR0A, TXC, TXC, 1000);
    CHECK_INT(entered(&lab), VECTOR_TX);
    CHECK_INT(get(&lab, UCSR0A) & TXC, 0);
    put(&lab, UCSR0B, RXEN | TXEN | UDRIE);
    CHECK_INT(entered(&lab), VECTOR_UDRE);
    CHECK_INT(entered(&lab), VECTOR_UDRE); /* it asks until UDR is written */
}

static void what_was_received_goes_with_the_receiver(void)
{
    open_with(8, 0, 0);
    hear(0x41, 8, 0);
    put(&lab, UCSR0B, TXEN), put(&lab, UCSR0B, RXEN | TXEN);
    CHECK_INT(get(&lab, UCSR0A) & RXC, 0);
}

static void rxc_comes_in_the_middle_of_the_stop_bit(void)
{
    open_with(8, 0, 0);
    uint64_t start = lab.chip.cycle + 10;
    avr_character c = {start, BIT * 256, 0x41, 8, 0, 0};
    avr_hear(&lab.chip, &c);
    until_bits(&lab, UCSR0A, RXC, RXC, 1000);
    CHECK_INT(lab.chip.cycle - start, 9 * BIT + 10);
}

void avr_serial_frames_tests(void)
{
    RUN(each_length_of_frame);
    RUN(a_frame_without_stop_bit_is_an_error_of_its_byte);
    RUN(a_break_is_a_zero_without_stop_bit_once);
    RUN(the_fourth_byte_is_an_overrun);
    RUN(a_bit_is_by_majority);
    RUN(a_short_low_is_no_start_bit);
    RUN(frames_of_data_pass_a_slave_of_several);
    RUN(txc_is_cleared_by_one_or_by_its_interrupt);
    RUN(what_was_received_goes_with_the_receiver);
    RUN(rxc_comes_in_the_middle_of_the_stop_bit);
}
