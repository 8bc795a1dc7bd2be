/* Error and overload frames, and the counters. */
#include "can_errors.h"

int can_is_passive(const can_node *n) { return n->tec >= CAN_PASSIVE || n->rec >= CAN_PASSIVE; }

void can_go_off(can_node *n)
{
    n->state = CAN_BUS_OFF;
    n->count = n->sequences = 0;
    n->is_sender = 0;
    n->drive = 1;
    n->happened |= CAN_CHANGED;
}

/* At the sender's counter, or at the receiver's. */
static void count_error(can_node *n, int by)
{
    int was_passive = can_is_passive(n);
    if (n->is_listening) return;
    if (n->is_sender) {
        n->tec += by;
        if (n->tec >= CAN_OFF) { /* 7, rule 10 */
            can_go_off(n);
            return;
        }
    } else {
        n->rec = n->rec + by < CAN_REC_MAX ? n->rec + by : CAN_REC_MAX;
    }
    if (was_passive != can_is_passive(n)) n->happened |= CAN_CHANGED;
}

/* Find an error, and begin a flag with the next bit: an active one also if this very error makes the node
   passive (7, rule 9). */
void can_wrong(can_node *n, int error)
{
    int was_passive = can_is_passive(n);
    int is_forgiven = n->is_forgiven;
    n->happened |= CAN_ERROR;
    n->error = error;
    n->is_forgiven = error == CAN_ACK_ERROR && was_passive; /* 7, rule 3, exception 1; see the passive flag */
    if (!n->is_forgiven && !(error == CAN_STUFF_ERROR && is_forgiven)) count_error(n, n->is_sender ? 8 : 1);
    if (n->state == CAN_BUS_OFF) return;
    n->count = 0;
    n->is_overload = 0;
    n->last = 2;
    n->is_first = 1;
    n->drive = was_passive || n->is_listening;
    n->state = n->drive ? CAN_PASSIVE_FLAG : CAN_FLAG;
}

/* Answer a dominant bit where none may be by an overload flag, 3.1.4. */
void can_overload(can_node *n)
{
    n->count = 0;
    n->is_overload = 1;
    n->last = 2;
    n->drive = n->is_listening;
    n->state = n->drive ? CAN_PASSIVE_FLAG : CAN_FLAG;
}

static void wait_behind_flag(can_node *n)
{
    n->state = CAN_WAITING;
    n->drive = 1;
    n->count = 0;
    n->is_first = !n->is_overload;
}

static void step_flag(can_node *n, int level)
{
    if (level) { /* 7, rules 4 and 5 */
        n->happened |= CAN_ERROR;
        n->error = CAN_BIT_ERROR;
        n->count = 0;
        count_error(n, 8);
    } else if (++n->count == 6) {
        wait_behind_flag(n);
    }
}

static void step_passive_flag(can_node *n, int level)
{
    n->count = level == n->last ? n->count + 1 : 1;
    n->last = level;
    if (!level && n->is_forgiven) { /* somebody else has found an error too */
        n->is_forgiven = 0;
        count_error(n, 8);
        if (n->state == CAN_BUS_OFF) return;
    }
    if (n->count == 6) wait_behind_flag(n);
}

static void step_waiting(can_node *n, int level)
{
    if (level) {
        n->state = CAN_DELIMITER;
        n->count = 1;
        return;
    }
    n->count++;
    if (n->is_first && !n->is_sender) count_error(n, 8); /* 7, rule 2 */
    n->is_first = 0;
    if (n->count % 8 == 0) count_error(n, 8); /* 7, rule 6 */
}

/* A bit of an error or overload frame. */
void can_step_error(can_node *n, int level)
{
    if (n->state == CAN_FLAG) {
        step_flag(n, level);
    } else if (n->state == CAN_PASSIVE_FLAG) {
        step_passive_flag(n, level);
    } else if (n->state == CAN_WAITING) {
        step_waiting(n, level);
    } else if (level) {
        if (++n->count == 8) {
            n->state = CAN_INTERMISSION;
            n->count = 0;
        }
    } else if (n->count == 7) {
        can_overload(n);
    } else {
        can_wrong(n, CAN_FORM_ERROR);
    }
}
