/* Bootloader for a test, of the commands of STK500 that an upload needs. At 115200 baud; 0.5 s of silence starts the sketch.

   Built by the test that uses it: avr-gcc -mmcu=atmega328p -Os -nostartfiles -Wl,--section-start=.text=0x7E00 */
#include <avr/boot.h>
#include <avr/io.h>
#include <avr/pgmspace.h>
#include <avr/wdt.h>

static uint8_t *const page = (uint8_t *)RAMSTART; /* no start-up code clears it */

static uint8_t get(void) {
    while (!(UCSR0A & _BV(RXC0)))
        ;
    wdt_reset();
    return UDR0;
}

static void put(uint8_t byte) {
    while (!(UCSR0A & _BV(UDRE0)))
        ;
    UDR0 = byte;
}

static void end(void) {
    if (get() != ' ')
        for (;;)
            ;
    put(0x14);
}

int main(void) __attribute__((OS_main, section(".init9")));
int main(void) {
    __asm__ volatile("clr __zero_reg__");
    uint8_t cause = MCUSR;
    uint16_t at = 0;
    MCUSR = 0;
    if (!(cause & _BV(EXTRF))) {
        wdt_disable();
        __asm__ volatile("jmp 0");
    }
    wdt_enable(WDTO_500MS);
    UCSR0A = _BV(U2X0);
    UBRR0 = 16;
    UCSR0B = _BV(RXEN0) | _BV(TXEN0);
    for (;;) {
        uint8_t command = get();
        if (command == 'U') {
            at = get();
            at = (at | get() << 8) * 2;
            end();
        } else if (command == 'd' || command == 't') {
            get();
            uint8_t length = get();
            get();
            if (command == 't') {
                end();
                while (length--)
                    put(pgm_read_byte(at++));
            } else {
                for (uint8_t i = 0; i < SPM_PAGESIZE; i++)
                    page[i] = 0xFF;
                for (uint8_t i = 0; i < length; i++)
                    page[i] = get();
                end();
                boot_page_erase(at);
                boot_spm_busy_wait();
                for (uint8_t i = 0; i < SPM_PAGESIZE; i += 2)
                    boot_page_fill(at + i, page[i] | page[i + 1] << 8);
                boot_page_write(at);
                boot_spm_busy_wait();
                boot_rww_enable();
            }
        } else if (command == 'u') {
            end();
            put(0x1E);
            put(0x95);
            put(0x0F);
        } else {
            end();
            if (command == 'Q')
                wdt_enable(WDTO_15MS);
        }
        put(0x10);
    }
}
