/* One step of the full plant, for one REAL (real.h): drift, kick, drift, forces being those of the middle of
   the step.

   The electrical angle is not turned into a sine at every step. A window is up to four steps from a node on.
   At its start the angle's sine and cosine are taken, and turned on from each step's middle to the next one's
   by what the speed at the window's start makes of it (forecast). What the shaft does otherwise is a small
   angle (astray) on top, for which short series do. So a step hangs on the one before by little more than
   speed, torque, speed. */

typedef struct NAME(full_rate) { /* of a length of step */
    REAL h_s, half_s, slow, push, dry, henry_per_s, fade, feed;
} NAME(full_rate);

typedef struct NAME(full_motor) {
    REAL R, K, emf_V_s, supply_V, detent_Nm, viscous, coulomb_Nm, teeth, whole_s, limit; /* limit: rev/s */
    REAL step_s, step_c, once_s, once_c, twice_s, twice_c; /* the errors of motor and encoder, rev */
} NAME(full_motor);

typedef struct NAME(full_state) {
    REAL rev, rev_per_s, a_A, b_A;
} NAME(full_state);

/* Since the opening. electrical = copper + friction + load + what shaft, coils and detent store. */
typedef struct NAME(full_energy) {
    REAL electrical_J, copper_J, friction_J, load_J;
} NAME(full_energy);

typedef struct NAME(full_window) {
    REAL turn, turn_s, turn_c;   /* the shaft's angle at the start, whole turns left out; its sine and cosine */
    REAL s, c;                   /* of the forecast electrical angle in the middle of the next step */
    REAL on_s, on_c, on;         /* from one middle to the next */
    REAL gear;                   /* electrical angle, rad, of a revolution */
    REAL astray, last_half_s;
} NAME(full_window);

typedef struct NAME(full_moving) {
    NAME(full_state) state;
    NAME(full_energy) energy;
    REAL a_V, b_V; /* mean over the last step */
    NAME(full_window) window;
} NAME(full_moving);

INLINE REAL NAME(within)(REAL x, double most)
{
    return GREATER(LESSER(x, CONSTANT(most)), CONSTANT(-most)); /* a NaN is cut too */
}

/* The shaft's angle: at every node at which a window may begin. */
INLINE void NAME(full_locate)(NAME(full_moving) *x)
{
    x->window.turn = x->state.rev - NAME(floor_of)(x->state.rev);
    NAME(sincos_turns)(x->window.turn, &x->window.turn_s, &x->window.turn_c);
}

/* Counts of the encoder at the window's start, without noise and not rounded; turns included or not. */
INLINE REAL NAME(full_count)(const NAME(full_motor) *m, const NAME(full_moving) *x)
{
    REAL s = x->window.turn_s, c = x->window.turn_c, s2 = 2.0 * s * c, c2 = c * c - s * s;
    return (x->window.turn + (m->once_c * s + m->once_s * c) + (m->twice_c * s2 + m->twice_s * c2)) * 16384.0;
}

/* splitmix64's finisher: every bit of the result depends on every bit of x. */
INLINE MASK NAME(full_hash)(MASK x)
{
    x += 0x9E3779B97F4A7C15;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EB;
    return x ^ (x >> 31);
}

/* What a reading at t_ns has of noise: about normal, four uniform parts of one hash. */
INLINE REAL NAME(full_noise)(MASK key, REAL counts, MASK t_ns)
{
    MASK bits = NAME(full_hash)(key ^ NAME(full_hash)(t_ns));
    MASK sum = (bits & 0xFFFF) + ((bits >> 16) & 0xFFFF) + ((bits >> 32) & 0xFFFF) + (bits >> 48) + 2;
    REAL parts = UNBITS(sum | 0x4330000000000000) - 0x1p52; /* sum, in a double's low bits */
    return counts * ((parts * 0x1p-16 - 2.0) * 1.7320508075688772);
}

/* A reading from counts that are not rounded; below 2^51. */
INLINE MASK NAME(full_rounded)(REAL count) { return BITS(NAME(floor_of)(count) + NEAREST) & 16383; }

INLINE void NAME(full_open)(const NAME(full_motor) *m, NAME(full_moving) *x)
{
    NAME(full_window) *w = &x->window;
    REAL half_s, half_c;
    REAL error = m->step_c * w->turn_s + m->step_s * w->turn_c;
    REAL per_rev = 1.0 + TWO_PI * (m->step_c * w->turn_c - m->step_s * w->turn_s);
    NAME(sincos_turns)(m->teeth * (w->turn + error), &w->s, &w->c);
    REAL half_turns = 0.5 * m->whole_s * m->teeth * per_rev * x->state.rev_per_s;
    NAME(sincos_turns)(half_turns, &half_s, &half_c);
    w->on_s = 2.0 * half_s * half_c;
    w->on_c = half_c * half_c - half_s * half_s;
    w->on = half_turns * (2 * TWO_PI);
    w->gear = m->teeth * TWO_PI * per_rev;
    REAL s = w->s;
    w->s = s * half_c + w->c * half_s;
    w->c = w->c * half_c - s * half_s;
    w->astray = -0.5 * w->on;
    w->last_half_s = CONSTANT(0.0);
}

INLINE REAL NAME(full_kicked)(const NAME(full_motor) *m, const NAME(full_rate) *r, REAL rev_per_s, REAL torque_Nm)
{
    REAL v = r->slow * rev_per_s + r->push * torque_Nm; /* viscous friction at the mean speed */
    /* The impulse of dry friction at most stops the shaft: it stays until the torque exceeds it. */
    return NAME(turning)(v - GREATER(LESSER(v, r->dry), -r->dry), m->limit);
}

/* One coil. The bridge's mean voltage is the one that brings the current to the command, as far as the supply
   goes. */
INLINE REAL NAME(full_wanted_V)(const NAME(full_motor) *m, const NAME(full_rate) *r, REAL before_A, REAL command_A,
                                REAL mean_A, REAL emf_V)
{
    return emf_V + m->R * mean_A + r->henry_per_s * (command_A - before_A);
}

INLINE REAL NAME(full_limited_A)(const NAME(full_motor) *m, const NAME(full_rate) *r, REAL *voltage_V, REAL before_A,
                                 REAL command_A, REAL emf_V)
{
    REAL wanted_V = *voltage_V, supply_V = PICK(wanted_V > 0.0, m->supply_V, -m->supply_V);
    MASK limited = MAGNITUDE(wanted_V) > m->supply_V;
    REAL reached_A = NAME(within)(r->fade * before_A + r->feed * (supply_V - emf_V), 1e6);
    *voltage_V = PICK(limited, supply_V, wanted_V);
    return PICK(limited, reached_A, command_A);
}

/* load_Nm: at the middle of the step. The window has been opened. */
INLINE void NAME(full_step)(const NAME(full_motor) *m, const NAME(full_rate) *r, NAME(full_moving) *x, REAL command_a_A,
                            REAL command_b_A, REAL load_Nm)
{
    NAME(full_state) *q = &x->state;
    NAME(full_window) *w = &x->window;
    REAL before = q->rev_per_s, middle_rev = q->rev + r->half_s * before;
    REAL astray = w->astray + w->gear * (w->last_half_s + r->half_s) * before;
    MASK far = MAGNITUDE(astray) > 0.125;
    if (ANY(far)) {
        REAL turn = middle_rev - NAME(floor_of)(middle_rev), s, c;
        NAME(sincos_turns)(turn, &s, &c);
        NAME(sincos_turns)(m->teeth * (turn + (m->step_c * s + m->step_s * c)), &s, &c);
        w->s = PICK(far, s, w->s);
        w->c = PICK(far, c, w->c);
        astray = PICK(far, CONSTANT(0.0), astray);
    }
    /* Sine and cosine of astray, and of four times it, to 1e-7 and 1e-5. */
    REAL square = astray * astray;
    REAL by_c = 1.0 - square * (0.5 - square * (1.0 / 24)), by_s = astray * (1.0 - square * (1.0 / 6));
    REAL by_c4 = 1.0 - square * (8.0 - square * (32.0 / 3));
    REAL by_s4 = astray * (4.0 - square * (32.0 / 3 - square * (128.0 / 15)));
    REAL s = w->s * by_c + w->c * by_s, c = w->c * by_c - w->s * by_s;

    /* Stable where one coil alone holds the rotor: the sine of four times the electrical angle. */
    REAL s2 = 2.0 * w->s * w->c, c2 = w->c * w->c - w->s * w->s;
    REAL other_Nm = load_Nm - m->detent_Nm * (2.0 * s2 * c2 * by_c4 + (c2 * c2 - s2 * s2) * by_s4);
    REAL a_A = q->a_A, b_A = q->b_A, mean_a_A = 0.5 * (a_A + command_a_A), mean_b_A = 0.5 * (b_A + command_b_A);
    REAL at_s = mean_a_A * w->c + mean_b_A * w->s, at_c = mean_b_A * w->c - mean_a_A * w->s;
    REAL speed = NAME(full_kicked)(m, r, before, other_Nm - m->K * (at_s * by_c + at_c * by_s));
    REAL emf_V = m->emf_V_s * (before + speed);
    x->a_V = NAME(full_wanted_V)(m, r, a_A, command_a_A, mean_a_A, emf_V * c);
    x->b_V = NAME(full_wanted_V)(m, r, b_A, command_b_A, mean_b_A, emf_V * s);
    q->a_A = command_a_A;
    q->b_A = command_b_A;
    if (ANY((MASK)(MAGNITUDE(x->a_V) > m->supply_V) | (MASK)(MAGNITUDE(x->b_V) > m->supply_V))) {
        /* Where the supply is enough this gives what was there. */
        q->a_A = NAME(full_limited_A)(m, r, &x->a_V, a_A, command_a_A, emf_V * c);
        q->b_A = NAME(full_limited_A)(m, r, &x->b_V, b_A, command_b_A, emf_V * s);
        mean_a_A = 0.5 * (a_A + q->a_A);
        mean_b_A = 0.5 * (b_A + q->b_A);
        at_s = mean_a_A * w->c + mean_b_A * w->s;
        at_c = mean_b_A * w->c - mean_a_A * w->s;
        speed = NAME(full_kicked)(m, r, before, other_Nm - m->K * (at_s * by_c + at_c * by_s));
    }
    q->rev_per_s = speed;
    q->rev = middle_rev + r->half_s * speed;

    REAL rad_per_s = TWO_PI * 0.5 * (before + speed), rad = rad_per_s * r->h_s;
    x->energy.electrical_J = x->energy.electrical_J + (x->a_V * mean_a_A + x->b_V * mean_b_A) * r->h_s;
    x->energy.copper_J = x->energy.copper_J + m->R * (mean_a_A * mean_a_A + mean_b_A * mean_b_A) * r->h_s;
    x->energy.friction_J = x->energy.friction_J + m->viscous * rad_per_s * rad + m->coulomb_Nm * MAGNITUDE(rad);
    x->energy.load_J = x->energy.load_J - load_Nm * rad;

    REAL ws = w->s;
    w->s = ws * w->on_c + w->c * w->on_s;
    w->c = w->c * w->on_c - ws * w->on_s;
    w->astray = astray - w->on;
    w->last_half_s = r->half_s;
}
