/* An axis by its public face: encoder, inputs, fields, snapshots. */
#include "fixture.h"

static int raw_at_ns(hil_core *c, int64_t t_ns)
{
    hil_group_advance(c, 0, t_ns);
    CHECK_INT(hil_group_now(c, 0), t_ns);
    return (int)hil_axis_get(c, 0, HIL_FIELD_raw);
}

/* floor and modulo with divisions that C rounds towards 0, in plain integers. */
static int exact_raw(int n, const int64_t *at_ns, const int64_t *raw, int linear, int64_t t_ns)
{
    int i = 0;
    while (i + 1 < n && at_ns[i + 1] <= t_ns) i++;
    int64_t value = raw[i];
    if (linear && i + 1 < n && t_ns >= at_ns[i]) {
        int64_t over = (raw[i + 1] - raw[i]) * (t_ns - at_ns[i]), by = at_ns[i + 1] - at_ns[i];
        value += over / by - (over % by < 0);
    }
    return (int)((value % 16384 + 16384) % 16384);
}

static void script_held(void)
{
    hil_core *c = new_bench();
    static const int64_t at_ns[] = {1000, 2000, 2000, 5000}, raw[] = {5, -1, 16384, -16385};
    CHECK_INT(hil_axis_script_encoder(c, 0, 4, at_ns, raw, 0), 0);
    CHECK_INT(raw_at_ns(c, 0), 5);
    CHECK_INT(raw_at_ns(c, 1000), 5);
    CHECK_INT(raw_at_ns(c, 1999), 5);
    CHECK_INT(raw_at_ns(c, 2000), 0); /* of two points at one time the later one */
    CHECK_INT(raw_at_ns(c, 4999), 0);
    CHECK_INT(raw_at_ns(c, 5000), 16383);
    CHECK_INT(raw_at_ns(c, 900000), 16383);
    CHECK_INT(hil_axis_script_encoder(c, 0, 0, NULL, NULL, 0), 0);
    double turns = hil_axis_get(c, 0, HIL_FIELD_position_deg) / 360;
    CHECK(turns != 0);
    CHECK_INT((int)hil_axis_get(c, 0, HIL_FIELD_raw), (int)((turns - floor(turns)) * 16384)); /* the shaft's again */
    hil_core_free(c);
}

static void script_linear(void)
{
    uint64_t seed = 5;
    for (int round = 0; round < 30; round++) {
        hil_core *c = new_bench();
        int64_t at_ns[8], raw[8], t_ns = 0;
        for (int i = 0; i < 8; i++) {
            at_ns[i] = t_ns += random_below(&seed, round % 2 ? 20 : 100000);
            raw[i] = random_below(&seed, 200001) - 100000;
        }
        hil_axis_script_encoder(c, 0, 8, at_ns, raw, 1);
        int64_t stride = round % 2 ? 1 : 777;
        for (int64_t now_ns = 0; now_ns <= t_ns + 10; now_ns += stride)
            CHECK_INT(raw_at_ns(c, now_ns), exact_raw(8, at_ns, raw, 1, now_ns));
        hil_core_free(c);
    }
}

static void script_floors_at_boundaries(void)
{
    hil_core *c = new_bench();
    static const int64_t at_ns[] = {0, 3000000}, raw[] = {0, -3};
    hil_axis_script_encoder(c, 0, 2, at_ns, raw, 1);
    CHECK_INT(raw_at_ns(c, 0), 0);
    CHECK_INT(raw_at_ns(c, 1), 16383);
    CHECK_INT(raw_at_ns(c, 1000000), 16383);
    CHECK_INT(raw_at_ns(c, 1000001), 16382);
    CHECK_INT(raw_at_ns(c, 2999999), 16381);
    CHECK_INT(raw_at_ns(c, 3000000), 16381);
    hil_core_free(c);
}

static void script_far_out(void)
{
    hil_core *c = new_bench();
    const int64_t far = INT64_C(1) << 61, at_ns[] = {-far, far}, raw[] = {-far, far};
    hil_axis_script_encoder(c, 0, 2, at_ns, raw, 1);
    CHECK_INT(raw_at_ns(c, 16384 + 77), 77);
    hil_core_free(c);
}

static void shaft_counts(void)
{
    hil_axis_params still = MECHADUINO;
    still.inertia_kg_m2 = 1e6; /* holds it where it starts */
    static const double START_DEG[] = {0, 90, 359.99, -90, -0.01, 725, -1e-20};
    static const int RAW[] = {0, 4096, 16383, 12288, 16383, 227, 0};
    for (int i = 0; i < 7; i++) {
        hil_core *c = new_core(1);
        still.start_deg = START_DEG[i];
        hil_axis_open(c, open_group(c, 0), &still);
        CHECK_INT((int)hil_axis_get(c, 0, HIL_FIELD_raw), RAW[i]);
        CHECK_NEAR(hil_axis_get(c, 0, HIL_FIELD_position_deg), START_DEG[i], 1e-12);
        hil_core_free(c);
    }
}

static void too_stiff_is_refused(void)
{
    hil_core *c = new_core(1);
    hil_axis_params stiff = MECHADUINO;
    stiff.viscous_Nm_s_per_rad = 1e6;
    CHECK_INT(hil_axis_open(c, open_group(c, 0), &stiff), -2);
    CHECK_INT(open_axis(c, 0), 0); /* the slot is still free */
    hil_core_free(c);
}

static void spi_answers_a_frame_late(void)
{
    hil_core *c = new_bench();
    static const int64_t at_ns[] = {0, 100, 200}, raw[] = {3, 7, 8192};
    hil_axis_script_encoder(c, 0, 3, at_ns, raw, 0);
    hil_axis_set(c, 0, HIL_FIELD_diaagc, 0x0105);
    hil_axis_set(c, 0, HIL_FIELD_errfl, 5);
    CHECK_INT(hil_axis_spi(c, 0, 0xFFFC), 0xC003); /* power-up primes an angle; with the error flag three ones, so parity */
    CHECK_INT(hil_axis_spi(c, 0, 0x4001), 0x4105); /* DIAAGC: four ones, even */
    CHECK_INT(hil_axis_get(c, 0, HIL_FIELD_errfl), 5);
    CHECK_INT(hil_axis_get(c, 0, HIL_FIELD_spi_previous_command), 0x4001);
    CHECK_INT(hil_axis_spi(c, 0, 0xFFFC), 0xC005); /* ERRFL, still flagged, and cleared */
    CHECK_INT(hil_axis_get(c, 0, HIL_FIELD_errfl), 0);
    CHECK_INT(hil_axis_spi(c, 0, 0x4001), 0x8105); /* DIAAGC: three ones without the flag */
    CHECK_INT(hil_axis_spi(c, 0, 0xC000), 0);
    CHECK_INT(hil_axis_spi(c, 0, 0xFFFF), 0); /* NOP answers 0 */
    hil_group_advance(c, 0, 100);
    CHECK_INT(hil_axis_spi(c, 0, 0xFFFF), 0x8007); /* the angle of now */
    hil_group_advance(c, 0, 200);
    CHECK_INT(hil_axis_spi(c, 0, 0xFFFF), 0xA000);
    hil_core_free(c);
}

static void steps_by_rising_edges(void)
{
    hil_core *c = new_bench();
    for (int i = 0; i < 3; i++) {
        hil_axis_pin(c, 0, 1, 1);
        hil_axis_pin(c, 0, 1, 7); /* still high */
        hil_axis_pin(c, 0, 1, 0);
    }
    CHECK_NEAR(hil_axis_get(c, 0, HIL_FIELD_r), 3 * 0.05625, 1e-7);
    hil_axis_set(c, 0, HIL_FIELD_dir, 0);
    hil_axis_pin(c, 0, 0, 0); /* no edge: it stays as it was set */
    CHECK_INT(hil_axis_get(c, 0, HIL_FIELD_dir), 0);
    hil_axis_pin(c, 0, 0, 1);
    for (int i = 0; i < 4; i++) {
        hil_axis_pin(c, 0, 1, 1);
        hil_axis_pin(c, 0, 1, 0);
    }
    CHECK_NEAR(hil_axis_get(c, 0, HIL_FIELD_r), -0.05625, 1e-7);
    CHECK_INT(hil_axis_get(c, 0, HIL_FIELD_pin_dir), 1);
    hil_axis_pin(c, 0, 3, 1);
    CHECK_INT(hil_axis_get(c, 0, HIL_FIELD_pin_d3), 1);
    CHECK_INT(hil_axis_get(c, 0, HIL_FIELD_pin_step), 0);
    hil_core_free(c);
}

static void enable_input(void)
{
    hil_core *c = new_bench();
    hil_event e;
    hil_group_advance(c, 0, 1000);
    hil_axis_loop(c, 0, 1);
    hil_axis_output(c, 0, 1.8f, 100);
    hil_axis_pin(c, 0, 2, 0); /* no change, no event */
    CHECK_INT(hil_group_take_event(c, 0, &e), 0);
    hil_axis_pin(c, 0, 2, 1);
    CHECK_INT(hil_axis_get(c, 0, HIL_FIELD_loop_on), 0);
    CHECK_INT(hil_axis_get(c, 0, HIL_FIELD_vref1), 0);
    CHECK_INT(hil_axis_get(c, 0, HIL_FIELD_vref2), 0);
    hil_group_advance(c, 0, 2000);
    hil_axis_pin(c, 0, 2, 0);
    CHECK_INT(hil_axis_get(c, 0, HIL_FIELD_loop_on), 1);
    CHECK_INT(hil_group_take_event(c, 0, &e), 1);
    CHECK(e.at_ns == 1000 && e.axis == 0 && e.kind == HIL_EVENT_ENABLE && e.value == 1);
    CHECK_INT(hil_group_take_event(c, 0, &e), 1);
    CHECK(e.at_ns == 2000 && e.kind == HIL_EVENT_ENABLE && e.value == 0);
    CHECK_INT(hil_group_take_event(c, 0, &e), 0);
    hil_core_free(c);
}

static void driver_currents(void)
{
    hil_core *c = new_bench();
    double amps = 3.3 / 255 / 1.5;
    CHECK_NEAR(hil_axis_get(c, 0, HIL_FIELD_current_a_A), 37 * amps, 1e-12);
    hil_axis_output(c, 0, -1.8f, 115);
    CHECK_NEAR(hil_axis_get(c, 0, HIL_FIELD_current_a_A), -115 * amps, 1e-12);
    CHECK_NEAR(hil_axis_get(c, 0, HIL_FIELD_current_b_A), 0, 1e-12);
    hil_axis_vref(c, 0, 0, 0);
    CHECK_INT(hil_axis_get(c, 0, HIL_FIELD_in1), 1);
    CHECK_NEAR(hil_axis_get(c, 0, HIL_FIELD_current_a_A), 0, 0);
    hil_core_free(c);
}

/* Every field: get agrees with the snapshot, and set refuses exactly the read-only ones. */
static void fields_agree(void)
{
    hil_core *c = new_bench();
    hil_axis_loop(c, 0, 1);
    hil_axis_set(c, 0, HIL_FIELD_mode, 'x');
    hil_axis_set(c, 0, HIL_FIELD_r, 5);
    hil_group_advance(c, 0, 12345678);
    hil_snapshot s;
    hil_axis_snapshot(c, 0, &s);
    CHECK_INT(s.at_ns, 12345678);
    CHECK_INT(s.control_steps, 80);
    for (int i = 0; i < HIL_FIELDS; i++) {
        const hil_field_info *f = &hil_field_table[i];
        const char *at = (const char *)&s + f->offset;
        double value = 0;
        float f32;
        int32_t i32;
        int64_t i64;
        switch (f->type[0] << 8 | f->type[1]) {
        case 'f' << 8 | '3': memcpy(&f32, at, 4); value = (double)f32; break;
        case 'f' << 8 | '6': memcpy(&value, at, 8); break;
        case 'i' << 8 | '3': memcpy(&i32, at, 4); value = i32; break;
        default: memcpy(&i64, at, 8); value = (double)i64;
        }
        if (hil_axis_get(c, 0, (hil_field)i) != value) CHECK_FAILED("%s: get and snapshot differ", f->name);
        int is_mine = f->kind == HIL_KIND_ANY || f->kind & HIL_KIND_SERVO; /* the others' fields are nothing to a servo */
        if ((hil_axis_set(c, 0, (hil_field)i, value) == 0) != (f->writable && is_mine))
            CHECK_FAILED("%s: set does not do as the table says", f->name);
        if (hil_axis_get(c, 0, (hil_field)i) != value) CHECK_FAILED("%s: set to itself, it changed", f->name);
    }
    CHECK(isnan(hil_axis_get(c, 0, HIL_FIELDS)));
    CHECK_INT(hil_axis_set(c, 0, HIL_FIELDS, 0), -1);
    hil_core_free(c);
}

static void whole_numbers_saturate(void)
{
    hil_core *c = new_bench();
    static const hil_field FIELDS[] = {HIL_FIELD_mode, HIL_FIELD_uMAX, HIL_FIELD_diaagc, HIL_FIELD_errfl,
                                       HIL_FIELD_spi_previous_command};
    for (int i = 0; i < 5; i++) {
        hil_axis_set(c, 0, FIELDS[i], 1e300);
        CHECK_INT((int64_t)hil_axis_get(c, 0, FIELDS[i]), INT32_MAX);
        hil_axis_set(c, 0, FIELDS[i], -INFINITY);
        CHECK_INT((int64_t)hil_axis_get(c, 0, FIELDS[i]), INT32_MIN);
        hil_axis_set(c, 0, FIELDS[i], NAN);
        CHECK_INT((int64_t)hil_axis_get(c, 0, FIELDS[i]), 0);
        hil_axis_set(c, 0, FIELDS[i], -7.9);
        CHECK_INT((int64_t)hil_axis_get(c, 0, FIELDS[i]), -7);
    }
    hil_core_free(c);
}

/* Any number in any field, with loop and rotor running; the sanitizers watch. */
static void any_field_is_defined(void)
{
    static const double NUMBERS[] = {NAN, INFINITY, -INFINITY, 1e300, -1e300, 3e38, 2147483648.0, -2147483649.0, 1e15};
    static const int MODES[] = {'x', 'v', 't', 'h', 0};
    for (int field = 0; field < HIL_FIELDS; field++)
        for (int i = 0; i < 9; i++)
            for (int mode = 0; mode < 5 && hil_field_table[field].writable; mode++) {
                hil_core *c = new_bench();
                hil_snapshot s;
                hil_axis_set(c, 0, HIL_FIELD_mode, MODES[mode]);
                hil_axis_set(c, 0, HIL_FIELD_r, mode == 2 ? 1e30 : 500);
                hil_axis_set(c, 0, (hil_field)field, NUMBERS[i]);
                hil_axis_loop(c, 0, 1);
                hil_group_advance(c, 0, 3000000);
                hil_axis_set(c, 0, (hil_field)field, NUMBERS[8 - i]);
                hil_group_advance(c, 0, 6000000);
                hil_axis_spi(c, 0, 0xFFFF);
                hil_axis_pin(c, 0, 2, 1);
                hil_axis_snapshot(c, 0, &s);
                CHECK(s.raw >= 0 && s.raw < 16384);
                hil_core_free(c);
            }
}

static void power_up_is_a_cold_start(void)
{
    hil_core *c = new_bench();
    hil_snapshot s;
    hil_axis_loop(c, 0, 1);
    hil_axis_set(c, 0, HIL_FIELD_mode, 'v');
    hil_axis_set(c, 0, HIL_FIELD_r, 60);
    hil_axis_set(c, 0, HIL_FIELD_diaagc, 9);
    hil_axis_pin(c, 0, 3, 1);
    hil_group_advance(c, 0, 300000000);
    hil_axis_snapshot(c, 0, &s);
    double position_deg = s.position_deg, velocity_rpm = s.velocity_rpm;
    CHECK_NEAR(velocity_rpm, 60, 10);
    hil_axis_power_up(c, 0);
    hil_axis_snapshot(c, 0, &s);
    CHECK(s.position_deg == position_deg && s.velocity_rpm == velocity_rpm);
    CHECK(s.mode == 0 && s.r == 0 && s.v == 0 && s.ITerm == 0 && s.loop_on == 0 && s.control_steps == 0);
    CHECK(s.vref1 == 37 && s.in2 == 1 && s.vref2 == 37 && s.in4 == 1 && s.in1 == 0 && s.in3 == 0);
    CHECK(s.diaagc == 9 && s.pin_d3 == 1);
    CHECK(hil_axis_table(c, 0)[16383] > 359);
    hil_core_free(c);
}

void axis_tests(void)
{
    RUN(script_held);
    RUN(script_linear);
    RUN(script_floors_at_boundaries);
    RUN(script_far_out);
    RUN(shaft_counts);
    RUN(too_stiff_is_refused);
    RUN(spi_answers_a_frame_late);
    RUN(steps_by_rising_edges);
    RUN(enable_input);
    RUN(driver_currents);
    RUN(fields_agree);
    RUN(whole_numbers_saturate);
    RUN(any_field_is_defined);
    RUN(power_up_is_a_cold_start);
}
