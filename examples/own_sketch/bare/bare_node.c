/* A node of an RS485 line without Arduino's library: SACs' packets at 38400 baud, as line_node.ino has them, and no motor.

   Address 41, driver enable at D2 (high: it drives), an LED at D13 that each command "y" turns round. What comes for it, it
   answers by ACK, or by NAK if the CRC is wrong. Built with -DEARLY it lets go of the line as soon as the last byte is in
   UDR0, not when it has gone: a fault that many sketches have. */

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/crc16.h>
#include <util/delay.h>

enum { ADDRESS = 41, STX = 2, ETX = 3, ACK = 6, NAK = 21, DRIVE = _BV(PD2), LED = _BV(PB5), CHARACTER_US = 260, MOST = 80 };

static uint8_t data[MOST], n;

static uint8_t hear(void)
{
    loop_until_bit_is_set(UCSR0A, RXC0);
    return UDR0;
}

static void say(uint8_t byte)
{
    loop_until_bit_is_set(UCSR0A, UDRE0);
    UCSR0A = _BV(U2X0) | _BV(TXC0); /* the flag is cleared by a 1 */
    UDR0 = byte;
}

static uint8_t crc8(const uint8_t *of, uint8_t length)
{
    uint8_t crc = 0;
    while (length--) crc = _crc_ibutton_update(crc, *of++);
    return crc;
}

static void answer(uint8_t to, uint8_t with)
{
    _delay_us(2 * CHARACTER_US);
    PORTD |= DRIVE;
    say(STX);
    say(to);
    say(ADDRESS);
    say(with);
    say(ETX);
    say(crc8(&with, 1));
    say(0);
#ifdef EARLY
    loop_until_bit_is_set(UCSR0A, UDRE0);
#else
    loop_until_bit_is_set(UCSR0A, TXC0);
#endif
    PORTD &= (uint8_t)~DRIVE;
}

/* One packet, from behind its STX; another STX begins another one. */
static void packet(void)
{
    uint8_t to, from, byte;
    do {
        to = hear();
        from = hear();
        for (n = 0; (byte = hear()) != ETX && byte != STX; data[n++] = byte)
            if (byte == 0 || n == MOST) return;
    } while (byte == STX);
    uint8_t crc = hear();
    if ((crc && hear() != 0) || (to != ADDRESS && to != 0)) return;
    uint8_t is_good = !crc || crc == crc8(data, n);
    if (n == 1 && (data[0] == ACK || data[0] == NAK)) return;
    if (is_good && n && data[0] == 'y') PINB = LED;
    if (to == ADDRESS) answer(from, is_good ? ACK : NAK);
}

int main(void)
{
    DDRD = DRIVE;
    DDRB = LED;
    UCSR0A = _BV(U2X0);
    UBRR0 = 51; /* 38462 baud */
    UCSR0B = _BV(RXEN0) | _BV(TXEN0);
    for (;;)
        if (hear() == STX) packet();
}
