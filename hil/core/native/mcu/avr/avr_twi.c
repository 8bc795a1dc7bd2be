#include "avr_twi.h"

#include "avr_interrupt.h"
#include "avr_pins.h"
#include "avr_registers.h"
#include "avr_time.h"

enum { SDA = 1 << 4, SCL = 1 << 5 }; /* of port C */

/* What a master is about; a slave goes by the lines, as each does that has lost the bus. */
enum master { IDLE, STARTING, STARTED, BIT_LOW, BIT_HIGH, HOLDING, STOPPING, STOPPING_HIGH };
enum slave { UNADDRESSED, ADDRESS, SLAVE_RECEIVES, SLAVE_SENDS, LOSING /* until the byte is over */ };
enum { BITS = 9 }; /* eight and the acknowledgement */

/* TWSR, table Status Codes. */
enum {
    BUS_ERROR = 0, START = 0x08, REPEATED = 0x10, WRITE_ACK = 0x18, DATA_OUT_ACK = 0x28, LOST = 0x38, READ_ACK = 0x40, DATA_IN_ACK = 0x50,
    OWN_WRITE = 0x60, ALL_WRITE = 0x70, OWN_DATA_ACK = 0x80, ALL_DATA_ACK = 0x90, SLAVE_STOP = 0xa0, OWN_READ = 0xa8, SENT_ACK = 0xb8,
    SENT_NACK = 0xc0, SENT_LAST = 0xc8, NOTHING = 0xf8,
    AS_SLAVE = 8 /* added to 60h, 70h and A8h: it was a master, and has lost the bus to the one that addresses it */
};

static int level_of(const avr *m, uint8_t line) { return m->port[AVR_PORT_C].level & line ? 1 : 0; }

/* Pulls the lines low, or lets them go. */
static void drive(avr *m, uint64_t at)
{
    const avr_twi *w = &m->twi;
    int is_on = m->data[TWCR] & TWEN;
    avr_pins_own(m, AVR_PORT_C, SDA | SCL, is_on, 0);
    avr_pins_direct(m, AVR_PORT_C, SDA, is_on && w->pulls_data, is_on && !w->pulls_data);
    avr_pins_direct(m, AVR_PORT_C, SCL, is_on && w->pulls_clock, is_on && !w->pulls_clock);
    avr_pins_refresh(m, AVR_PORT_C, at);
}

static uint64_t half(const avr *m)
{
    return 8 + ((uint64_t)m->data[TWBR] << 2 * (m->data[TWSR] & 3)); /* 16 + 2 TWBR 4^TWPS clocks a bit */
}

static void tell(avr *m, int status)
{
    m->data[TWSR] = (uint8_t)(status | (m->data[TWSR] & 7));
    m->data[TWCR] |= TWINT;
    avr_ask(m);
}

static void wait_half(avr *m, int next, uint64_t at)
{
    m->twi.master = (uint8_t)next;
    avr_due(m, AVR_PART_TWI, at + half(m));
}

/* A byte is through: SCL stays low until the program has dealt with it. */
static void byte_done(avr *m)
{
    avr_twi *w = &m->twi;
    int is_acknowledged = !(w->shifted & 1);
    w->master = HOLDING;
    avr_due(m, AVR_PART_TWI, AVR_NEVER);
    if (w->is_reading) {
        m->data[TWDR] = (uint8_t)(w->shifted >> 1);
        tell(m, is_acknowledged ? DATA_IN_ACK : DATA_IN_ACK + 8);
    } else if (w->is_address) {
        w->is_reading = w->shifted >> 1 & 1 && is_acknowledged;
        tell(m, (w->shifted & 2 ? READ_ACK : WRITE_ACK) + (is_acknowledged ? 0 : 8));
    } else {
        tell(m, is_acknowledged ? DATA_OUT_ACK : DATA_OUT_ACK + 8);
    }
    w->is_address = 0;
}

/* Bit number w->bits of a byte, at SDA while SCL is low. */
static void put_bit(avr *m)
{
    avr_twi *w = &m->twi;
    int is_acknowledgement = w->bits == BITS - 1;
    if (w->is_reading) w->pulls_data = is_acknowledgement && m->data[TWCR] & TWEA;
    else w->pulls_data = !is_acknowledgement && !(m->data[TWDR] >> (7 - w->bits) & 1);
}

/* Another master has the bus. The byte under way is followed to its end: it may be for this chip. */
static void lose(avr *m)
{
    avr_twi *w = &m->twi;
    w->master = IDLE;
    w->slave = w->is_address ? ADDRESS : LOSING;
    w->is_lost = 1;
    w->pulls_data = w->pulls_clock = w->is_repeated = 0;
}

/* A START or a STOP where none may be. */
static void fail(avr *m)
{
    avr_twi *w = &m->twi;
    w->master = IDLE;
    w->slave = UNADDRESSED;
    w->pulls_data = w->pulls_clock = w->is_repeated = w->is_lost = 0;
    avr_due(m, AVR_PART_TWI, AVR_NEVER);
    tell(m, BUS_ERROR);
}

/* SCL is high: a bit is taken. Who lets SDA go and finds it low has lost the bus. */
static void bit_high(avr *m, uint64_t at)
{
    avr_twi *w = &m->twi;
    int data = level_of(m, SDA), is_ours = (w->bits < BITS - 1) != w->is_reading;
    w->shifted = (uint16_t)(w->shifted << 1 | data);
    if (is_ours && !w->pulls_data && !data) lose(m);
    else wait_half(m, BIT_HIGH, at);
}

static void bit_over(avr *m, uint64_t at)
{
    avr_twi *w = &m->twi;
    w->pulls_clock = 1;
    if (++w->bits == BITS) {
        w->pulls_data = 0;
        byte_done(m);
        return;
    }
    put_bit(m);
    wait_half(m, BIT_LOW, at);
}

static void started(avr *m)
{
    avr_twi *w = &m->twi;
    w->pulls_clock = 1;
    w->master = HOLDING;
    w->is_address = 1;
    w->is_reading = 0;
    avr_due(m, AVR_PART_TWI, AVR_NEVER);
    tell(m, w->is_repeated ? REPEATED : START);
    w->is_repeated = 1;
}

void avr_twi_event(avr *m, uint64_t at)
{
    avr_twi *w = &m->twi;
    avr_due(m, AVR_PART_TWI, AVR_NEVER);
    switch (w->master) {
    case STARTING: /* both lines have been high for half a bit; they may be low by now */
        if (!level_of(m, SCL) || (w->is_repeated && !level_of(m, SDA))) break;
        w->pulls_data = 1;
        wait_half(m, STARTED, at);
        break;
    case STARTED: started(m); break;
    case BIT_LOW: /* SCL rises, if no other holds it */
        w->pulls_clock = 0;
        drive(m, at);
        if (level_of(m, SCL)) bit_high(m, at);
        break;
    case BIT_HIGH: bit_over(m, at); break;
    case STOPPING: /* SDA low, SCL rises */
        w->pulls_clock = 0;
        drive(m, at);
        if (level_of(m, SCL)) wait_half(m, STOPPING_HIGH, at);
        break;
    case STOPPING_HIGH:
        w->pulls_data = w->is_repeated = 0;
        w->master = IDLE;
        m->data[TWCR] &= (uint8_t)~TWSTO;
        drive(m, at);
        if (m->data[TWCR] & TWSTA) wait_half(m, STARTING, at);
        break;
    default: break;
    }
    drive(m, at);
}

/* Where a master waits for a line, it goes on when that is high; for a START the bus has to be free, or its own. */
static void go_on(avr *m, uint64_t at)
{
    avr_twi *w = &m->twi;
    if (m->due[AVR_PART_TWI] != AVR_NEVER || !level_of(m, SCL)) return;
    if (w->master == BIT_LOW && !w->pulls_clock) bit_high(m, at);
    else if (w->master == STOPPING && !w->pulls_clock) wait_half(m, STOPPING_HIGH, at);
    else if (w->master == STARTING && level_of(m, SDA) && (!w->is_busy || w->is_repeated)) wait_half(m, STARTING, at);
}

/* TWINT was cleared: the master's next step. */
static void command(avr *m, uint64_t at)
{
    avr_twi *w = &m->twi;
    uint8_t control = m->data[TWCR];
    if (control & TWSTO) {
        if (w->master == HOLDING) {
            w->pulls_data = 1;
            wait_half(m, STOPPING, at);
        } else { /* a slave in trouble gets out of it */
            w->slave = UNADDRESSED;
            w->pulls_data = w->pulls_clock = 0;
            m->data[TWCR] &= (uint8_t)~TWSTO;
            if (control & TWSTA) w->master = STARTING;
        }
    } else if (control & TWSTA && w->slave <= ADDRESS) {
        w->pulls_data = w->pulls_clock = 0;
        w->master = STARTING;
    } else if (w->master == HOLDING) {
        w->bits = 0;
        w->shifted = 0;
        put_bit(m);
        wait_half(m, BIT_LOW, at);
    } else { /* a slave lets SCL go */
        if (w->slave == SLAVE_SENDS) w->pulls_data = !(m->data[TWDR] >> 7);
        w->pulls_clock = 0;
    }
    drive(m, at);
    go_on(m, at);
}

static int is_own_address(const avr *m, unsigned byte)
{
    uint8_t own = m->data[TWAR], any = m->data[TWAMR];
    if (byte == 0) return own & 1 ? 2 : 0; /* the general call */
    return !((byte ^ own) & 0xfe & ~any);
}

/* Eight bits are in: whether a slave acknowledges them. */
static void slave_byte(avr *m)
{
    avr_twi *w = &m->twi;
    int may = m->data[TWCR] & TWEA ? 1 : 0;
    if (w->slave == ADDRESS) {
        w->is_mine = (uint8_t)(may ? is_own_address(m, w->slave_shifted & 0xff) : 0);
        w->pulls_data = w->is_mine != 0;
        if (!w->is_mine) w->slave = w->is_lost ? LOSING : UNADDRESSED;
    } else if (w->slave == SLAVE_RECEIVES) {
        w->pulls_data = (uint8_t)may;
        w->is_acknowledging = (uint8_t)may;
    } else if (w->slave == SLAVE_SENDS) {
        w->pulls_data = 0;
        w->is_acknowledging = (uint8_t)may;
    }
}

/* The acknowledgement is through, SCL is low: it stays so until the program goes on. */
static void slave_done(avr *m)
{
    avr_twi *w = &m->twi;
    unsigned byte = w->slave_shifted >> 1 & 0xff, nack = w->slave_shifted & 1, lost = w->is_lost ? AS_SLAVE : 0;
    w->is_lost = 0;
    if (w->slave == LOSING) {
        w->slave = UNADDRESSED;
        tell(m, LOST);
        return;
    }
    w->pulls_data = 0;
    w->pulls_clock = 1;
    if (w->slave == ADDRESS) {
        w->slave = byte & 1 && w->is_mine == 1 ? SLAVE_SENDS : SLAVE_RECEIVES;
        m->data[TWDR] = (uint8_t)byte;
        tell(m, (int)lost + (w->slave == SLAVE_SENDS ? OWN_READ : w->is_mine == 2 ? ALL_WRITE : OWN_WRITE));
    } else if (w->slave == SLAVE_RECEIVES) {
        m->data[TWDR] = (uint8_t)byte;
        tell(m, (w->is_mine == 2 ? ALL_DATA_ACK : OWN_DATA_ACK) + (w->is_acknowledging ? 0 : 8));
        if (!w->is_acknowledging) w->slave = UNADDRESSED;
    } else {
        tell(m, nack ? SENT_NACK : w->is_acknowledging ? SENT_ACK : SENT_LAST);
        if (nack || !w->is_acknowledging) w->slave = UNADDRESSED;
    }
}

/* SCL has changed: all bits since a START are counted, whoever's they are; a slave deals with them. */
static void clock_changes(avr *m, int is_high, int data, uint64_t at)
{
    avr_twi *w = &m->twi;
    if (is_high) {
        w->slave_shifted = (uint16_t)(w->slave_shifted << 1 | data);
        w->slave_bits++;
        return;
    }
    if (w->master == BIT_HIGH && !w->pulls_clock) bit_over(m, at); /* the first master whose bit is over ends it for all */
    else if (w->master == STARTED) started(m);
    int is_slave = !w->is_repeated && w->slave != UNADDRESSED;
    if (is_slave && w->slave_bits == BITS - 1) slave_byte(m);
    else if (is_slave && w->slave_bits == BITS) slave_done(m);
    else if (is_slave && w->slave == SLAVE_SENDS && w->slave_bits) w->pulls_data = !(m->data[TWDR] >> (7 - w->slave_bits) & 1);
    if (w->slave_bits == BITS) w->slave_bits = 0;
}

/* A START or a STOP, also one of its own. SCL has risen for it as for a bit; where more of a byte is in, it may not be. */
static void condition(avr *m, int is_stop)
{
    avr_twi *w = &m->twi;
    int is_inside = w->slave_bits > 1, was_receiving = w->slave == SLAVE_RECEIVES;
    int is_concerned = w->is_repeated || w->slave > ADDRESS || (w->slave == ADDRESS && m->data[TWCR] & TWEA);
    w->is_busy = !is_stop;
    w->slave_bits = 0;
    if (is_inside && is_concerned) {
        fail(m);
        return;
    }
    w->slave = is_stop ? UNADDRESSED : ADDRESS;
    if (w->master == STARTING && !is_stop && !w->is_repeated) avr_due(m, AVR_PART_TWI, AVR_NEVER); /* another was first */
    if (!was_receiving) return;
    w->pulls_clock = 0;
    tell(m, SLAVE_STOP);
}

void avr_twi_edges(avr *m, uint8_t level, uint8_t before, uint64_t at)
{
    uint8_t changes = level ^ before;
    if (!(m->data[TWCR] & TWEN) || m->data[PRR] & PRTWI) return;
    if (changes & SDA && level & before & SCL) condition(m, level & SDA ? 1 : 0);
    else if (changes & SCL) clock_changes(m, level & SCL ? 1 : 0, level & SDA ? 1 : 0, at);
    drive(m, at);
    go_on(m, at);
}

void avr_twi_store(avr *m, unsigned address, uint8_t value, uint64_t at)
{
    avr_twi *w = &m->twi;
    switch (address) {
    case TWSR: m->data[TWSR] = (uint8_t)((m->data[TWSR] & 0xf8) | (value & 3)); break;
    case TWDR:
        if (m->data[TWCR] & TWINT) m->data[TWDR] = value;
        else m->data[TWCR] |= TWWC;
        break;
    case TWCR: {
        uint8_t was = m->data[TWCR];
        m->data[TWCR] = (uint8_t)((value & (TWEA | TWSTA | TWSTO | TWEN | TWIE)) | (was & TWINT & ~value) | (was & TWWC));
        if (value & TWINT) m->data[TWCR] &= (uint8_t)~TWWC;
        if (!(value & TWEN)) {
            *w = (avr_twi){0};
            avr_due(m, AVR_PART_TWI, AVR_NEVER);
            drive(m, at);
        } else if (value & TWINT || (value & ~was & TWSTA && !(was & TWINT) && w->master == IDLE)) {
            m->data[TWSR] |= NOTHING;
            command(m, at);
        }
        avr_ask(m);
        break;
    }
    default: m->data[address] = value; break;
    }
}
