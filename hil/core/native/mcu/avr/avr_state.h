/* What an ATmega328P holds: data alone, no pointers. A copy is a snapshot.

   Times within it are clocks of its CPU, which the prescaler of CLKPR may make longer than the crystal's cycles that the
   world counts; avr_time.h turns one into the other. Names of registers and bits: avr_registers.h. */
#ifndef HIL_AVR_STATE_H
#define HIL_AVR_STATE_H

#include <stdint.h>

#include "avr_debug_state.h"

enum {
    AVR_FLASH_BYTES = 32768,
    AVR_FLASH_WORDS = AVR_FLASH_BYTES / 2,
    AVR_WRAPS = 3, /* words beyond: an instruction that is skipped may end there */
    AVR_DATA_BYTES = 0x900, /* registers, I/O, SRAM: DS40002061, AVR Memories */
    AVR_EEPROM_BYTES = 1024,
    AVR_PAGE_BYTES = 128,
    AVR_HEARD = 32,  /* characters that may wait at RX */
    AVR_EDGES = 32,  /* changes of pins that are on their way through the synchronisers */
    AVR_LEVELS = 64, /* changes of the receiver's pin that are remembered: those of some frames */
    AVR_ANALOGUE = 8
};

/* What does something by itself, in the order in which it does so within one cycle. */
enum avr_part {
    AVR_PART_PINS,
    AVR_PART_TIMER0,
    AVR_PART_TIMER1,
    AVR_PART_TIMER2,
    AVR_PART_SEND,
    AVR_PART_RECEIVE,
    AVR_PART_LINE, /* levels of frames at D0 and D1, where somebody looks at them */
    AVR_PART_SPI,
    AVR_PART_TWI,
    AVR_PART_ADC,
    AVR_PART_EEPROM,
    AVR_PART_SPM,
    AVR_PART_WATCHDOG,
    AVR_PART_COMPARATOR, /* looks at a voltage that may change at any time */
    AVR_PARTS
};

#define AVR_NEVER UINT64_MAX
#define AVR_CAPTURED 0x8000u

/* What drives a pin from the chip: it does, to 0 or 1; nothing; its pull-up alone. */
enum avr_drive { AVR_LOW, AVR_HIGH, AVR_OPEN, AVR_PULLED_UP };

/* Causes of a reset, as bits of MCUSR. */
enum avr_cause { AVR_POWER_ON = 1, AVR_EXTERNAL = 2, AVR_BROWN_OUT = 4, AVR_WATCHDOG = 8 };

/* What a user is told, once each from a reset to the next but where that says it. */
enum avr_note {
    AVR_NOTE_ILLEGAL = 1,    /* an opcode that is none; value: its byte address */
    AVR_NOTE_STACK,          /* the stack pointer is below the heap's start or SRAM's; value: the pointer */
    AVR_NOTE_ASLEEP,         /* asleep with nothing that could wake it */
    AVR_NOTE_OVERRUN,        /* a received byte was lost to a full receiver */
    AVR_NOTE_WATCHDOG_LOOP,  /* the watchdog has reset it, and again, before anything turned it off */
};

typedef struct avr_character { /* of a serial line */
    uint64_t cycle;          /* the first of its start bit */
    uint32_t bit_cycles_256; /* of a bit, in 1/256 cycles: senders have clocks of their own */
    uint16_t bits;           /* what follows the start bit, first bit lowest, with parity, without stop bits */
    uint8_t length;          /* how many these are: 5 to 10 */
    uint8_t is_broken;       /* its stop bit is low */
    uint8_t framing;         /* of one that the chip sends: avr_framing */
} avr_character;

/* Framing of characters: data bits, 5 to 9, and these. */
enum { AVR_EVEN = 0x20, AVR_ODD = 0x30, AVR_TWO_STOPS = 0x40, AVR_DATA_BITS_MASK = 15 };

typedef uint32_t avr_op; /* an instruction as it is run: avr_decode.h */

/* A port: what drives its pins, in its bits. What PIN shows is one clock behind. */
typedef struct avr_port {
    uint8_t as_output, as_input; /* whatever DDR says, while a part of the chip has the pin */
    uint8_t own, own_level;      /* pins whose level a part gives, in place of PORT */
    uint8_t driven, value;       /* by the chip: the result */
    uint8_t outside, forced;     /* by the world: which, and how */
    uint8_t level, before;       /* now, and before the last change */
    uint8_t seen;                /* behind the edge detectors; at once where nothing waits for a bit */
    uint64_t changed;            /* when */
} avr_port;

typedef struct avr_edge {
    uint64_t due; /* when it has come through */
    uint8_t port, level;
    uint8_t cared; /* bits that something waited for then */
} avr_edge;

typedef struct avr_timer {
    uint64_t told;          /* its count is that after this clock */
    uint64_t capture_due;   /* the noise canceller lets an edge through; AVR_NEVER: none is there */
    uint16_t count;
    uint16_t compare[2];    /* at work; what is read and written is buffer */
    uint16_t buffer[2];
    uint16_t capture;       /* ICR1 */
    uint8_t is_down;        /* counts down */
    uint8_t is_blocked;     /* written to: nothing matches at the next tick */
    uint8_t mode;           /* WGM bits */
    uint8_t shift;          /* of its prescaler: 2^shift clocks a tick */
    uint8_t is_ticking;     /* by the prescaler */
    uint8_t latch[2];       /* OCA, OCB */
} avr_timer;

/* Timer 2 by a crystal of its own: `edges` of it have been by `zero`, a cycle of the world's. */
typedef struct avr_crystal {
    uint32_t hz;            /* at TOSC1 and TOSC2; 0: none is there */
    uint8_t is_clock;       /* a clock that comes to TOSC1, for EXCLK; else a crystal */
    uint64_t zero, edges;
    uint64_t prescaler;     /* edge at which its prescaler was 0 */
    uint8_t waiting[5];     /* what was written and is not at work yet, by bits of ASSR from TCR2BUB on */
    uint64_t due[5];        /* edge by which it is */
} avr_crystal;

typedef struct avr_usart {
    /* transmitter */
    avr_character frame;    /* under way at TX */
    uint64_t bit_from;      /* when the bits that are over, were */
    uint16_t waiting;       /* UDR as written, nine bits */
    uint8_t is_sending, is_waiting;
    uint8_t bits_over, frame_bits; /* of the frame, with start and stop bits */
    uint16_t levels;        /* of the frame, the start bit lowest; as a master of SPI of the bit */
    uint8_t halves;         /* of a byte's bits that are over, as a master of SPI */
    uint8_t is_clock_high;  /* at XCK */
    /* receiver */
    uint16_t buffer[2];     /* nine bits each */
    uint8_t errors[2];      /* FE, DOR, UPE as in UCSR0A */
    uint8_t buffered;       /* how many of them are full */
    uint8_t is_kept, kept_errors; /* a third waits in the shift register */
    uint16_t kept;
    uint8_t is_lost;        /* one was: DOR of the next */
    uint8_t is_receiving;
    uint8_t bits_in;        /* of the frame under way, with its start bit */
    uint16_t shifted;
    uint64_t bit_in_from;   /* when the first of the bits to come began */
    uint64_t edge, looked;  /* the world's cycles: of the start bit; no start bit begins before it */
    /* the line to it, in the world's cycles */
    avr_character heard[AVR_HEARD];
    uint8_t heard_first, heard_count;
    uint8_t wire, wire_last, wire_count; /* level of the pin; the ring of its changes */
    uint64_t wire_at[AVR_LEVELS];
} avr_usart;

typedef struct avr_adc {
    uint64_t zero;          /* of its prescaler */
    uint64_t begun;         /* clock edge at which the conversion under way began */
    uint16_t result;        /* the last */
    uint8_t is_busy, is_sampled, is_first, is_locked;
    uint8_t mux;            /* ADMUX of the conversion under way */
    uint8_t sampled_2, done_2; /* when it samples and is done, in half clocks of the ADC */
    uint8_t is_comparator_used;
    uint16_t sample;
} avr_adc;

typedef struct avr_spi {
    uint8_t shifting, received;
    uint8_t halves;              /* of its bits that are over */
    uint8_t out, is_clock_high;  /* what it drives */
    uint8_t is_high_in;          /* taken at the last edge */
    uint8_t is_selected, is_seen; /* is_seen: flags that SPSR has shown */
} avr_spi;

typedef struct avr_twi {
    uint8_t master, slave;       /* states: avr_twi.c */
    uint8_t pulls_data, pulls_clock;
    uint8_t is_reading, is_address, is_repeated; /* of a master; is_repeated: the bus is its own */
    uint8_t is_lost;             /* to another master, in the byte under way */
    uint8_t is_busy;             /* the bus: from a START to a STOP */
    uint8_t bits, slave_bits;    /* of a byte, that are over; slave_bits: of any on the bus */
    uint8_t is_mine, is_acknowledging;
    uint16_t shifted, slave_shifted;
} avr_twi;

typedef struct avr {
    uint64_t cycle;                  /* the world's: run up to it */
    uint64_t t;                      /* the CPU's: where its next instruction begins */
    uint64_t attention;              /* up to it instructions run without a look at anything else; 0: look */
    uint64_t reached;                /* clock of the last thing that was done */
    uint64_t due[AVR_PARTS];         /* when a part does something; AVR_NEVER */
    uint64_t clock_from, clock_base; /* the CPU's clock and the world's when CLKPR was last set */
    uint8_t clock_shift;
    double hz, vcc_volts, aref_volts, volts[AVR_ANALOGUE];

    uint16_t pc, sp;
    uint16_t stack_floor, stack_lowest; /* below the first a user is told; where a push has been since the reset */
    uint8_t sreg;
    uint32_t halted;    /* clocks that the instruction under way halts the CPU for, after its own */
    uint8_t is_held;    /* no interrupt before the next instruction */
    uint8_t planned;    /* clocks of what begins at t, if that is settled; 0: it is not */
    uint8_t entered;    /* vector that is entered at t, if so planned; 0: none */
    uint8_t asleep;     /* 0: awake, else SM + 1 */
    uint8_t is_running, is_stopped;
    uint8_t is_at_break, is_passing; /* stands before one; carries out the instruction at it */
    uint8_t is_frozen;  /* the I/O clock stands still, since */
    uint8_t is_crystal_frozen; /* that of timer 2, too */
    uint64_t frozen;
    uint64_t frozen_due[AVR_PARTS];
    uint64_t gated[AVR_PARTS], gated_due[AVR_PARTS]; /* parts that PRR has stopped: since when */
    uint32_t asking;    /* vectors whose flag is set and enabled, a bit each */
    uint32_t waking;    /* those that end the sleep it is in */

    uint32_t watched, changed_pins; /* pins the world hears of (bit 20: D1 not while it sends); whose drive may be another */
    uint8_t told[20];               /* what the world heard last of each */
    uint8_t is_frame_new, is_page_new, is_cell_new, reset_cause; /* what the world is still to hear of */
    uint8_t is_mean_told, is_mean_new; /* whether it hears of means of pins; one may be another */
    uint16_t page_byte;
    uint8_t noted, notes;           /* a bit for each: since the reset; to be heard of */
    uint16_t note_values[6];

    avr_port port[3];               /* B, C, D */
    avr_edge edges[AVR_EDGES];
    uint8_t edge_first, edge_count;
    uint64_t prescaler[2];          /* when that of timers 0 and 1, and that of 2, was 0 */
    uint8_t prescaler_held;         /* a bit each */
    avr_timer timer[3];
    avr_crystal crystal;
    uint8_t temp;                   /* of 16-bit accesses */
    uint16_t timer_flags;           /* that have risen since the ADC looked: TOV, OCFA, OCFB of timer n from bit 4 n on, and AVR_CAPTURED */
    avr_usart usart;
    avr_adc adc;
    avr_spi spi;
    avr_twi twi;
    uint64_t eeprom_armed, eeprom_from;   /* EEMPE works up to it; when a write began */
    uint64_t watchdog_from, watchdog_armed, clkpr_armed, ivsel_armed, spm_armed;
    uint8_t watchdog_loops;
    uint8_t data[AVR_DATA_BYTES];
    uint8_t eeprom[AVR_EEPROM_BYTES];
    uint8_t page[AVR_PAGE_BYTES];
    uint8_t breaks[AVR_FLASH_WORDS / 8]; /* a bit for each word */
    uint8_t fuses[3], lock;
    uint16_t flash[AVR_FLASH_WORDS];
    avr_op ops[AVR_FLASH_WORDS + AVR_WRAPS];
    avr_debug debug;
} avr;

#endif
