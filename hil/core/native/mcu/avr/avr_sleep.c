#include "avr_sleep.h"

#include "avr_adc.h"
#include "avr_crystal.h"
#include "avr_registers.h"
#include "avr_time.h"
#include "avr_timer.h"
#include "avr_usart.h"

enum { IDLE, NOISE_REDUCTION, POWER_DOWN, POWER_SAVE, STANDBY = 6, EXTENDED_STANDBY };
/* Clocks of a Uno's crystal until it is trusted, by its fuses; of one that runs on; and of the CPU after that: tables
   Start-up Times, section Sleep Modes. */
enum { CRYSTAL_CLOCKS = 16384, RUNNING_CLOCKS = 6, HALTED_CLOCKS = 4 };

/* Whether timer 2 goes on by its own crystal: table Active Clock Domains and Wake-up Sources, Timer Oscillator Enabled. */
static int has_timer_2(const avr *m, int mode) { return avr_is_asynchronous(m) && mode != POWER_DOWN && mode != STANDBY; }

/* What may end a mode: the same table, Wake-up Sources. */
static uint32_t waking(const avr *m, int mode)
{
    uint32_t deep = 1u << VECTOR_INT0 | 1u << VECTOR_INT1 | 7u << VECTOR_PCINT0 | 1u << VECTOR_WDT | 1u << VECTOR_TWI;
    if (mode == IDLE) return UINT32_MAX;
    if (has_timer_2(m, mode)) deep |= 7u << VECTOR_T2_COMPA;
    return mode == NOISE_REDUCTION ? deep | 1u << VECTOR_ADC | 1u << VECTOR_EE_READY | 1u << VECTOR_SPM_READY : deep;
}

/* Parts that go by the I/O clock; the ADC has its own, which power-down stops too. */
static uint32_t stopped_parts(const avr *m, int mode)
{
    uint32_t io = 1u << AVR_PART_TIMER0 | 1u << AVR_PART_TIMER1 | 1u << AVR_PART_TIMER2 | 1u << AVR_PART_SEND |
                  1u << AVR_PART_RECEIVE | 1u << AVR_PART_SPI | 1u << AVR_PART_TWI | 1u << AVR_PART_COMPARATOR;
    if (has_timer_2(m, mode)) io &= ~(1u << AVR_PART_TIMER2);
    return mode == IDLE ? 0 : mode == NOISE_REDUCTION ? io : io | 1u << AVR_PART_ADC;
}

void avr_sleep(avr *m, uint64_t at)
{
    uint8_t control = m->data[SMCR];
    if (!(control & SE)) return;
    int mode = control >> 1 & 7;
    m->asleep = (uint8_t)(mode + 1);
    m->attention = 0;
    m->waking = waking(m, mode) | m->asking; /* what has asked already ends it at once */
    if (mode <= NOISE_REDUCTION) avr_adc_sleeps(m, at);
    uint32_t stopped = stopped_parts(m, mode);
    m->is_frozen = stopped != 0;
    m->is_crystal_frozen = m->is_frozen && !has_timer_2(m, mode);
    m->frozen = at;
    for (int part = 0; part < AVR_PARTS; part++) {
        if (!(stopped >> part & 1)) continue;
        m->frozen_due[part] = m->due[part];
        m->due[part] = AVR_NEVER;
    }
    if (!avr_may_wake(m)) avr_note_once(m, AVR_NOTE_ASLEEP, (uint16_t)(m->pc * 2));
}

void avr_wake(avr *m, uint64_t at)
{
    int mode = m->asleep - 1;
    uint64_t start_up = mode == POWER_DOWN || mode == POWER_SAVE ? CRYSTAL_CLOCKS : mode >= STANDBY ? RUNNING_CLOCKS : 0;
    uint64_t end = at + start_up;
    m->asleep = 0;
    m->attention = 0;
    m->t = end + HALTED_CLOCKS;
    if (!m->is_frozen) return;
    uint32_t stopped = stopped_parts(m, mode);
    uint64_t still = end - m->frozen;
    m->is_frozen = 0;
    for (int part = 0; part < AVR_PARTS; part++)
        if (stopped >> part & 1) m->due[part] = m->frozen_due[part] == AVR_NEVER ? AVR_NEVER : m->frozen_due[part] + still;
    avr_timer_shift(m, still);
    m->is_crystal_frozen = 0;
    if (!(m->data[PRR] & PRUSART)) avr_usart_shift(m, still);
    avr_due(m, AVR_PART_LINE, end + 1);
    if (mode != NOISE_REDUCTION && !(m->data[PRR] & PRADC)) avr_adc_shift(m, still);
    m->usart.looked = avr_outer(m, end);
}

int avr_may_wake(const avr *m)
{
    const uint8_t *d = m->data;
    if (d[WDTCSR] & WDE || !(m->fuses[1] & 0x10)) return 1;
    if (!(m->sreg & FLAG_I)) return 0;
    if (m->asking & m->waking || d[WDTCSR] & WDIE || d[PCICR] & 7 || d[EIMSK] & 3 || d[TWCR] & TWIE) return 1;
    if (m->waking >> VECTOR_EE_READY & 1 && d[EECR] & EERIE) return 1;
    if (m->waking >> VECTOR_T2_OVF & 1 && avr_is_asynchronous(m) && d[TIMSK2]) return 1;
    if (m->asleep == IDLE + 1)
        return d[TIMSK0] | d[TIMSK1] | d[TIMSK2] | (d[UCSR0B] & (RXCIE | TXCIE | UDRIE)) | (d[SPCR] & SPIE) | (d[ADCSRA] & ADIE) |
               (d[ACSR] & ACIE);
    return m->asleep == NOISE_REDUCTION + 1 && d[ADCSRA] & ADIE;
}
