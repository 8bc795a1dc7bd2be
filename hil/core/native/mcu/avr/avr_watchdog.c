#include "avr_watchdog.h"

#include "avr_interrupt.h"
#include "avr_registers.h"
#include "avr_time.h"

enum { LEAST_CYCLES = 2048, HZ = 128000, CHANGE_CLOCKS = 4 }; /* of its oscillator: table Watchdog Timer Prescale Select */
enum { WDP = 0x27 };

void avr_watchdog_restart(avr *m, uint64_t at)
{
    uint8_t control = m->data[WDTCSR];
    int slower = (control & 7) | (control & WDP3 ? 8 : 0);
    int is_on = control & (WDE | WDIE) || !(m->fuses[1] & 0x10); /* WDTON */
    if (slower > 9) slower = 9;
    avr_due(m, AVR_PART_WATCHDOG, is_on ? at + avr_clocks(m, (double)((uint32_t)LEAST_CYCLES << slower) / HZ) : AVR_NEVER);
}

void avr_watchdog_store(avr *m, uint8_t value, uint64_t at)
{
    uint8_t was = m->data[WDTCSR], now = was;
    int may_change = was & WDCE && at <= m->watchdog_armed;
    now = (uint8_t)((now & ~(WDIE | WDCE)) | (value & WDIE));
    if (value & WDIF) now &= (uint8_t)~WDIF;
    if (may_change) now = (uint8_t)((now & ~(WDE | WDP)) | (value & (WDE | WDP)));
    else now |= value & WDE; /* it can be set at any time */
    if (value & WDCE && value & WDE) { /* a timed sequence begins; itself it changes nothing */
        now = (uint8_t)((now & ~WDE) | (was & WDE) | WDCE);
        m->watchdog_armed = at + CHANGE_CLOCKS;
    }
    if (m->data[MCUSR] & WDRF) now |= WDE;
    m->data[WDTCSR] = now;
    if (!(now & (WDE | WDIE))) m->watchdog_loops = 0;
    if ((now ^ was) & (WDE | WDIE | WDP)) avr_watchdog_restart(m, at);
    avr_ask(m);
}

int avr_watchdog_event(avr *m, uint64_t at)
{
    uint8_t *control = &m->data[WDTCSR];
    if (*control & WDIE && m->fuses[1] & 0x10) {
        *control |= WDIF;
        avr_watchdog_restart(m, at);
        avr_ask(m);
        return 0;
    }
    if (*control & WDE || !(m->fuses[1] & 0x10)) return 1;
    m->due[AVR_PART_WATCHDOG] = AVR_NEVER;
    return 0;
}
