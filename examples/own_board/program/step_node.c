/* Program of the step_node, without Arduino's library: it answers single letters at 38400 baud.

   ?  "sense N feedback M", the converter's counts at ADC6 and PC0; the fan gets the first one's as its PWM
   s  200 steps, one each millisecond, then "done"
   r  turns the direction round

   The LED changes with each letter. */

#include <avr/io.h>
#include <stdlib.h>
#include <util/delay.h>

enum { FAN = _BV(PD3), DIR = _BV(PD4), DRIVE = _BV(PD2), STEP = _BV(PB1), LED = _BV(PB5), SENSE = 6, FEEDBACK = 0, STEPS = 200 };

static void put(char letter)
{
    loop_until_bit_is_set(UCSR0A, UDRE0);
    UCSR0A = _BV(U2X0) | _BV(TXC0); /* the flag is cleared by a 1 */
    UDR0 = (uint8_t)letter;
}

static void say(const char *text)
{
    PORTD |= DRIVE;
    while (*text) put(*text++);
    loop_until_bit_is_set(UCSR0A, TXC0);
    PORTD &= (uint8_t)~DRIVE;
}

static void say_number(const char *before, uint16_t number)
{
    char text[6];
    say(before);
    say(utoa(number, text, 10));
}

static uint16_t counts(uint8_t channel)
{
    ADMUX = channel; /* against AREF */
    ADCSRA |= _BV(ADSC);
    loop_until_bit_is_clear(ADCSRA, ADSC);
    return ADC;
}

static void step(void)
{
    for (uint8_t left = STEPS; left; left--) {
        PORTB |= STEP;
        _delay_us(10);
        PORTB &= (uint8_t)~STEP;
        _delay_us(990);
    }
    say("done\r\n");
}

static void tell(void)
{
    uint16_t sensed = counts(SENSE);
    OCR2B = (uint8_t)(sensed >> 2);
    say_number("sense ", sensed);
    say_number(" feedback ", counts(FEEDBACK));
    say("\r\n");
}

int main(void)
{
    DDRD = FAN | DIR | DRIVE;
    DDRB = STEP | LED;
    UCSR0A = _BV(U2X0);
    UBRR0 = 25; /* 38462 baud */
    UCSR0B = _BV(RXEN0) | _BV(TXEN0);
    ADCSRA = _BV(ADEN) | _BV(ADPS2) | _BV(ADPS1); /* 125 kHz */
    TCCR2A = _BV(COM2B1) | _BV(WGM21) | _BV(WGM20);
    TCCR2B = _BV(CS21);
    say("ready\r\n");
    for (;;) {
        loop_until_bit_is_set(UCSR0A, RXC0);
        uint8_t letter = UDR0;
        PINB = LED;
        if (letter == '?') tell();
        else if (letter == 's') step();
        else if (letter == 'r') PIND = DIR;
    }
}
