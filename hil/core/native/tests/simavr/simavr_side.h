/* Simavr behind names of its own: its functions have the names of ours. A library that is loaded beside them. */
#ifndef HIL_SIMAVR_SIDE_H
#define HIL_SIMAVR_SIDE_H

#include <stdint.h>

/* What it gets wrong and this sets right, so that all else can be compared; each is counted. */
enum simavr_mended {
    MENDED_ENTRY,       /* an interrupt takes no time */
    MENDED_HELD,        /* two instructions run after I was set, not one */
    MENDED_RETURN,      /* none runs after RETI where I was set before */
    MENDED_SKIP,        /* some words that are skipped are taken for two */
    MENDED_ASLEEP,      /* SLEEP sleeps without SE */
    MENDED_WRITE,       /* a write to a timer happens where its instruction begins */
    MENDED_READ,        /* a read of a timer likewise */
    MENDED_KEPT,        /* a write to TIFRn clears flags that are written as 0 */
    MENDED_STALE,       /* a request that was cleared holds up others */
    MENDED_OVERFLOW,    /* CTC sets TOV */
    MENDED_WRAP,        /* PC leaves the flash */
    MENDED
};

/* What the next instruction is: one before ADIW or SBIW that may skip it, OUT, SBI or CBI of TIFRn, STS or LDS of a timer. */
enum { SIMAVR_PLAIN, SIMAVR_SLEEP, SIMAVR_RETI, SIMAVR_SKIPS, SIMAVR_CLEARS, SIMAVR_WRITES, SIMAVR_READS, SIMAVR_KINDS };

typedef struct simavr_side {
    uint8_t *flash, *data; /* SREG apart */
    uint64_t mended[MENDED];
} simavr_side;

simavr_side *simavr_open(void);
void simavr_reset(void); /* I/O as after a reset; time goes on */
void simavr_begin(uint16_t pc, uint16_t sp, uint8_t sreg);
void simavr_step(int kind); /* one instruction */
void simavr_forget_overflows(unsigned timers); /* those in CTC, a bit each */
int simavr_enter(void); /* an interrupt, if one is to be served before the next instruction; whether one was */
uint16_t simavr_pc(void);
void simavr_set_sp(uint16_t sp);
uint16_t simavr_sp(void);
uint8_t simavr_sreg(void);
uint64_t simavr_cycle(void);

#endif
