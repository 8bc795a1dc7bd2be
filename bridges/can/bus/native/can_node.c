/* A controller in a frame, between frames, and off the bus. */
#include "can_node.h"

#include "can_chance.h"
#include "can_errors.h"
#include "can_reader.h"

static const uint8_t *sent_from(const can_node *n) { return n->places + n->place * CAN_BITS_MAX; }

static void start(can_node *n, int64_t now_ns)
{
    n->state = CAN_FRAME;
    n->is_sender = n->is_overload = n->is_forgiven = n->acks = 0;
    n->drive = 1;
    n->start_ns = now_ns;
    can_reader_start(n);
}

/* Begin to send what is loaded. */
void can_begin(can_node *n, int64_t now_ns)
{
    start(n, now_ns);
    n->is_sender = 1;
    n->place = n->next_place;
    n->sent_bits = 0;
    n->drive = 0;
}

/* Take a dominant bit for a start of frame, and join in with what is loaded, 3.1.5. */
static void hear_start(can_node *n, int64_t now_ns)
{
    int joins = n->next_size && n->state != CAN_SUSPENDED && !n->is_listening;
    start(n, now_ns);
    can_read_bit(n, 0);
    if (!joins) return;
    n->is_sender = 1;
    n->place = n->next_place;
    n->sent_bits = 1;
    n->drive = sent_from(n)[1];
}

void can_sent(can_node *n)
{
    int was_passive = can_is_passive(n);
    if (n->tec) n->tec--; /* 7, rule 7 */
    n->happened |= CAN_SENT;
    if (was_passive != can_is_passive(n)) n->happened |= CAN_CHANGED;
    n->next_size = 0;
    n->drive = 1;
    n->state = CAN_INTERMISSION;
    n->count = 0;
}

/* 7, rule 8: above the limit it goes to a value from 119 to 127. */
void can_good(can_node *n)
{
    int was_passive = can_is_passive(n);
    if (n->rec) n->rec = n->rec >= CAN_PASSIVE ? CAN_PASSIVE - 1 : n->rec - 1;
    if (was_passive != can_is_passive(n)) n->happened |= CAN_CHANGED;
}

/* A bit that the wire has other than the sender; false if it is still in the frame, as one that has lost.
   Arbitration is decided here, by the bits. Where nothing disturbs a frame, undisturbed_sender of can_wire.c decides it
   by numbers; a property test holds both against each other. */
static int step_contradicted(can_node *n)
{
    /* From the identifier to RTR; with SRR and IDE, in which only extended frames are recessive. */
    int is_arbitration = n->at > 0 && n->at <= (n->is_extended ? 32 : 13);
    int is_stuffing = n->run == 5;
    if (n->tail >= 0) {
        can_wrong(n, CAN_FORM_ERROR);
    } else if (!n->drive || !is_arbitration) {
        can_wrong(n, is_stuffing && n->drive ? CAN_STUFF_ERROR : CAN_BIT_ERROR);
    } else if (is_stuffing) { /* 7, rule 3, exception 2 */
        n->is_forgiven = 1;
        can_wrong(n, CAN_STUFF_ERROR);
    } else {
        n->is_sender = 0;
        n->lost++;
        return 0;
    }
    return 1;
}

static void step_crc_delimiter(can_node *n)
{
    n->acks = !n->is_bad && !n->is_listening && !n->is_sender;
    /* The frame is right for it all the same: the bit alone is missing. */
    if (n->acks && n->no_ack_most && can_draw(&n->no_ack_state) <= n->no_ack_most) n->acks = 2;
}

/* False if the node is not in the frame any more. */
static int step_ack(can_node *n, int level)
{
    if (n->is_sender && level) {
        can_wrong(n, CAN_ACK_ERROR);
        return 0;
    }
    if (n->acks == 1 && level) {
        can_wrong(n, CAN_BIT_ERROR);
        return 0;
    }
    if (n->acks) can_good(n);
    return 1;
}

/* The last bit of the end of frame, in which receivers have the frame whatever its level is. */
static void step_last(can_node *n, int level)
{
    if (!n->is_sender) n->happened |= CAN_HEARD;
    if (n->is_sender && level) {
        can_sent(n);
    } else if (n->is_sender) {
        can_wrong(n, CAN_FORM_ERROR);
    } else if (level) {
        n->state = CAN_INTERMISSION;
        n->count = 0;
    } else {
        can_overload(n);
    }
}

/* A bit behind the CRC; false if the node is not in the frame any more. */
static int step_tail(can_node *n, int level)
{
    int tail = n->tail++;
    if (tail == 1) return step_ack(n, level);
    if (tail == 9) {
        step_last(n, level);
        return 0;
    }
    if (!level) {
        can_wrong(n, CAN_FORM_ERROR);
        return 0;
    }
    if (tail == 0) step_crc_delimiter(n);
    /* Wherever it was found: the flag of a CRC error begins behind the ACK delimiter. */
    if (tail == 2 && n->is_bad && !n->is_sender) {
        can_wrong(n, CAN_CRC_ERROR);
        return 0;
    }
    return 1;
}

static void step_frame(can_node *n, int level)
{
    if (n->is_sender) {
        /* In the ACK slot it drives recessive and hopes for the other: step_ack judges that. */
        if (level == n->drive || n->tail == 1) n->sent_bits++;
        else if (step_contradicted(n)) return;
    }
    if (n->tail >= 0) {
        if (!step_tail(n, level)) return;
    } else if (!can_read_bit(n, level)) {
        can_wrong(n, CAN_STUFF_ERROR);
        return;
    }
    if (n->is_sender) n->drive = sent_from(n)[n->sent_bits];
    else n->drive = !(n->tail == 1 && n->acks == 1);
}

static void step_intermission(can_node *n, int level, int64_t now_ns)
{
    int has_to_wait = n->is_sender && can_is_passive(n); /* 3.1.5: eight bits more */
    if (level) {
        if (++n->count < 3) return;
        n->state = has_to_wait ? CAN_SUSPENDED : CAN_IDLE;
        n->count = 0;
        n->is_sender = 0;
    /* 3.1.5: in the third bit it would be a start of frame. */
    } else if (n->count < 2) {
        can_overload(n);
    } else {
        if (has_to_wait) n->state = CAN_SUSPENDED;
        hear_start(n, now_ns);
    }
}

static void step_outside(can_node *n, int level)
{
    if (n->state == CAN_BUS_OFF && !n->recovers) return;
    n->count = level ? n->count + 1 : 0;
    if (n->count < 11) return;
    n->count = 0;
    if (n->state == CAN_BUS_OFF) { /* 7, rule 12 */
        if (++n->sequences < 128) return;
        n->tec = n->rec = n->sequences = 0;
        n->happened |= CAN_CHANGED;
    }
    n->state = CAN_IDLE;
}

/* Take the level of a bit; decide what to drive in the next. */
void can_step(can_node *n, int level, int64_t now_ns)
{
    switch (n->state) {
    case CAN_ABSENT: break;
    case CAN_INTEGRATING:
    case CAN_BUS_OFF: step_outside(n, level); break;
    case CAN_IDLE:
        if (!level) hear_start(n, now_ns);
        break;
    case CAN_FRAME: step_frame(n, level); break;
    case CAN_INTERMISSION: step_intermission(n, level, now_ns); break;
    case CAN_SUSPENDED:
        if (!level) hear_start(n, now_ns);
        else if (++n->count == 8) n->state = CAN_IDLE;
        break;
    default: can_step_error(n, level);
    }
}
