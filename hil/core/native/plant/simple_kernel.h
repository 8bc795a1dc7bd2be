/* One step of the simple plant, for one REAL (real.h): Chin's fourth-order composition (4A) of kicks and
   drifts. A kick is a torque's impulse at one angle; the one in the middle has the torque's gradient in it,
   which costs nothing beside its sine and cosine. A drift has viscous friction's decay in it, exactly. So a
   step has two sines, and the one of its end is the next step's first. Siu A. Chin, Physics Letters A 226
   (1997) 344. */

typedef struct NAME(plant_rate) { /* of a length of step */
    REAL kick_s, middle_kick_s, gradient_s2, reach_s, keep;
} NAME(plant_rate);

typedef struct NAME(plant_motor) {
    REAL pull, load, teeth, limit; /* pull: rev/s2 of an ampere; load: rev/s2; limit: rev/s */
} NAME(plant_motor);

typedef struct NAME(plant_moving) {
    REAL rev, rev_per_s, s, c; /* s, c: of the electrical angle */
} NAME(plant_moving);

INLINE void NAME(plant_step)(const NAME(plant_motor) *m, const NAME(plant_rate) *r, NAME(plant_moving) *x, REAL a_A,
                             REAL b_A)
{
    REAL v = x->rev_per_s + r->kick_s * (m->load - m->pull * (a_A * x->c + b_A * x->s)), s, c;
    REAL middle_rev = x->rev + r->reach_s * v;
    NAME(sincos_turns)(m->teeth * middle_rev, &s, &c);
    REAL accel = m->load - m->pull * (a_A * c + b_A * s);
    REAL gradient = m->pull * (m->teeth * TWO_PI) * (a_A * s - b_A * c);
    v = r->keep * v + r->middle_kick_s * (accel + r->gradient_s2 * accel * gradient);
    x->rev = middle_rev + r->reach_s * v;
    NAME(sincos_turns)(m->teeth * x->rev, &x->s, &x->c);
    x->rev_per_s = NAME(turning)(r->keep * v + r->kick_s * (m->load - m->pull * (a_A * x->c + b_A * x->s)), m->limit);
}
