/* Flash and EEPROM as a program writes them: DS40002061, Self-Programming the Flash; EEPROM Data Memory. */
#include "../mcu/avr/avr_decode.h"
#include "../mcu/avr/avr_execute.h"
#include "avr_lab.h"

enum { BOOT = 0x7e00, PAGE = 0x1000, NRWW_PAGE = 0x7000, ERASE = PGERS | SPMEN, WRITE = PGWRT | SPMEN, FILL = SPMEN };
enum { OP_LPM_16 = 0x9104, OP_SPM_ = 0x95e8 };

static avr_lab lab;

static void set_z(unsigned z)
{
    lab.chip.data[30] = (uint8_t)z;
    lab.chip.data[31] = (uint8_t)(z >> 8);
}

/* Puts an instruction at a byte address and carries it out. */
static void carry_out(unsigned op, unsigned at)
{
    uint8_t bytes[2] = {(uint8_t)op, (uint8_t)(op >> 8)};
    avr_load_flash(&lab.chip, at, bytes, 2);
    lab.chip.pc = (uint16_t)(at / 2);
    lab.chip.planned = 0;
    lab_run(&lab, op == OP_LPM_16 ? 3 : 1);
}

/* SPMCSR, then SPM `late` clocks after it. */
static void spm(unsigned control, unsigned z, unsigned word, unsigned late)
{
    set_z(z);
    lab.chip.data[0] = (uint8_t)word;
    lab.chip.data[1] = (uint8_t)(word >> 8);
    put(&lab, SPMCSR, control);
    lab_run(&lab, late);
    carry_out(OP_SPM_, BOOT);
}

static unsigned lpm(unsigned control, unsigned z)
{
    set_z(z);
    if (control) put(&lab, SPMCSR, control);
    carry_out(OP_LPM_16, BOOT);
    return lab.chip.data[16];
}

static void wait_until_written(void) { until_bits(&lab, SPMCSR, SPMEN, 0, 100000); }

static void a_page_is_erased_filled_and_written(void)
{
    lab_open(&lab);
    spm(ERASE, PAGE, 0, 0);
    CHECK_INT(get(&lab, SPMCSR), ERASE | RWWSB);
    CHECK_INT(lpm(0, 0x100), 0xff); /* the section is busy */
    CHECK_NEAR((double)until_bits(&lab, SPMCSR, SPMEN, 0, 100000), 16000 * 4.5, 10);
    for (unsigned n = 0; n < 128; n += 2) {
        spm(FILL, n, 0xa000 + n, 0);
        CHECK_INT(get(&lab, SPMCSR) & SPMEN, 0);
    }
    spm(WRITE, PAGE, 0, 0);
    wait_until_written();
    CHECK_INT(get(&lab, SPMCSR), RWWSB);
    spm(RWWSRE | SPMEN, 0, 0, 0);
    CHECK_INT(get(&lab, SPMCSR), 0);
    for (unsigned n = 0; n < 128; n += 2) CHECK_INT(lab.chip.flash[(PAGE + n) / 2], 0xa000 + n);
    CHECK_INT(lpm(0, PAGE + 3), 0xa0);
    CHECK_INT(lab.pages, 2);
}

static void it_has_four_clocks(void)
{
    for (unsigned late = 3; late < 6; late++) {
        lab_open(&lab);
        spm(ERASE, PAGE, 0, late);
        CHECK_INT(lab.chip.flash[PAGE / 2], late < 4 ? 0xffff : 0);
        if (late >= 4) CHECK_INT(get(&lab, SPMCSR), 0);
    }
}

static void it_acts_from_the_boot_section_alone(void)
{
    lab_open(&lab);
    set_z(PAGE);
    put(&lab, SPMCSR, ERASE);
    carry_out(OP_SPM_, BOOT - 2);
    lab_run(&lab, 100000);
    CHECK_INT(lab.chip.flash[PAGE / 2], 0);
    avr_fuses(&lab.chip, 0xff, 0xd9, 0xfd, 0x3f); /* 2048 words */
    set_z(PAGE);
    put(&lab, SPMCSR, ERASE);
    carry_out(OP_SPM_, 0x7000);
    CHECK_INT(lab.chip.flash[PAGE / 2], 0xffff);
}

static void the_cpu_halts_while_its_own_section_is_written(void)
{
    lab_open(&lab);
    spm(ERASE, NRWW_PAGE, 0, 0);
    lab_run(&lab, 70000);
    CHECK_INT(lab.chip.pc, BOOT / 2 + 1);
    CHECK_INT(get(&lab, SPMCSR) & RWWSB, 0);
    lab_run(&lab, 5000);
    CHECK(lab.chip.pc != BOOT / 2 + 1);
}

static void a_word_is_filled_in_once(void)
{
    lab_open(&lab);
    spm(ERASE, PAGE, 0, 0), wait_until_written();
    spm(FILL, 4, 0x1234, 0), spm(FILL, 4, 0x5678, 0);
    spm(WRITE, PAGE, 0, 0), wait_until_written();
    CHECK_INT(lab.chip.flash[PAGE / 2 + 2], 0x1234);
    spm(ERASE, PAGE, 0, 0), wait_until_written();
    spm(FILL, 4, 0x1234, 0);
    put(&lab, EECR, EEMPE), put(&lab, EECR, EEPE), until_bits(&lab, EECR, EEPE, 0, 100000); /* what was filled in is lost */
    spm(WRITE, PAGE, 0, 0), wait_until_written();
    CHECK_INT(lab.chip.flash[PAGE / 2 + 2], 0xffff);
}

static void its_interrupt_asks_while_it_is_ready(void)
{
    lab_open(&lab);
    put(&lab, SPMCSR, SPMIE);
    CHECK_INT(entered(&lab), VECTOR_SPM_READY);
    spm(ERASE | SPMIE, PAGE, 0, 0);
    CHECK_INT(entered(&lab), 0);
    wait_until_written();
    CHECK_INT(entered(&lab), VECTOR_SPM_READY);
}

static void signature_fuses_and_lock_bits_are_read(void)
{
    lab_open(&lab);
    avr_fuses(&lab.chip, 0xff, 0xde, 0xfd, 0x3f);
    for (unsigned n = 0; n < 3; n++) CHECK_INT(lpm(SIGRD | SPMEN, 2 * n), n == 0 ? 0x1e : n == 1 ? 0x95 : 0x0f);
    static const uint8_t wanted[4] = {0xff, 0x3f, 0xfd, 0xde}; /* low, lock, extended, high */
    for (unsigned n = 0; n < 4; n++) CHECK_INT(lpm(BLBSET | SPMEN, n), wanted[n]);
    CHECK_INT(get(&lab, SPMCSR) & SPMEN, 0);
    set_z(0);
    put(&lab, SPMCSR, SIGRD | SPMEN), lab_run(&lab, 5);
    CHECK_INT(lpm(0, 0), lab.chip.flash[0] & 0xff); /* too late */
}

static void lock_bits_keep_sections(void)
{
    lab_open(&lab);
    spm(BLBSET | SPMEN, 1, 0xffef, 0); /* BLB11: the boot section */
    CHECK_INT(lpm(BLBSET | SPMEN, 1), 0x2f);
    spm(ERASE, BOOT + 0x80, 0, 0), wait_until_written();
    CHECK_INT(lab.chip.flash[(BOOT + 0x80) / 2], 0);
    spm(ERASE, PAGE, 0, 0), wait_until_written();
    CHECK_INT(lab.chip.flash[PAGE / 2], 0xffff);
    spm(BLBSET | SPMEN, 1, 0xff, 0); /* they are never set again */
    CHECK_INT(lpm(BLBSET | SPMEN, 1), 0x2f);
    spm(BLBSET | SPMEN, 1, 0xfb, 0); /* BLB01: the rest */
    spm(ERASE, 2 * PAGE, 0, 0), wait_until_written();
    CHECK_INT(lab.chip.flash[PAGE], 0);
}

/* ---- EEPROM ---- */

static uint64_t eeprom(unsigned address, unsigned value, unsigned mode)
{
    put(&lab, EEARH, address >> 8), put(&lab, EEARL, address), put(&lab, EEDR, value);
    put(&lab, EECR, mode | EEMPE), put(&lab, EECR, mode | EEPE);
    return until_bits(&lab, EECR, EEPE, 0, 100000);
}

static void each_mode_of_the_eeprom(void)
{
    lab_open(&lab);
    CHECK_NEAR((double)eeprom(0x3ff, 0x5a, 0), 16000 * 3.4, 3);
    CHECK_INT(lab.chip.eeprom[0x3ff], 0x5a);
    CHECK_NEAR((double)eeprom(0x3ff, 0x0f, 0x20), 16000 * 1.8, 3); /* write: bits are cleared */
    CHECK_INT(lab.chip.eeprom[0x3ff], 0x0a);
    CHECK_NEAR((double)eeprom(0x3ff, 0x00, 0x10), 16000 * 1.8, 3); /* erase */
    CHECK_INT(lab.chip.eeprom[0x3ff], 0xff);
    CHECK_INT(lab.cells, 3);
}

static void eempe_has_four_clocks(void)
{
    for (unsigned late = 4; late < 6; late++) {
        lab_open(&lab);
        put(&lab, EEDR, 0x12), put(&lab, EECR, EEMPE);
        lab_run(&lab, 3);
        CHECK_INT(get(&lab, EECR), EEMPE);
        lab_run(&lab, late - 3);
        put(&lab, EECR, EEPE);
        CHECK_INT(lab.chip.eeprom[0], late == 4 ? 0x12 : 0xff);
        CHECK_INT(get(&lab, EECR), late == 4 ? EEPE : 0);
    }
    lab_open(&lab);
    put(&lab, EECR, EEMPE | EEPE); /* together they write nothing */
    CHECK_INT(get(&lab, EECR) & EEPE, 0);
}

static void nothing_changes_while_a_cell_is_written(void)
{
    lab_open(&lab);
    put(&lab, EEARL, 9), put(&lab, EEDR, 0x12), put(&lab, EECR, EEMPE), put(&lab, EECR, EEPE);
    lab_run(&lab, 10);
    put(&lab, EEARL, 77), put(&lab, EEARH, 1), put(&lab, EECR, 0x10 | EERE);
    CHECK_INT(get(&lab, EEARL), 9);
    CHECK_INT(get(&lab, EEARH), 0);
    CHECK_INT(get(&lab, EECR), EEPE);
    CHECK_INT(lab.chip.halted, 0);
}

static void flash_and_eeprom_wait_for_each_other(void)
{
    lab_open(&lab);
    spm(ERASE, PAGE, 0, 0);
    eeprom(0, 0x12, 0);
    CHECK_INT(lab.chip.eeprom[0], 0xff);
    wait_until_written();
    put(&lab, EECR, EEMPE), put(&lab, EECR, EEPE);
    spm(ERASE, 2 * PAGE, 0, 0);
    CHECK_INT(lab.chip.flash[PAGE], 0);
    CHECK(lpm(SIGRD | SPMEN, 2) != 0x95);
}

static void its_interrupt_is_a_level(void)
{
    lab_open(&lab);
    put(&lab, EECR, EERIE);
    CHECK_INT(entered(&lab), VECTOR_EE_READY);
    CHECK_INT(entered(&lab), VECTOR_EE_READY);
    put(&lab, EECR, EERIE | EEMPE), put(&lab, EECR, EERIE | EEPE);
    lab_run(&lab, 4);
    CHECK_INT(entered(&lab), 0);
}

void avr_self_program_tests(void)
{
    RUN(a_page_is_erased_filled_and_written);
    RUN(it_has_four_clocks);
    RUN(it_acts_from_the_boot_section_alone);
    RUN(the_cpu_halts_while_its_own_section_is_written);
    RUN(a_word_is_filled_in_once);
    RUN(its_interrupt_asks_while_it_is_ready);
    RUN(signature_fuses_and_lock_bits_are_read);
    RUN(lock_bits_keep_sections);
    RUN(each_mode_of_the_eeprom);
    RUN(eempe_has_four_clocks);
    RUN(nothing_changes_while_a_cell_is_written);
    RUN(flash_and_eeprom_wait_for_each_other);
    RUN(its_interrupt_is_a_level);
}
