/* Heat of a driver's chip: its junction over the air around it, and the shutdown that ends by itself. */
#ifndef HIL_LAW_HEAT_H
#define HIL_LAW_HEAT_H

#include <stdint.h>

typedef struct heat_limits {
    double hot_degC, cool_degC; /* shutdown, and where it ends */
    double K_per_W, warming_s;
} heat_limits;

typedef struct heat {
    const heat_limits *limits; /* NULL: it has no heat */
    double ambient_degC, junction_degC; /* junction: at at_ns */
    double power_W;                     /* since then */
    int64_t at_ns;
    int is_too_hot;
    int64_t trips, hot_at_ns, cool_at_ns; /* shutdowns since the start, the latest one, and its end */
} heat;

enum { HEAT_LOOK_NS = 100000000 }; /* how often a driver on its way to a threshold is looked at */

void heat_open(heat *h, const heat_limits *limits, double ambient_degC); /* it is as warm as the air until heat_begin */
void heat_begin(heat *h, int64_t now_ns);
double heat_degC(const heat *h, int64_t now_ns);
void heat_to(heat *h, int64_t now_ns); /* before its power changes, or to look at it */
int heat_is_level(const heat *h, int64_t now_ns); /* it has been long enough as it is */
int heat_is_on_its_way(const heat *h); /* its power leads past a threshold */

#endif
