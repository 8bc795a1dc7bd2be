/* Several masters on two wires: DS40002061, 2-wire Serial Interface, Multi-master Systems and Arbitration; tables of status codes. */
#include "avr_lab.h"

enum { SDA = C + 4, SCL = C + 5, GO = TWINT | TWEN | TWEA, CYCLES = 20000 };

static avr_lab lab[2];
static int status_count[2];
static uint8_t statuses[2][24], data_of[2][24];

/* What each is to do: the answer to each TWINT, in order; a byte of data before it, or NONE. */
enum { NONE = 0x100, END = 0x200 };
typedef struct answer { int control, data; } answer;

static void open_two(unsigned bits)
{
    for (int n = 0; n < 2; n++) {
        lab_open(&lab[n]);
        put(&lab[n], PORTC, 0x30); /* pull-ups */
        put(&lab[n], TWBR, bits);
        put(&lab[n], TWCR, TWEN | TWEA);
        status_count[n] = 0;
    }
    put(&lab[0], TWAR, 0x22);
    put(&lab[1], TWAR, 0x44 | 1); /* and all are called */
}

/* Runs both with their lines joined; each has its program. */
static void play(const answer *first, const answer *second, int cycles)
{
    const answer *next[2] = {first, second};
    for (int cycle = 0; cycle < cycles; cycle++) {
        for (int n = 0; n < 2; n++) lab_run(&lab[n], 1);
        for (int pin = SDA; pin <= SCL; pin++) {
            int low[2];
            for (int n = 0; n < 2; n++) low[n] = avr_driven(&lab[n].chip, pin) == AVR_LOW;
            for (int n = 0; n < 2; n++) avr_pin(&lab[n].chip, pin, low[1 - n] ? 0 : -1);
        }
        for (int n = 0; n < 2; n++) {
            if (!(get(&lab[n], TWCR) & TWINT) || status_count[n] == 24) continue;
            statuses[n][status_count[n]] = get(&lab[n], TWSR) & 0xf8;
            data_of[n][status_count[n]++] = get(&lab[n], TWDR);
            if (next[n]->control == END) {
                put(&lab[n], TWCR, TWEN | TWEA); /* it does not go on */
                continue;
            }
            if (next[n]->data != NONE) put(&lab[n], TWDR, (unsigned)next[n]->data);
            put(&lab[n], TWCR, (unsigned)next[n]->control);
            next[n]++;
        }
    }
}

static void start(int n) { put(&lab[n], TWCR, GO | TWSTA); }

static void check(int n, int count, const uint8_t *wanted)
{
    CHECK_INT(status_count[n], count);
    for (int i = 0; i < count && i < status_count[n]; i++)
        if (statuses[n][i] != wanted[i]) CHECK_FAILED("status %d of %d is %02xh, not %02xh", i, n, statuses[n][i], wanted[i]);
}

#define CHECK_STATUSES(n, ...)                                     \
    do {                                                           \
        static const uint8_t wanted_[] = {__VA_ARGS__};            \
        check(n, (int)sizeof(wanted_), wanted_);                   \
    } while (0)

/* Both begin at one clock, to nobody: 60h loses to 50h in its first bit but one. */
static void the_lower_address_wins(void)
{
    static const answer winner[] = {{GO, 0x50}, {GO | TWSTO, NONE}, {END, NONE}};
    static const answer loser[] = {{GO, 0x60}, {GO, NONE}, {END, NONE}};
    open_two(2);
    start(0), start(1);
    play(winner, loser, CYCLES);
    CHECK_STATUSES(0, 0x08, 0x20);
    CHECK_STATUSES(1, 0x08, 0x38);
    CHECK_INT(avr_level(&lab[0].chip, SDA) & avr_level(&lab[0].chip, SCL), 1);
}

static void who_lost_starts_again_when_the_bus_is_free(void)
{
    static const answer winner[] = {{GO, 0x50}, {GO | TWSTO, NONE}, {END, NONE}};
    static const answer loser[] = {{GO, 0x60}, {GO | TWSTA, NONE}, {GO, 0x60}, {GO | TWSTO, NONE}, {END, NONE}};
    open_two(2);
    start(0), start(1);
    play(winner, loser, CYCLES);
    CHECK_STATUSES(0, 0x08, 0x20);
    CHECK_STATUSES(1, 0x08, 0x38, 0x08, 0x20);
}

/* The one that wins addresses the one that loses: 44h to write. */
static void who_lost_is_the_slave_that_is_addressed(void)
{
    static const answer winner[] = {{GO, 0x44}, {GO, 0x5a}, {GO | TWSTO, NONE}, {END, NONE}};
    static const answer loser[] = {{GO, 0x60}, {GO, NONE}, {GO, NONE}, {GO, NONE}, {END, NONE}};
    open_two(2);
    start(0), start(1);
    play(winner, loser, CYCLES);
    CHECK_STATUSES(0, 0x08, 0x18, 0x28);
    CHECK_STATUSES(1, 0x08, 0x68, 0x80, 0xa0);
    CHECK_INT(data_of[1][2], 0x5a);
}

static void who_lost_is_called_with_all(void)
{
    static const answer winner[] = {{GO, 0x00}, {GO, 0x5a}, {GO | TWSTO, NONE}, {END, NONE}};
    static const answer loser[] = {{GO, 0x60}, {GO, NONE}, {GO, NONE}, {GO, NONE}, {END, NONE}};
    open_two(2);
    start(0), start(1);
    play(winner, loser, CYCLES);
    CHECK_STATUSES(0, 0x08, 0x18, 0x28);
    CHECK_STATUSES(1, 0x08, 0x78, 0x90, 0xa0);
}

static void who_lost_is_read(void)
{
    static const answer winner[] = {{GO, 0x45}, {TWINT | TWEN, NONE}, {GO | TWSTO, NONE}, {END, NONE}};
    static const answer loser[] = {{GO, 0x60}, {GO, 0xc3}, {GO, NONE}, {END, NONE}};
    open_two(2);
    start(0), start(1);
    play(winner, loser, CYCLES);
    CHECK_STATUSES(0, 0x08, 0x40, 0x58);
    CHECK_STATUSES(1, 0x08, 0xb0, 0xc0);
    CHECK_INT(data_of[0][2], 0xc3);
}

/* Both speak to a third, which is not there but for its acknowledgement: the data differs. */
static void data_decides_where_addresses_are_alike(void)
{
    static const answer winner[] = {{GO, 0x50}, {GO, 0x0f}, {GO | TWSTO, NONE}, {END, NONE}};
    static const answer loser[] = {{GO, 0x50}, {GO, 0x8f}, {GO, NONE}, {END, NONE}};
    open_two(2);
    start(0), start(1);
    play(winner, loser, CYCLES);
    CHECK_STATUSES(0, 0x08, 0x20, 0x30);
    CHECK_STATUSES(1, 0x08, 0x20, 0x38);
}

static void a_start_waits_for_the_end_of_anothers_transfer(void)
{
    static const answer sends[] = {{GO, 0x50}, {GO, 0xff}, {GO, 0xff}, {GO | TWSTO, NONE}, {END, NONE}};
    static const answer waits[] = {{GO, 0x60}, {GO | TWSTO, NONE}, {END, NONE}};
    open_two(12);
    start(0);
    play(sends, waits, 300);
    start(1); /* within a byte of FFh: the lines are high half of the time */
    play(sends + 1, waits, CYCLES);
    CHECK_INT(statuses[0][0], 0x08);
    CHECK_INT(status_count[0], 4);
    CHECK_STATUSES(1, 0x08, 0x20);
}

static void all_are_called(void)
{
    static const answer sends[] = {{GO, 0x00}, {GO, 0x77}, {GO | TWSTA, NONE}, {GO, 0x45}, {TWINT | TWEN, NONE}, {GO | TWSTO, NONE}, {END, NONE}};
    static const answer slave[] = {{GO, NONE}, {GO, NONE}, {GO, NONE}, {TWINT | TWEN, 0x99}, {GO, NONE}, {END, NONE}};
    open_two(2);
    start(0);
    play(sends, slave, CYCLES);
    CHECK_STATUSES(0, 0x08, 0x18, 0x28, 0x10, 0x40, 0x58);
    CHECK_STATUSES(1, 0x70, 0x90, 0xa0, 0xa8, 0xc0);
    CHECK_INT(data_of[1][1], 0x77);
    CHECK_INT(data_of[0][5], 0x99);
}

static void a_slave_without_acknowledgement_is_silent(void)
{
    static const answer sends[] = {{GO, 0x44}, {GO, 1}, {GO, 2}, {GO | TWSTO, NONE}, {END, NONE}};
    static const answer slave[] = {{TWINT | TWEN, NONE}, {TWINT | TWEN, NONE}, {END, NONE}};
    open_two(2);
    start(0);
    play(sends, slave, CYCLES);
    CHECK_STATUSES(0, 0x08, 0x18, 0x30, 0x30);
    CHECK_STATUSES(1, 0x60, 0x88);
}

/* Lines by hand: a START within a byte. TWSTO lets go of all, and no STOP is sent. */
static void a_start_within_a_byte_is_an_error(void)
{
    avr_lab *l = &lab[1];
    open_two(2);
    static const int lines[][2] = {{1, 1}, {0, 1}, {0, 0}, {0, 1}, {0, 0}, {1, 0}, {1, 1}, {0, 1}}; /* SDA, SCL */
    for (unsigned i = 0; i < sizeof(lines) / sizeof(lines[0]); i++) {
        avr_pin(&l->chip, SDA, lines[i][0]);
        avr_pin(&l->chip, SCL, lines[i][1]);
        lab_run(l, 20);
    }
    CHECK_INT(get(l, TWSR) & 0xf8, 0x00);
    CHECK_INT(get(l, TWCR) & TWINT, TWINT);
    put(l, TWCR, GO | TWSTO);
    CHECK_INT(get(l, TWCR) & (TWINT | TWSTO), 0);
    CHECK_INT(get(l, TWSR) & 0xf8, 0xf8);
    CHECK_INT(avr_driven(&l->chip, SDA), AVR_PULLED_UP);
}

static void a_slave_holds_the_clock(void)
{
    static const answer sends[] = {{GO, 0x44}, {GO, 0x12}, {GO | TWSTO, NONE}, {END, NONE}};
    static const answer never[] = {{END, NONE}};
    open_two(2);
    start(0);
    put(&lab[1], TWCR, TWEN | TWEA);
    play(sends, never, 3000); /* the slave leaves TWINT, and SCL low */
    CHECK_INT(avr_driven(&lab[1].chip, SCL), AVR_LOW);
    CHECK_STATUSES(0, 0x08, 0x18);
    static const answer then[] = {{GO, NONE}, {GO, NONE}, {END, NONE}};
    status_count[1] = 0;
    play(sends + 2, then, 3000);
    CHECK_INT(statuses[0][2], 0x28);
}

/* From power-down a slave wakes by its address alone. */
static void an_address_wakes(void)
{
    avr_lab *l = &lab[1];
    static const answer nobody[] = {{GO, 0x50}, {GO | TWSTO, NONE}, {END, NONE}}, mine[] = {{GO, 0x44}, {END, NONE}}, none[] = {{END, NONE}};
    open_two(2);
    put(l, TWCR, TWEN | TWEA | TWIE);
    sleep_in(l, 2); /* power-down */
    start(0);
    play(nobody, none, 1000);
    CHECK(l->chip.asleep);
    start(0);
    play(mine, none, 1000);
    CHECK(!l->chip.asleep);
}

void avr_two_masters_tests(void)
{
    RUN(the_lower_address_wins);
    RUN(who_lost_starts_again_when_the_bus_is_free);
    RUN(who_lost_is_the_slave_that_is_addressed);
    RUN(who_lost_is_called_with_all);
    RUN(who_lost_is_read);
    RUN(data_decides_where_addresses_are_alike);
    RUN(a_start_waits_for_the_end_of_anothers_transfer);
    RUN(all_are_called);
    RUN(a_slave_without_acknowledgement_is_silent);
    RUN(a_start_within_a_byte_is_an_error);
    RUN(a_slave_holds_the_clock);
    RUN(an_address_wakes);
}
