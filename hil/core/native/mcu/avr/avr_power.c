#include "avr_power.h"

#include "avr_adc.h"
#include "avr_receiver.h"
#include "avr_registers.h"
#include "avr_time.h"
#include "avr_timer.h"
#include "avr_usart.h"

/* Parts and their bits; timers look at theirs themselves. */
static const struct gate {
    uint8_t bit, part;
} GATES[] = {{PRUSART, AVR_PART_SEND}, {PRUSART, AVR_PART_RECEIVE}, {PRSPI, AVR_PART_SPI}, {PRTWI, AVR_PART_TWI}, {PRADC, AVR_PART_ADC}};

static void stop(avr *m, int part, uint64_t at)
{
    m->gated[part] = at;
    m->gated_due[part] = m->due[part];
    avr_due(m, (enum avr_part)part, AVR_NEVER);
}

static void go_on(avr *m, int part, uint64_t at)
{
    uint64_t still = at - m->gated[part], due = m->gated_due[part];
    avr_due(m, (enum avr_part)part, due == AVR_NEVER ? AVR_NEVER : due + still);
    if (part == AVR_PART_SEND) avr_usart_shift(m, still);
    if (part == AVR_PART_ADC) avr_adc_shift(m, still);
    if (part != AVR_PART_RECEIVE || m->usart.is_receiving) return;
    m->usart.looked = avr_outer(m, at); /* what came meanwhile was not heard */
    avr_receiver_look(m, at);
}

void avr_power_store(avr *m, uint8_t value, uint64_t at)
{
    uint8_t was = m->data[PRR], now = value & 0xef;
    for (unsigned i = 0; i < sizeof(GATES) / sizeof(GATES[0]); i++)
        if (now & ~was & GATES[i].bit) stop(m, GATES[i].part, at);
    m->data[PRR] = now;
    for (unsigned i = 0; i < sizeof(GATES) / sizeof(GATES[0]); i++)
        if (was & ~now & GATES[i].bit) go_on(m, GATES[i].part, at);
    avr_timer_gates(m, at);
}
