/* The ramp of easydriver_ramp.ino without Arduino's library: STEP at D6, DIR at D7, one turn there and one back for ever.

   Nothing else runs, and the processor sleeps between its interrupts: each begins at the same cycle of its period, so the
   times between steps are (OCR2A + 1) * 128 cycles exactly. */

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <util/delay.h>

enum {
    STEP = _BV(PD6),
    DIR = _BV(PD7),
    STEPS = 1600,
    RAMP = 10,
    FULL = 18,                           /* OCR2A at full speed */
    LESS = (255 - FULL) / RAMP,          /* 23 */
    FIRST = FULL + LESS * RAMP,          /* 248 */
    RESTS = 502,                         /* compares between moves: a second */
};

static uint16_t left = 0, rests = RESTS;
static uint8_t up, down;

ISR(TIMER2_COMPA_vect)
{
    if (left) {
        PORTD |= STEP;
        if (left == down) {
            down--;
            OCR2A += LESS;
        } else if (up) {
            up--;
            OCR2A -= LESS;
        }
        left--;
        _delay_us(1); /* the A3967's least */
        PORTD &= (uint8_t)~STEP;
    } else if (--rests == 0) {
        rests = RESTS;
        PORTD ^= DIR;
        OCR2A = FIRST;
        up = down = RAMP;
        left = STEPS;
    }
}

int main(void)
{
    DDRD = STEP | DIR;
    OCR2A = FIRST;
    TCCR2A = _BV(WGM21);
    TCCR2B = _BV(CS22) | _BV(CS20);
    TIMSK2 = _BV(OCIE2A);
    set_sleep_mode(SLEEP_MODE_IDLE);
    sei();
    for (;;) sleep_mode();
}
