/* Switches along an axis's way: cams that close contacts, and what the contacts do to pins. */
#ifndef HIL_SWITCHES_H
#define HIL_SWITCHES_H

#include "state.h"

/* How often a shaft is looked at; between two looks its speed says when it comes to the next edge of a cam. A look is at
   least so much after the one before. */
enum { SWITCH_LOOK_NS = 100000, SWITCH_LEAST_NS = 1000 };

void switches_look(hil_core *c, hil_axis *a); /* at switch_next_ns: edges that are due, and when to look again */
void switches_close(hil_axis *a);

#endif
