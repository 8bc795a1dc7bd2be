#include "as5047d.h"

#include <math.h>

#include "../core.h"

/* Registers (data sheet, Register Description). encoder.h has those that the Mechaduino reads, too. */
enum { NOP = 0x0000, PROG = 0x0003, ZPOSM = 0x0016, SETTINGS2 = 0x0019, MAG = 0x3FFD, ANGLEUNC = 0x3FFE };
enum { AT_PROG, AT_ZPOSM, AT_ZPOSL, AT_SETTINGS1 }; /* of settings */
enum { FACTORY = 1, DIR = 4 };                      /* bits of SETTINGS1 */
enum { ZPOSL_BITS = 0x3F };

/* Frames (SPI Interface): even parity in front; then, of a command, 1 to read. */
enum { FRAME_BITS = 16, READS = 0x4000, VALUE = 0x3FFF, STORED = 0xFF };

/* Of ERRFL. */
enum { FRAMING = 1, INVALID = 2, PARITY = 4 };

/* Of DIAAGC: no magnet is a field that is too weak (MAGL), with the gain at its end. */
enum { WEAK = 0x0800, GAIN = 0x00FF };
enum { MAGNITUDE = 0x1200 }; /* chosen: the data sheet gives no figure for a magnet in its place */

const as5047d *as5047d_view(const hil_axis *a)
{
    static const as5047d none = {0};
    return a->law == &as5047d_law ? a->own : &none;
}

/* ---- the magnet ---- */

static int count(hil_axis *a, int64_t t_ns)
{
    const as5047d *e = a->own;
    if (!e->has_magnet) return 0;
    hil_axis *on = a + e->shaft;
    if (on->is_turned) law_plant(on, t_ns);
    double sense = e->settings[AT_SETTINGS1] & DIR ? -e->sense : e->sense;
    int zero = e->settings[AT_ZPOSM] << 6 | (e->settings[AT_ZPOSL] & ZPOSL_BITS);
    return shaft_faulty_raw(a, shaft_count((shaft_rev(on, t_ns) - e->zero_rev) * sense) - zero, t_ns) & VALUE;
}

/* ---- registers ---- */

/* Which of settings a register is; -1: it cannot be written. */
static int setting_of(int address)
{
    if (address == PROG) return AT_PROG;
    return address >= ZPOSM && address <= SETTINGS2 ? AT_ZPOSM + address - ZPOSM : -1;
}

/* Reads a register; -1: there is none. */
static int read_register(hil_axis *a, int address, int64_t at_ns)
{
    as5047d *e = a->own;
    int errors = a->encoder.errfl, setting = setting_of(address);
    switch (address) {
    case NOP: return 0;
    case SPI_ERRFL: a->encoder.errfl = 0; return errors;
    case SPI_DIAAGC: return e->has_magnet ? a->encoder.diaagc : a->encoder.diaagc | WEAK | GAIN;
    case MAG: return e->has_magnet ? MAGNITUDE : 0;
    case ANGLEUNC: case SPI_ANGLE: return law_raw(a, at_ns);
    default: return setting < 0 ? -1 : e->settings[setting];
    }
}

/* What goes out with the next frame. While ERRFL holds anything each answer says so, that with ERRFL too. */
static void answer(hil_axis *a, int value, int had_errors)
{
    as5047d *e = a->own;
    value = (value & VALUE) | (had_errors || a->encoder.errfl ? SPI_EF : 0);
    e->answer = (uint32_t)(value | __builtin_parity((unsigned)value) << 15);
}

static void fail(hil_axis *a, int error)
{
    as5047d *e = a->own;
    a->encoder.errfl |= error;
    e->writes = -1;
    answer(a, 0, 1);
}

static void command(hil_axis *a, int frame, int64_t at_ns)
{
    as5047d *e = a->own;
    int had_errors = a->encoder.errfl != 0, address = frame & VALUE;
    int is_reading = frame & READS || address == NOP;
    int value = is_reading || setting_of(address) >= 0 ? read_register(a, address, at_ns) : -1;
    a->encoder.previous_command = frame;
    if (value < 0) {
        fail(a, INVALID);
        return;
    }
    if (!is_reading) e->writes = setting_of(address);
    answer(a, value, had_errors);
}

/* Commands are carried out when CSn rises. */
static void end_frame(hil_axis *a, int64_t at_ns)
{
    as5047d *e = a->own;
    int frame = (int)e->heard;
    if (!e->clocks) return;
    e->frames++;
    if (e->clocks != FRAME_BITS) fail(a, FRAMING);
    else if (__builtin_parity((unsigned)frame)) fail(a, PARITY);
    else if (e->writes < 0) command(a, frame, at_ns);
    else {
        e->settings[e->writes] = frame & STORED;
        answer(a, frame & STORED, 0);
        e->writes = -1;
    }
}

/* ---- pins ---- */

/* Mode 1: a bit goes out when CLK rises, and is taken when it falls. */
static void take_clock(hil_core *c, hil_axis *a, int level, int64_t at_ns)
{
    as5047d *e = a->own;
    if (e->pins[HIL_SPI_IN_CSN]) return;
    if (level) {
        int bit = e->clocks < FRAME_BITS ? e->answer >> (FRAME_BITS - 1 - e->clocks) & 1 : 0;
        outputs_set(c, &e->out, HIL_SPI_OUT_MISO, bit || a->fault.is_line_open, at_ns);
        return;
    }
    e->heard = (e->heard << 1 | (uint32_t)e->pins[HIL_SPI_IN_MOSI]) & 0xFFFF;
    if (e->clocks <= FRAME_BITS) e->clocks++; /* one too many says enough */
}

static void take_select(hil_core *c, hil_axis *a, int is_selected, int64_t at_ns)
{
    as5047d *e = a->own;
    if (!is_selected) end_frame(a, at_ns);
    e->clocks = 0;
    e->heard = 0;
    outputs_set(c, &e->out, HIL_SPI_OUT_MISO, is_selected ? 0 : OUTPUT_OPEN, at_ns);
}

static void set_pin(hil_core *c, hil_axis *a, int pin, int level, int64_t at_ns)
{
    as5047d *e = a->own;
    if (e->pins[pin] == level) return;
    e->pins[pin] = level;
    if (pin == HIL_SPI_IN_CLK) take_clock(c, a, level, at_ns);
    else if (pin == HIL_SPI_IN_CSN) take_select(c, a, !level, at_ns);
}

/* ---- its life ---- */

void as5047d_place(hil_axis *a, int shaft, double sense, double zero_rev, int64_t now_ns)
{
    as5047d *e = a->own;
    e->has_magnet = 1;
    e->shaft = shaft;
    e->sense = sense;
    e->zero_rev = zero_rev;
    command(a, a->encoder.previous_command, now_ns);
}

static double max_current_A(const hil_axis_params *params)
{
    (void)params;
    return 0;
}

static void open_chip(hil_axis *a, const hil_axis_params *params)
{
    (void)params;
    as5047d *e = a->own;
    e->pins[HIL_SPI_IN_CSN] = 1;
    e->out.levels[HIL_SPI_OUT_MISO] = OUTPUT_OPEN;
}

static void close_chip(hil_axis *a)
{
    as5047d *e = a->own;
    outputs_close(&e->out);
}

static void power_up(hil_core *c, hil_axis *a, int64_t now_ns)
{
    as5047d *e = a->own;
    for (int i = 0; i < AS5047D_SETTINGS; i++) e->settings[i] = i == AT_SETTINGS1 ? FACTORY : 0;
    a->encoder.errfl = 0;
    e->writes = -1;
    e->frames = 0;
    e->clocks = 0;
    e->heard = 0;
    outputs_set(c, &e->out, HIL_SPI_OUT_MISO, e->pins[HIL_SPI_IN_CSN] ? OUTPUT_OPEN : 0, now_ns);
    answer(a, 0, 0);
}

static int64_t step(hil_core *c, hil_axis *a, int64_t until_ns)
{
    (void)c, (void)a, (void)until_ns; /* it does nothing by itself */
    return 0;
}

static void drive(hil_axis *a) { (void)a; }

static int set(hil_axis *a, hil_field field, double value, int64_t now_ns)
{
    int content = (int)fmin(fmax(value, 0), 0xFFFF);
    switch (field) {
    case HIL_FIELD_diaagc: a->encoder.diaagc = content; return 0;
    case HIL_FIELD_errfl: a->encoder.errfl = content; return 0;
    case HIL_FIELD_spi_previous_command: command(a, content, now_ns); return 0;
    default: return -1;
    }
}

static outputs *outputs_of(hil_axis *a)
{
    as5047d *e = a->own;
    return &e->out;
}

const law as5047d_law = {
    .bytes = sizeof(as5047d),
    .kind = HIL_KIND_ENCODER_CHIP,
    .pulled_up = 1 << HIL_SPI_IN_CSN,
    .events = 1,
    .max_current_A = max_current_A,
    .open = open_chip,
    .close = close_chip,
    .power_up = power_up,
    .step = step,
    .drive = drive,
    .pin = set_pin,
    .set = set,
    .outputs = outputs_of,
    .count = count,
    .is_passive = 1,
};
