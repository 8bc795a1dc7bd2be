/* Cells: values of a firmware's own, in the snapshots of its board's axis. Each stands where a field of another kind of axis
   would: the layout stays as it is, and the axis's description says what is there. */
#ifndef HIL_CELLS_H
#define HIL_CELLS_H

#include "types.h"

typedef struct cell {
    int32_t field; /* whose place it has */
    int32_t offset;
    char type[2];  /* as 'f', '6' of f64 */
    double value;  /* of i64: whole, within 2^53 */
} cell;

typedef struct own_cells {
    int n;
    cell cells[];
} own_cells;

static inline double cell_read(const cell *c, const hil_snapshot *s)
{
    const char *at = (const char *)s + c->offset;
    if (c->type[0] == 'f') return c->type[1] == '6' ? *(const hil_f64 *)(const void *)at : *(const hil_f32 *)(const void *)at;
    return c->type[1] == '6' ? (double)*(const hil_i64 *)(const void *)at : *(const hil_i32 *)(const void *)at;
}

static inline void cell_write(const cell *c, double value, hil_snapshot *s)
{
    char *at = (char *)s + c->offset;
    if (c->type[0] == 'f' && c->type[1] == '6') *(hil_f64 *)(void *)at = value;
    else if (c->type[0] == 'f') *(hil_f32 *)(void *)at = (hil_f32)value;
    else if (c->type[1] == '6') *(hil_i64 *)(void *)at = (hil_i64)value;
    else *(hil_i32 *)(void *)at = (hil_i32)value;
}

static inline void cells_show(const own_cells *own, hil_snapshot *s)
{
    for (int i = 0; i < own->n; i++) cell_write(&own->cells[i], own->cells[i].value, s);
}

/* NULL: no cell has the field's place. */
static inline cell *cells_find(own_cells *own, int field)
{
    for (int i = 0; own && i < own->n; i++)
        if (own->cells[i].field == field) return &own->cells[i];
    return NULL;
}

#endif
