#include "avr_memory.h"

#include <string.h>

#include "avr_decode.h"
#include "avr_interrupt.h"
#include "avr_registers.h"
#include "avr_time.h"

enum {
    ARMED_CLOCKS = 4,     /* within which a second write must follow */
    NRWW_WORD = 0x3800,   /* from here on the CPU halts while a page is written: table Read-While-Write Limit */
    PAGE_WORDS = AVR_PAGE_BYTES / 2
};
/* Tables EEPROM Mode Bits, and SPM Programming Time. */
static const double BOTH_SECONDS = 3.4e-3, ONE_SECONDS = 1.8e-3, PAGE_SECONDS = 4.5e-3;

/* BOOTSZ: 256, 512, 1024, 2048 words. */
unsigned avr_boot_start(const avr *m) { return AVR_FLASH_WORDS - (256u << (3 - (m->fuses[1] >> 1 & 3))); }

unsigned avr_eeprom_address(const avr *m) { return (m->data[EEARH] << 8 | m->data[EEARL]) & (AVR_EEPROM_BYTES - 1); }

void avr_eeprom_store(avr *m, uint8_t value, uint64_t at)
{
    uint8_t *control = &m->data[EECR], was = *control;
    int is_busy = was & EEPE, is_armed = was & EEMPE && at <= m->eeprom_armed;
    uint8_t mode = is_busy ? was & EEPM : value & EEPM;
    *control = (uint8_t)((value & EERIE) | mode | (was & (EEPE | EEMPE)));
    if (!is_armed) *control &= (uint8_t)~EEMPE;
    if (value & EEMPE && !(value & EEPE)) {
        *control |= EEMPE;
        m->eeprom_armed = at + ARMED_CLOCKS;
    }
    int is_flash_busy = m->data[SPMCSR] & (PGWRT | PGERS) && !m->spm_armed; /* no write to the EEPROM then */
    if (value & EEPE && is_armed && !is_busy && !is_flash_busy) {
        uint8_t *cell = &m->eeprom[avr_eeprom_address(m)];
        if (mode != EEPM) *cell = (uint8_t)((mode == 0x20 ? *cell : 0xff) & (mode == 0x10 ? 0xff : m->data[EEDR]));
        *control = (uint8_t)((*control & ~EEMPE) | EEPE);
        m->is_cell_new = 1;
        memset(m->page, 0xff, sizeof(m->page)); /* what SPM has filled in is lost: Filling the Temporary Buffer */
        avr_due(m, AVR_PART_EEPROM, at + avr_clocks(m, mode ? ONE_SECONDS : BOTH_SECONDS));
        m->halted += 2;
    } else if (value & EERE && !is_busy) {
        m->data[EEDR] = m->eeprom[avr_eeprom_address(m)];
        m->halted += 4;
        m->attention = 0;
    }
    avr_ask(m);
}

void avr_eeprom_event(avr *m, uint64_t at)
{
    (void)at;
    m->data[EECR] &= (uint8_t)~EEPE;
    m->due[AVR_PART_EEPROM] = AVR_NEVER;
    avr_ask(m);
}

/* SPMCSR's other bits make LPM read what is no flash, within three clocks: DS40002061, Reading the Signature Row, Lock and Fuses. */
static int special_byte(const avr *m, unsigned z)
{
    static const uint8_t signature[3] = {0x1e, 0x95, 0x0f};
    uint8_t control = m->data[SPMCSR];
    if (control & SIGRD) return z & 1 ? (z == 1 ? m->data[OSCCAL] : 0xff) : (z >> 1) < 3 ? signature[z >> 1] : 0xff;
    if (!(control & BLBSET)) return -1;
    return z == 0 ? m->fuses[0] : z == 1 ? m->lock : z == 2 ? m->fuses[2] : z == 3 ? m->fuses[1] : 0xff;
}

uint8_t avr_flash_byte(avr *m, unsigned z, uint64_t at)
{
    if (m->data[SPMCSR] & SPMEN && at <= m->spm_armed && !(m->data[EECR] & EEPE)) {
        int special = special_byte(m, z);
        if (special >= 0) {
            m->data[SPMCSR] &= (uint8_t) ~(SIGRD | BLBSET | SPMEN);
            return (uint8_t)special;
        }
    }
    unsigned at_word = z >> 1 & (AVR_FLASH_WORDS - 1);
    if (m->data[SPMCSR] & RWWSB && at_word < NRWW_WORD) return 0xff;
    return (uint8_t)(m->flash[at_word] >> (z & 1 ? 8 : 0));
}

void avr_spm_store(avr *m, uint8_t value, uint64_t at)
{
    uint8_t *control = &m->data[SPMCSR];
    if (*control & SPMEN && m->due[AVR_PART_SPM] != AVR_NEVER && at > m->spm_armed) { /* a page is under way */
        *control = (uint8_t)((*control & ~SPMIE) | (value & SPMIE));
        avr_ask(m);
        return;
    }
    *control = (uint8_t)((*control & RWWSB) | (value & ~RWWSB));
    m->spm_armed = at + ARMED_CLOCKS;
    avr_due(m, AVR_PART_SPM, value & SPMEN ? m->spm_armed + 1 : AVR_NEVER);
    avr_ask(m);
}

void avr_spm_event(avr *m, uint64_t at)
{
    (void)at;
    m->data[SPMCSR] &= (uint8_t) ~(SPMEN | PGWRT | PGERS | RWWSRE | BLBSET | SIGRD);
    m->due[AVR_PART_SPM] = AVR_NEVER;
    avr_ask(m);
}

/* BLB11 of the lock bits keeps SPM from writing to the boot section, BLB01 from the rest: table Lock Bit Protection Modes. */
static int is_locked(const avr *m, unsigned at_word)
{
    return !(m->lock >> (at_word >= avr_boot_start(m) ? 4 : 2) & 1);
}

static void change_page(avr *m, unsigned at_word, int is_write, uint64_t at)
{
    uint64_t end = at + avr_clocks(m, PAGE_SECONDS);
    if (is_locked(m, at_word)) {
        avr_spm_event(m, at);
        return;
    }
    for (unsigned i = 0; i < PAGE_WORDS; i++) {
        uint16_t word = (uint16_t)(m->page[2 * i] | m->page[2 * i + 1] << 8);
        m->flash[at_word + i] = is_write ? m->flash[at_word + i] & word : 0xffff;
    }
    if (is_write) memset(m->page, 0xff, sizeof(m->page));
    avr_decode(m, at_word, PAGE_WORDS);
    m->is_page_new = 1;
    m->page_byte = (uint16_t)(at_word * 2);
    if (at_word < NRWW_WORD) m->data[SPMCSR] |= RWWSB;
    else m->halted += (uint32_t)(end - at);
    avr_due(m, AVR_PART_SPM, end);
}

void avr_spm(avr *m, unsigned pc, uint64_t at)
{
    uint8_t *control = &m->data[SPMCSR];
    unsigned z = m->data[30] | (unsigned)m->data[31] << 8, at_word = z >> 1 & (AVR_FLASH_WORDS - 1) & ~(PAGE_WORDS - 1u);
    if (pc < avr_boot_start(m) || !(*control & SPMEN) || at > m->spm_armed || m->data[EECR] & EEPE) return;
    m->spm_armed = 0;
    switch (*control & (RWWSRE | BLBSET | PGWRT | PGERS | SIGRD)) {
    case 0:
        if (m->page[z & 0x7e] == 0xff && m->page[(z & 0x7e) + 1] == 0xff) { /* a word can be filled in once */
            m->page[z & 0x7e] = m->data[0];
            m->page[(z & 0x7e) + 1] = m->data[1];
        }
        avr_spm_event(m, at);
        break;
    case PGERS: change_page(m, at_word, 0, at); break;
    case PGWRT: change_page(m, at_word, 1, at); break;
    case RWWSRE:
        *control &= (uint8_t)~RWWSB;
        memset(m->page, 0xff, sizeof(m->page));
        avr_spm_event(m, at);
        break;
    case BLBSET:
        m->lock &= m->data[0] | 0xc0; /* bits can be cleared alone */
        avr_spm_event(m, at);
        break;
    default: break;
    }
}
