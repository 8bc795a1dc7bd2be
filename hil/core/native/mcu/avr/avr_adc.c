#include "avr_adc.h"

#include "avr_interrupt.h"
#include "avr_pins.h"
#include "avr_registers.h"
#include "avr_time.h"
#include "avr_timer.h"

/* Clocks of the ADC, twice: when it samples, and when it is done. The first one after ADEN is longer, one that something
   triggers waits for its prescaler, which is reset: DS40002061, table ADC Conversion Time. */
enum { SAMPLED_2 = 3, DONE_2 = 26, FIRST_SAMPLED_2 = 27, FIRST_DONE_2 = 50, TRIGGERED_SAMPLED_2 = 4, TRIGGERED_DONE_2 = 27 };
/* Clocks of the CPU until a trigger has come through: Prescaling and Conversion Timing. LOOK_CLOCKS: between two looks at a
   voltage that another part of a bench makes, our choice. */
enum { TRIGGER_CLOCKS = 3, LOOK_CLOCKS = 64 };

static const double BANDGAP_VOLTS = 1.1, TEMPERATURE_VOLTS = 0.314; /* at 25 C: DS40002061, Temperature Measurement */

/* Clocks of half an ADC clock. */
static uint64_t half(const avr *m)
{
    static const uint8_t shifts[8] = {1, 1, 2, 3, 4, 5, 6, 7};
    return 1ull << (shifts[m->data[ADCSRA] & ADPS] - 1);
}

int avr_adc_samples(const avr *m)
{
    return m->adc.is_busy && !m->adc.is_sampled && (m->adc.mux & 15) < 8 ? m->adc.mux & 7 : -1;
}

static void schedule(avr *m)
{
    avr_adc *c = &m->adc;
    avr_due(m, AVR_PART_ADC, !c->is_busy ? AVR_NEVER : c->begun + half(m) * (c->is_sampled ? c->done_2 : c->sampled_2));
}

/* The flag that triggers, where another than the ADC's own does: table ADC Auto Trigger Source Selections. */
static int has_source(const avr *m)
{
    const uint8_t *d = m->data;
    switch (d[ADCSRB] & ADTS) {
    case 1: return d[ACSR] & ACI;
    case 2: return d[EIFR] & 1;
    case 3: return d[TIFR0] & OCFA;
    case 4: return d[TIFR0] & TOV;
    case 5: return d[TIFR1] & OCFB;
    case 6: return d[TIFR1] & TOV;
    case 7: return d[TIFR1] & ICF1;
    default: return 0;
    }
}

/* At the next edge of its clock. */
static void begin(avr *m, uint64_t at, int is_triggered)
{
    avr_adc *c = &m->adc;
    uint64_t clock = 2 * half(m);
    if (c->is_busy || !(m->data[ADCSRA] & ADEN) || m->data[PRR] & PRADC) return;
    if (is_triggered) c->begun = c->zero = at + TRIGGER_CLOCKS; /* it resets the prescaler */
    else c->begun = c->zero + ((at - c->zero) / clock + 1) * clock;
    c->is_busy = 1;
    c->is_sampled = 0;
    c->mux = m->data[ADMUX];
    c->sampled_2 = c->is_first ? FIRST_SAMPLED_2 : is_triggered ? TRIGGERED_SAMPLED_2 : SAMPLED_2;
    c->done_2 = c->is_first ? FIRST_DONE_2 : is_triggered ? TRIGGERED_DONE_2 : DONE_2;
    c->is_first = 0;
    m->data[ADCSRA] |= ADSC;
    schedule(m);
}

static uint16_t measured(const avr *m)
{
    static const uint8_t special[8] = {[0] = 1, [6] = 2, [7] = 3};
    int reference = m->adc.mux >> 6, channel = m->adc.mux & 15, is = channel < 8 ? 0 : special[channel - 8];
    double full = reference == 0 ? m->aref_volts : reference == 3 ? BANDGAP_VOLTS : m->vcc_volts;
    double volts = channel < 8 ? m->volts[channel] : is == 1 ? TEMPERATURE_VOLTS : is == 2 ? BANDGAP_VOLTS : 0;
    double counts = full > 0 ? volts * 1024 / full : 1023;
    return counts >= 1023 ? 1023 : counts > 0 ? (uint16_t)counts : 0;
}

void avr_adc_event(avr *m, uint64_t at)
{
    avr_adc *c = &m->adc;
    if (!c->is_sampled) {
        c->is_sampled = 1;
        c->sample = measured(m);
        schedule(m);
        return;
    }
    c->is_busy = 0;
    if (!c->is_locked) c->result = c->sample;
    m->data[ADCSRA] = (uint8_t)((m->data[ADCSRA] & ~ADSC) | ADIF);
    avr_due(m, AVR_PART_ADC, AVR_NEVER);
    if (m->data[ADCSRA] & ADATE && !(m->data[ADCSRB] & ADTS)) { /* free running: the next begins at this edge */
        begin(m, at - 1, 0);
    }
    avr_ask(m);
}

void avr_adc_trigger(avr *m, uint16_t timer_flags, int is_external, int is_comparator, uint64_t at)
{
    int has_risen = 0;
    if (!(m->data[ADCSRA] & ADATE)) return;
    switch (m->data[ADCSRB] & ADTS) {
    case 1: has_risen = is_comparator; break;
    case 2: has_risen = is_external; break;
    case 3: has_risen = timer_flags & OCFA; break;
    case 4: has_risen = timer_flags & TOV; break;
    case 5: has_risen = timer_flags & OCFB << 4; break;
    case 6: has_risen = timer_flags & TOV << 4; break;
    case 7: has_risen = (timer_flags & AVR_CAPTURED) != 0; break;
    default: break;
    }
    if (has_risen) begin(m, at, 1);
}

void avr_adc_sleeps(avr *m, uint64_t at) { begin(m, at, 0); }

uint8_t avr_adc_load(avr *m, unsigned address)
{
    avr_adc *c = &m->adc;
    if (address != ADCL && address != ADCH) return m->data[address];
    uint16_t shown = m->data[ADMUX] & ADLAR ? (uint16_t)(c->result << 6) : c->result;
    c->is_locked = address == ADCL;
    return (uint8_t)(address == ADCL ? shown : shown >> 8);
}

void avr_adc_store(avr *m, unsigned address, uint8_t value, uint64_t at)
{
    avr_adc *c = &m->adc;
    uint8_t was = m->data[ADCSRA];
    int had_source;
    switch (address) {
    case ADMUX: m->data[ADMUX] = value & 0xef; break;
    case ADCSRB:
        had_source = has_source(m);
        m->data[ADCSRB] = value & (ACME | ADTS);
        if (was & ADATE && !had_source && has_source(m)) begin(m, at, 1); /* a rising edge, too */
        break;
    case ADCSRA:
        m->data[ADCSRA] = (uint8_t)((value & ~(ADIF | ADSC)) | (was & ADSC) | (was & ~value & ADIF));
        if (!(value & ADEN)) {
            c->is_busy = 0;
            m->data[ADCSRA] &= (uint8_t)~ADSC;
        } else if (!(was & ADEN)) {
            c->zero = at;
            c->is_first = 1;
        }
        if (value & ADSC) begin(m, at, 0);
        schedule(m);
        avr_ask(m);
        break;
    default: break;
    }
    if (c->is_comparator_used) avr_comparator_use(m, at); /* its input may be another */
}

void avr_adc_shift(avr *m, uint64_t clocks)
{
    m->adc.zero += clocks;
    m->adc.begun += clocks;
}

int avr_comparator_channel(const avr *m)
{
    return m->data[ADCSRB] & ACME && !(m->data[ADCSRA] & ADEN) && !(m->data[PRR] & PRADC) ? m->data[ADMUX] & 7 : -1;
}

void avr_comparator_use(avr *m, uint64_t at)
{
    int is_looking = avr_comparator_channel(m) >= 0 && !(m->data[ACSR] & ACD);
    m->adc.is_comparator_used = 1;
    avr_comparator_look(m, at);
    if (is_looking && m->due[AVR_PART_COMPARATOR] == AVR_NEVER) avr_due(m, AVR_PART_COMPARATOR, at + 1);
}

void avr_comparator_event(avr *m, int may_change, uint64_t at)
{
    int goes_on = may_change && avr_comparator_channel(m) >= 0 && !(m->data[ACSR] & ACD);
    avr_comparator_look(m, at);
    avr_due(m, AVR_PART_COMPARATOR, goes_on ? at + LOOK_CLOCKS : AVR_NEVER);
}

void avr_comparator_look(avr *m, uint64_t at)
{
    int channel = avr_comparator_channel(m);
    uint8_t *status = &m->data[ACSR], was = *status & ACO;
    uint8_t levels = m->port[AVR_PORT_D].level;
    double positive = *status & ACBG ? BANDGAP_VOLTS : levels >> 6 & 1 ? m->vcc_volts : 0;
    double negative = channel >= 0 ? m->volts[channel] : levels >> 7 & 1 ? m->vcc_volts : 0;
    int is_high = !(*status & ACD) && positive > negative;
    *status = (uint8_t)((*status & ~ACO) | (is_high ? ACO : 0));
    if (is_high == (was != 0) || *status & ACD) return;
    if (*status & ACIC) avr_timer_edge(m, is_high, at);
    int sense = *status & ACIS;
    if (sense == 0 || sense == 2 + is_high) {
        int has_risen = !(*status & ACI);
        *status |= ACI;
        if (has_risen) avr_adc_trigger(m, 0, 0, 1, at);
        avr_ask(m);
    }
}
