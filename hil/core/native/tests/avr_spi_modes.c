/* SPI: DS40002061, Serial Peripheral Interface. */
#include "avr_lab.h"

enum { SS = B + 2, MOSI = B + 3, MISO = B + 4, SCK = B + 5, OUTPUTS = 0x2c };

static avr_lab lab;

static void open_master(unsigned control)
{
    lab_open(&lab);
    put(&lab, DDRB, OUTPUTS);
    put(&lab, SPCR, SPE | MSTR | control);
    lab_run(&lab, 10);
    lab.count = 0;
}

static unsigned taken(int first_edge)
{
    unsigned bits = 0;
    int level = avr_level(&lab.chip, MOSI), seen = 0;
    for (int i = 0; i < lab.count; i++) {
        if (lab.edge[i].pin == MOSI) level = lab.edge[i].drive == AVR_HIGH;
        if (lab.edge[i].pin == SCK && seen++ % 2 == first_edge) bits = bits << 1 | (unsigned)level;
    }
    return bits;
}

static void each_mode_order_and_speed(void)
{
    static const unsigned halves[8] = {2, 8, 32, 64, 1, 4, 16, 32};
    for (unsigned mode = 0; mode < 4; mode++)
        for (unsigned order = 0; order <= DORD; order += DORD)
            for (unsigned speed = 0; speed < 8; speed++) {
                open_master(mode << 2 | order | (speed & 3));
                put(&lab, SPSR, speed >> 2);
                CHECK_INT(avr_level(&lab.chip, SCK), (int)(mode >> 1)); /* CPOL */
                put(&lab, SPDR, 0xa3);
                CHECK_INT(until_bits(&lab, SPSR, SPIF, SPIF, 5000), 16 * halves[speed]);
                CHECK_INT(edges_of(&lab, SCK), 16);
                CHECK_INT(edge_of(&lab, SCK, 1) - edge_of(&lab, SCK, 0), halves[speed]);
                CHECK_INT(taken((int)mode & 1), order ? 0xc5 : 0xa3);
            }
}

static void a_master_takes_miso(void)
{
    open_master(1); /* 16 clocks a bit */
    put(&lab, SPDR, 0);
    for (unsigned bit = 0; bit < 8; bit++) {
        avr_pin(&lab.chip, MISO, 0xb1 >> (7 - bit) & 1);
        lab_run(&lab, 16);
    }
    CHECK_INT(get(&lab, SPSR), SPIF);
    CHECK_INT(get(&lab, SPDR), 0xb1);
    CHECK_INT(get(&lab, SPSR), 0); /* SPSR and SPDR were read */
}

static void a_write_too_early_is_a_collision(void)
{
    open_master(1);
    put(&lab, SPDR, 0x55), lab_run(&lab, 20);
    put(&lab, SPDR, 0xff);
    lab_run(&lab, 200);
    CHECK_INT(get(&lab, SPSR), SPIF | WCOL);
    CHECK_INT(taken(0), 0x55);
    get(&lab, SPDR);
    CHECK_INT(get(&lab, SPSR), 0);
}

static void its_interrupt_clears_the_flag(void)
{
    open_master(SPIE);
    put(&lab, SPDR, 1), lab_run(&lab, 100);
    CHECK_INT(entered(&lab), VECTOR_SPI);
    CHECK_INT(get(&lab, SPSR), 0);
}

static void a_low_input_at_ss_ends_a_masters_time(void)
{
    open_master(0);
    put(&lab, PORTB, 4), avr_pin(&lab.chip, SS, 0); /* an output: nothing */
    lab_run(&lab, 10);
    CHECK_INT(get(&lab, SPCR), SPE | MSTR);
    put(&lab, DDRB, OUTPUTS & ~4); /* becomes an input that is low */
    CHECK_INT(get(&lab, SPCR), SPE);
    CHECK_INT(get(&lab, SPSR), SPIF);
    avr_pin(&lab.chip, SS, 1), lab_run(&lab, 10);
    put(&lab, SPCR, SPE | MSTR), put(&lab, SPDR, 0x55), lab_run(&lab, 10);
    avr_pin(&lab.chip, SS, 0), lab_run(&lab, 4);
    CHECK_INT(get(&lab, SPCR), SPE);
    CHECK_INT(avr_driven(&lab.chip, SCK), AVR_OPEN); /* inputs of a slave */
    CHECK_INT(avr_driven(&lab.chip, MOSI), AVR_OPEN);
    put(&lab, SPCR, SPE | MSTR); /* also where it is low before */
    CHECK_INT(get(&lab, SPCR), SPE);
}

/* Clocks a byte into a slave, mode 0, 8 clocks a half; what it gives. */
static unsigned clock_in(unsigned byte, unsigned bits)
{
    unsigned got = 0;
    for (unsigned bit = 0; bit < bits; bit++) {
        avr_pin(&lab.chip, MOSI, byte >> (7 - bit) & 1);
        lab_run(&lab, 8);
        got = got << 1 | (unsigned)avr_level(&lab.chip, MISO);
        avr_pin(&lab.chip, SCK, 1), lab_run(&lab, 8);
        avr_pin(&lab.chip, SCK, 0);
    }
    lab_run(&lab, 8);
    return got;
}

static void open_slave(void)
{
    lab_open(&lab);
    avr_pin(&lab.chip, SS, 1), avr_pin(&lab.chip, SCK, 0);
    put(&lab, DDRB, 1 << 4), put(&lab, SPCR, SPE), put(&lab, SPDR, 0x93);
    lab_run(&lab, 10);
}

static void a_slave_answers_while_it_is_selected(void)
{
    open_slave();
    CHECK_INT(avr_driven(&lab.chip, MISO), AVR_OPEN);
    clock_in(0xff, 8); /* not for it */
    CHECK_INT(get(&lab, SPSR), 0);
    avr_pin(&lab.chip, SS, 0), lab_run(&lab, 8);
    CHECK_INT(clock_in(0x5a, 8), 0x93);
    CHECK_INT(get(&lab, SPSR), SPIF);
    put(&lab, SPDR, 0x71); /* while SS stays low */
    CHECK_INT(get(&lab, SPDR), 0x5a);
    CHECK_INT(clock_in(0x3c, 8), 0x71);
    CHECK_INT(get(&lab, SPDR), 0x3c);
}

static void ss_counts_bits_from_the_first(void)
{
    open_slave();
    avr_pin(&lab.chip, SS, 0), lab_run(&lab, 8);
    clock_in(0xff, 5);
    put(&lab, SPDR, 0x11);
    CHECK_INT(get(&lab, SPSR), WCOL);
    avr_pin(&lab.chip, SS, 1), lab_run(&lab, 8);
    avr_pin(&lab.chip, SS, 0), lab_run(&lab, 8);
    clock_in(0x5a, 8);
    CHECK_INT(get(&lab, SPSR) & SPIF, SPIF);
    CHECK_INT(get(&lab, SPDR), 0x5a);
}

void avr_spi_modes_tests(void)
{
    RUN(each_mode_order_and_speed);
    RUN(a_master_takes_miso);
    RUN(a_write_too_early_is_a_collision);
    RUN(its_interrupt_clears_the_flag);
    RUN(a_low_input_at_ss_ends_a_masters_time);
    RUN(a_slave_answers_while_it_is_selected);
    RUN(ss_counts_bits_from_the_first);
}
