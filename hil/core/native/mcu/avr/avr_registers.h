/* Registers of an ATmega328P by their addresses in data space, and their bits: DS40002061, Register Summary. */
#ifndef HIL_AVR_REGISTERS_H
#define HIL_AVR_REGISTERS_H

enum avr_register {
    PINB = 0x23, DDRB, PORTB, PINC, DDRC, PORTC, PIND, DDRD, PORTD,
    TIFR0 = 0x35, TIFR1, TIFR2, PCIFR = 0x3b, EIFR, EIMSK, GPIOR0, EECR, EEDR, EEARL, EEARH, GTCCR,
    TCCR0A = 0x44, TCCR0B, TCNT0, OCR0A, OCR0B, GPIOR1 = 0x4a, GPIOR2, SPCR, SPSR, SPDR, ACSR = 0x50,
    SMCR = 0x53, MCUSR, MCUCR, SPMCSR = 0x57, SPL = 0x5d, SPH, SREG, WDTCSR, CLKPR, PRR = 0x64, OSCCAL = 0x66,
    PCICR = 0x68, EICRA, PCMSK0 = 0x6b, PCMSK1, PCMSK2, TIMSK0, TIMSK1, TIMSK2,
    ADCL = 0x78, ADCH, ADCSRA, ADCSRB, ADMUX, DIDR0 = 0x7e, DIDR1,
    TCCR1A = 0x80, TCCR1B, TCCR1C, TCNT1L = 0x84, TCNT1H, ICR1L, ICR1H, OCR1AL, OCR1AH, OCR1BL, OCR1BH,
    TCCR2A = 0xb0, TCCR2B, TCNT2, OCR2A, OCR2B, ASSR = 0xb6, TWBR = 0xb8, TWSR, TWAR, TWDR, TWCR, TWAMR,
    UCSR0A = 0xc0, UCSR0B, UCSR0C, UBRR0L = 0xc4, UBRR0H, UDR0
};

enum { FLAG_C = 1, FLAG_Z = 2, FLAG_N = 4, FLAG_V = 8, FLAG_S = 16, FLAG_H = 32, FLAG_T = 64, FLAG_I = 128 }; /* SREG */

enum { TOV = 1, OCFA = 2, OCFB = 4, ICF1 = 32 };                                 /* TIFRn, TIMSKn */
enum { ICES1 = 64, ICNC1 = 128 };                                                /* TCCR1B */
enum { PSRSYNC = 1, PSRASY = 2, TSM = 128 };                                     /* GTCCR */
enum { EXCLK = 64, AS2 = 32 };                                                   /* ASSR; below them the five that are busy */
enum { EERE = 1, EEPE = 2, EEMPE = 4, EERIE = 8, EEPM = 0x30 };                  /* EECR */
enum { PUD = 16, IVSEL = 2, IVCE = 1 };                                          /* MCUCR */
enum { SE = 1 };                                                                 /* SMCR */
enum { WDE = 8, WDCE = 16, WDIE = 64, WDIF = 128, WDP3 = 32 };                   /* WDTCSR */
enum { WDRF = 8 };                                                               /* MCUSR */
enum { CLKPCE = 128 };                                                           /* CLKPR */
enum { SPIE = 128, SPE = 64, DORD = 32, MSTR = 16, CPOL = 8, CPHA = 4 };         /* SPCR */
enum { SPIF = 128, WCOL = 64, SPI2X = 1 };                                       /* SPSR */
enum { ACD = 128, ACBG = 64, ACO = 32, ACI = 16, ACIE = 8, ACIC = 4, ACIS = 3 }; /* ACSR */
enum { ADEN = 128, ADSC = 64, ADATE = 32, ADIF = 16, ADIE = 8, ADPS = 7 };       /* ADCSRA */
enum { ACME = 64, ADTS = 7 };                                                    /* ADCSRB */
enum { ADLAR = 32 };                                                             /* ADMUX */
enum { TWINT = 128, TWEA = 64, TWSTA = 32, TWSTO = 16, TWWC = 8, TWEN = 4, TWIE = 1 };          /* TWCR */
enum { RXC = 128, TXC = 64, UDRE = 32, FE = 16, DOR = 8, UPE = 4, U2X = 2, MPCM = 1 };          /* UCSR0A */
enum { RXCIE = 128, TXCIE = 64, UDRIE = 32, RXEN = 16, TXEN = 8, UCSZ2 = 4, RXB8 = 2, TXB8 = 1 }; /* UCSR0B */
enum { UMSEL = 0xc0, UPM = 0x30, USBS = 8, UCSZ = 6, UDORD = 4, UCPHA = 2, UCPOL = 1 }; /* UCSR0C */
enum { SPMIE = 128, RWWSB = 64, SIGRD = 32, RWWSRE = 16, BLBSET = 8, PGWRT = 4, PGERS = 2, SPMEN = 1 }; /* SPMCSR */
enum { PRTWI = 128, PRTIM2 = 64, PRTIM0 = 32, PRTIM1 = 8, PRSPI = 4, PRUSART = 2, PRADC = 1 }; /* PRR */

enum avr_vector { /* by priority, the first the highest: DS40002061, Interrupts */
    VECTOR_RESET, VECTOR_INT0, VECTOR_INT1, VECTOR_PCINT0, VECTOR_PCINT1, VECTOR_PCINT2, VECTOR_WDT,
    VECTOR_T2_COMPA, VECTOR_T2_COMPB, VECTOR_T2_OVF, VECTOR_T1_CAPT, VECTOR_T1_COMPA, VECTOR_T1_COMPB, VECTOR_T1_OVF,
    VECTOR_T0_COMPA, VECTOR_T0_COMPB, VECTOR_T0_OVF, VECTOR_SPI, VECTOR_RX, VECTOR_UDRE, VECTOR_TX, VECTOR_ADC,
    VECTOR_EE_READY, VECTOR_COMPARATOR, VECTOR_TWI, VECTOR_SPM_READY, VECTORS
};

#endif
