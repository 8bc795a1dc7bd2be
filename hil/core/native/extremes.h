/* Smallest and largest value of each field of what is seen of an axis: of the fields that its kind of axis has, less than
   half of all, and of its cells. */
#ifndef HIL_EXTREMES_H
#define HIL_EXTREMES_H

#include <string.h>

#include "cells.h"
#include "types.h"

typedef struct extremes {
    int kind; /* HIL_KIND_* */
    const own_cells *own; /* NULL: there are no cells */
    hil_snapshot now, least, most;
    unsigned char is_most_last[HIL_FIELDS]; /* which of the two came last */
    int points, left, is_begun;             /* looks for a pair, those to come, whether there was one */
} extremes;

/* Whether a kind of axis has a field of this kind. */
#define EXTREMES_HAVE(axis_kind, field_kind) (HIL_KIND_##field_kind == HIL_KIND_ANY || ((axis_kind) & HIL_KIND_##field_kind))

/* Take what is seen now. */
static inline void extremes_widen(extremes *e)
{
    if (!e->is_begun) {
        e->least = e->most = e->now;
        memset(e->is_most_last, 0, sizeof e->is_most_last);
        e->is_begun = 1;
        return;
    }
    int axis_kind = e->kind;
#define X(name, type, kind, access, unit, expression, meaning)                                                           \
    if (EXTREMES_HAVE(axis_kind, kind)) {                                                                                \
        if (e->now.name < e->least.name) e->least.name = e->now.name, e->is_most_last[HIL_FIELD_##name] = 0;             \
        if (e->now.name > e->most.name) e->most.name = e->now.name, e->is_most_last[HIL_FIELD_##name] = 1;               \
    }
#include "fields.def"
#undef X
    for (int i = 0; e->own && i < e->own->n; i++) {
        const cell *c = &e->own->cells[i];
        double now = cell_read(c, &e->now);
        if (now < cell_read(c, &e->least)) cell_write(c, now, &e->least), e->is_most_last[c->field] = 0;
        if (now > cell_read(c, &e->most)) cell_write(c, now, &e->most), e->is_most_last[c->field] = 1;
    }
}

/* Put the first or the last extreme of each field into a sample. at_ns is a field: those of the first and the last look. */
static inline void extremes_put(const extremes *e, int is_last, hil_snapshot *out)
{
    int axis_kind = e->kind;
#define X(name, type, kind, access, unit, expression, meaning)                                                           \
    if (EXTREMES_HAVE(axis_kind, kind)) out->name = e->is_most_last[HIL_FIELD_##name] == is_last ? e->most.name : e->least.name;
#include "fields.def"
#undef X
    for (int i = 0; e->own && i < e->own->n; i++) {
        const cell *c = &e->own->cells[i];
        cell_write(c, cell_read(c, e->is_most_last[c->field] == is_last ? &e->most : &e->least), out);
    }
}

#endif
