/* USART0 by a clock at XCK: as a master of SPI, and in synchronous frames. DS40002061, USART in SPI Mode; Synchronous Clock Operation. */
#include "avr_lab.h"

enum { SPI = 0xc0, SYNCHRONOUS = 0x40, XCK = D + 4, TXD = D + 1, RXD = D };

static avr_lab lab;

/* XCK an output, a bit of 2 (UBRR + 1) clocks. */
static void open_at(unsigned mode, unsigned ubrr)
{
    lab_open(&lab);
    avr_pin(&lab.chip, RXD, 1);
    put(&lab, DDRD, 1 << 4);
    put(&lab, UCSR0C, mode);
    put(&lab, UCSR0B, RXEN | TXEN);
    put(&lab, UBRR0L, ubrr);
    lab_run(&lab, 100);
    lab.count = 0;
}

/* Levels of D1 where XCK has the edges at which a slave takes them, the first one highest. */
static unsigned taken(int first_edge)
{
    unsigned bits = 0;
    int level = 1, seen = 0;
    for (int i = 0; i < lab.count; i++) {
        if (lab.edge[i].pin == TXD) level = lab.edge[i].drive == AVR_HIGH;
        if (lab.edge[i].pin == XCK && seen++ % 2 == first_edge) bits = bits << 1 | (unsigned)level;
    }
    return bits;
}

static void a_byte_goes_out_in_each_mode(void)
{
    for (unsigned mode = 0; mode < 4; mode++) {
        unsigned polarity = mode >> 1, phase = mode & 1;
        open_at(SPI | polarity | phase << 1, 3);
        CHECK_INT(avr_level(&lab.chip, XCK), (int)polarity);
        put(&lab, UDR0, 0xa3);
        lab_run(&lab, 100);
        CHECK_INT(edges_of(&lab, XCK), 16);
        for (int n = 1; n < 16; n++) CHECK_INT(edge_of(&lab, XCK, n) - edge_of(&lab, XCK, n - 1), 4);
        CHECK_INT(drive_of(&lab, XCK, 0), (int)!polarity);
        CHECK_INT(taken((int)phase), 0xa3);
        CHECK_INT(avr_level(&lab.chip, TXD), 1); /* the line is idle, high */
        CHECK_INT(lab.frames, 0);
        CHECK_INT(get(&lab, UCSR0A), RXC | TXC | UDRE);
    }
}

static void the_lowest_bit_may_be_first(void)
{
    open_at(SPI | UDORD, 0);
    put(&lab, UDR0, 0xa3);
    lab_run(&lab, 40);
    CHECK_INT(taken(0), 0xc5);
    CHECK_INT(edge_of(&lab, XCK, 1) - edge_of(&lab, XCK, 0), 1); /* half the clock of the chip */
}

static void bytes_follow_without_a_gap(void)
{
    open_at(SPI, 7);
    put(&lab, UDR0, 0x55);
    lab_run(&lab, 2);
    CHECK_INT(get(&lab, UCSR0A) & UDRE, UDRE); /* it has moved on to the shift register */
    put(&lab, UDR0, 0x0f);
    CHECK_INT(get(&lab, UCSR0A) & (UDRE | TXC), 0);
    lab_run(&lab, 140);
    CHECK_INT(get(&lab, UCSR0A) & (UDRE | TXC), UDRE);
    lab_run(&lab, 140);
    CHECK_INT(get(&lab, UCSR0A) & TXC, TXC);
    CHECK_INT(edges_of(&lab, XCK), 32);
    for (int n = 1; n < 32; n++) CHECK_INT(edge_of(&lab, XCK, n) - edge_of(&lab, XCK, n - 1), 8);
    CHECK_INT(taken(0), 0x550f);
}

/* Four bytes that nobody reads: the third is lost, and no flag says so. */
static void received_bytes_wait_in_two_buffers(void)
{
    open_at(SPI, 7);
    for (unsigned n = 0; n < 4; n++) {
        put(&lab, UDR0, 0);
        for (unsigned bit = 0; bit < 8; bit++) {
            avr_pin(&lab.chip, RXD, (0x21 + n) >> (7 - bit) & 1);
            lab_run(&lab, 16);
        }
        lab_run(&lab, 32);
    }
    for (unsigned n = 0; n < 4; n++) {
        CHECK_INT(get(&lab, UCSR0A) & (RXC | FE | DOR | UPE), n < 3 ? RXC : 0);
        if (n < 3) CHECK_INT(get(&lab, UDR0), n == 2 ? 0x24 : 0x21 + n);
    }
}

static void without_an_output_at_xck_none_is_seen(void)
{
    open_at(SPI, 1);
    put(&lab, DDRD, 0);
    lab_run(&lab, 1);
    lab.count = 0;
    put(&lab, UDR0, 0xff);
    lab_run(&lab, 100);
    CHECK_INT(edges_of(&lab, XCK), 0);
    CHECK_INT(get(&lab, UCSR0A) & TXC, TXC);
}

static void a_synchronous_frame_has_a_bit_for_each_clock(void)
{
    open_at(SYNCHRONOUS | UCSZ | UPM, 9); /* 8 bits, odd parity */
    CHECK_INT(edge_of(&lab, XCK, 0), UINT64_MAX);
    lab_run(&lab, 100);
    CHECK_INT(edges_of(&lab, XCK), 10); /* it runs all the time */
    put(&lab, UDR0, 0x31);
    lab_run(&lab, 300);
    CHECK_INT(lab.frames, 1);
    CHECK_INT(lab.frame[0].bits, 0x031);
    CHECK_INT(lab.frame[0].length, 9);
    CHECK_INT(lab.frame[0].bit_cycles_256, 20 << 8);
    int rises = 0;
    for (int i = 0; i < lab.count; i++) rises += lab.edge[i].cycle == lab.frame[0].cycle && lab.edge[i].pin == XCK && lab.edge[i].drive == AVR_HIGH;
    CHECK_INT(rises, 1); /* UCPOL 0: it changes where XCK rises */
}

/* Two chips: XCK, and TXD to RXD; the master has the clock. */
static void a_slave_of_a_synchronous_line_goes_by_its_clock(void)
{
    static avr_lab slave;
    open_at(SYNCHRONOUS | UCSZ, 9);
    lab_open(&slave);
    avr_pin(&slave.chip, RXD, 1);
    put(&slave, UCSR0C, SYNCHRONOUS | UCSZ);
    put(&slave, UCSR0B, RXEN | TXEN);
    avr_watch(&lab.chip, (1u << AVR_PINS) - 1);
    avr_watch(&slave.chip, (1u << AVR_PINS) - 1);
    for (int cycle = 0; cycle < 900; cycle++) {
        if (cycle == 100) put(&lab, UDR0, 0x96);
        if (cycle == 130) put(&slave, UDR0, 0x5c);
        avr_pin(&slave.chip, XCK, avr_level(&lab.chip, XCK));
        avr_pin(&slave.chip, RXD, avr_level(&lab.chip, TXD));
        avr_pin(&lab.chip, RXD, avr_level(&slave.chip, TXD));
        lab_run(&lab, 1);
        lab_run(&slave, 1);
    }
    CHECK_INT(get(&slave, UCSR0A) & (RXC | FE), RXC);
    CHECK_INT(get(&slave, UDR0), 0x96);
    CHECK_INT(get(&lab, UCSR0A) & (RXC | FE), RXC);
    CHECK_INT(get(&lab, UDR0), 0x5c);
    CHECK_INT(slave.frame[0].bit_cycles_256, 20 << 8);
}

void avr_clocked_usart_tests(void)
{
    RUN(a_byte_goes_out_in_each_mode);
    RUN(the_lowest_bit_may_be_first);
    RUN(bytes_follow_without_a_gap);
    RUN(received_bytes_wait_in_two_buffers);
    RUN(without_an_output_at_xck_none_is_seen);
    RUN(a_synchronous_frame_has_a_bit_for_each_clock);
    RUN(a_slave_of_a_synchronous_line_goes_by_its_clock);
}
