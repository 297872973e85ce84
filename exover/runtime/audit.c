/* audit.c - recorded missions, asked of the checker: what `exover audit` loads. docs/audit.md says what is done.
 *
 * Hosted, unlike exover.c. Everything that was recorded comes as records (docs/audit.md, "Binary missions"), each behind its
 * length; JSON lines are made records by audit_lines.h. What either reader does not read exactly is given back to the caller,
 * who reads it and hands it in as records that are trusted. Numbers are those of the spec; a machine is little-endian.
 */
#include "native_tables.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { ASK, REPORT, OBSERVE, ABORT, ABORT_WAITING, LAUNCHED = 6, KILLED, WAITED, REJECTED, TOLD, TIME,
       /* Of trusted records alone: what could not be read, as far as it matters. */
       BAD_ASK = 16, BAD_LAUNCH, BAD_REPORT, BAD_EVENT, BAD_DEED, BAD_LINE, LOST, VOID };
enum { NOBODY = -1, REFUSED = -2, UNDECIDED = -3 }; /* instead of the slot of an instance */
enum { UNSAID = -1, INVALID = -100 };               /* instead of a reason: none; INVALID - an exover_invalid */
enum { SAY_LAUNCH, SAY_WAIT, SAY_REJECT, SAY_INVALID, SAY_NOTHING };
enum { ROW_ASK, ROW_LAUNCHED, ROW_RAN, ROW_KEPT, ROW_WITHHELD, ROW_STOPPED, ROW_OTHERWISE, ROWS };
enum { DONE, ODD, FULL };
enum { MOST_LINE = 1 << 20, ROOM = 1 << 14, MOST_DEEDS = ROOM / 7 + 1 };

typedef struct name {
    const char *text;
    size_t size;
} name;

typedef struct param { /* also an observable: `number` is that of the poster or the stock */
    name name;
    int32_t kind; /* 0 bool, 1 int, 2 real, 3 enum */
    int64_t low, high;
    double least, most;
    const name *values; /* of an enum: `high` + 1 of them */
    int32_t stock, number;
} param;

typedef struct slot {
    bool active, stopping, pending; /* pending: started while the audit followed */
    int32_t owner;                  /* the instance that it is, NOBODY */
    uint64_t since;                 /* the event of its start */
    uint64_t killed, noted;         /* the last events: in which the robot has stopped it, the tables have */
} slot;

typedef struct request {
    name name;
    int32_t instances, params, results, statuses;
    const param *param, *result;
    const name *status;
    slot *slots;
    int32_t *slot_of; /* by instance */
    uint64_t asked, waited, held, denied; /* events: asked; the robot let it wait; the tables let it wait, rejected it */
    uint64_t denials; /* how often the tables rejected it in the event `denied`, but for those that the robot has also done */
    int32_t answer, reason;                   /* what the tables said to the last ask */
    int32_t waits_for;
    bool open, wanted; /* open: rejected, and no launch has taken that up; wanted: withheld when an event was last told */
} request;

typedef struct row {
    uint64_t line;
    double time;
    int32_t kind, request, slot, answer, rule, launch_rule;
} row;

typedef struct stop {
    int32_t request, slot, reason;
} stop;

typedef struct audit {
    exover checker;
    request *requests;
    param *observables;
    int32_t *slots_of_names; /* a hash table of requests, then of observables, by their names */
    int64_t request_count, observable_count, reason_count, slot_count;
    uint32_t mask;
    name *names;
    char *texts;
    row *rows;
    uint64_t row_count, row_room, rows_left; /* rows_left: so many are wanted still */
    stop *stops; /* by the event that is asked */
    uint64_t stop_count;
    uint64_t *counts; /* events, told, deeds, passed over, undecided, invalid, lost, followed; ROWS of them; asks, uses */
    uint64_t event, line; /* the number of the last event; the line that is read */
    double time;
    int32_t asked;
    bool wants_asks, loose; /* loose: something was started since an event was last told, or was withheld then */
    unsigned char *scratch;
    uint64_t *memory;
    void *arena;
} audit;

enum { EVENTS, TOLD_EVENTS, DEEDS, PASSED, UNDECIDED_LAUNCHES, INVALID_EVENTS, LOST_LINES, FOLLOWED, FIGURES };

/* ---- what is told ---- */

static void tell(audit *a, int kind, int32_t number, int32_t instance, int32_t answer, int32_t rule, int32_t launch_rule)
{
    a->counts[FIGURES + kind]++;
    if ((kind != ROW_ASK || a->wants_asks) && a->rows_left != 0 && a->row_count < a->row_room) {
        a->rows_left--;
        a->rows[a->row_count++] = (row){a->line, a->time, kind, number, instance, answer, rule, launch_rule};
    }
}

static void use(audit *a, int32_t reason)
{
    if (reason >= 0)
        a->counts[FIGURES + ROWS + 4 * a->request_count + reason]++;
}

/* ---- the tables ---- */

/* Take in the answers to what is asked; `counted`: it was recorded, and is not the audit's own. */
static void take(audit *a, size_t count, bool counted)
{
    for (size_t i = 0; i < count; i++) {
        const exover_action *said = &a->checker.actions[i];
        const int32_t reason = (int32_t)said->reason;
        if (counted) {
            use(a, reason == said->launch_rule || said->kind == EXOVER_INVALID ? UNSAID : reason);
            use(a, (int32_t)said->launch_rule);
        }
        if (said->kind == EXOVER_INVALID) {
            a->counts[INVALID_EVENTS]++;
            continue;
        }
        if (said->request < 0)
            continue;
        request *r = &a->requests[said->request];
        slot *s = said->slot < 0 ? NULL : &r->slots[said->slot];
        if (said->kind == EXOVER_LAUNCH) {
            *s = (slot){true, false, !counted, NOBODY, a->event, s->killed, s->noted};
            a->loose = true;
        }
        else if (said->kind == EXOVER_WAIT) {
            r->waits_for = reason;
            r->held = a->event;
        }
        else if (said->kind == EXOVER_REJECT && counted) {
            r->denials = 1 + (r->denied == a->event ? r->denials : 0);
            r->denied = a->event;
        }
        else if (said->kind == EXOVER_KILL) {
            s->stopping = true;
            if (counted && (reason >= 0 || reason == EXOVER_ABORTED) && s->noted != a->event) {
                s->noted = a->event;
                a->stops[a->stop_count++] = (stop){(int32_t)said->request, (int32_t)said->slot, reason};
            }
        }
    }
}

static bool waits(audit *a, int32_t r)
{
    const exover_phase phase = exover_place(&a->checker, r).phase;
    return phase == EXOVER_WAITING || phase == EXOVER_CLEARING;
}

static void idle(slot *s)
{
    s->active = s->stopping = s->pending = false;
    s->owner = NOBODY;
}

static void end(audit *a, int32_t r, int32_t s, enum exover_outcome outcome)
{
    a->counts[FOLLOWED]++;
    idle(&a->requests[r].slots[s]);
    take(a, exover_report(&a->checker, r, s, outcome, -1, NULL, 0), false);
}

static void give_up_waiting(audit *a, int32_t r)
{
    if (waits(a, r)) {
        a->counts[FOLLOWED]++;
        take(a, exover_abort_waiting(&a->checker, r), false);
    }
}

/* What the tables say to an ask in the end: the first action about it, and if it waits, what becomes of that at once. */
static void judge(audit *a, int32_t number, size_t count)
{
    request *r = &a->requests[number];
    r->answer = SAY_REJECT; /* what a faulty checker says, whatever it says */
    r->reason = UNSAID;
    for (size_t i = 0; i < count; i++) {
        const exover_action *said = &a->checker.actions[i];
        const int32_t reason = (int32_t)said->reason;
        if (said->request != number || said->launch_rule != UNSAID || said->kind == EXOVER_KILL
            || (said->kind == EXOVER_REJECT && reason == EXOVER_SUPERSEDED))
            continue;
        r->answer = said->kind == EXOVER_LAUNCH ? SAY_LAUNCH : said->kind == EXOVER_WAIT ? SAY_WAIT : SAY_REJECT;
        r->reason = reason;
        if (r->answer != SAY_WAIT)
            break;
    }
}

static void ask(audit *a, int32_t number, const exover_value *args)
{
    request *r = &a->requests[number];
    const size_t count = exover_ask(&a->checker, number, args, (size_t)r->params);
    judge(a, number, count);
    take(a, count, true);
}

static void refuse_ask(audit *a, int32_t number, int32_t code)
{
    request *r = &a->requests[number];
    r->answer = SAY_INVALID;
    r->reason = INVALID - code;
    a->counts[INVALID_EVENTS]++;
}

/* ---- which slot is meant ---- */

/* A slot that the tables have started and that is nobody's instance: that of the number, else the lowest; NOBODY. */
static int32_t unclaimed(const request *r, int32_t instance)
{
    if (r->slots[instance].active && r->slots[instance].owner == NOBODY)
        return instance;
    for (int32_t s = 0; s < r->instances; s++) {
        if (r->slots[s].active && r->slots[s].owner == NOBODY)
            return s;
    }
    return NOBODY;
}

static int32_t meant(const request *r, int32_t instance)
{
    return r->slot_of[instance] == NOBODY ? unclaimed(r, instance) : r->slot_of[instance];
}

/* ---- events ---- */

/* End the last event: what follows is not about it. */
static void forget(audit *a)
{
    a->event++;
    a->stop_count = 0;
    a->asked = NOBODY;
}

static void begin(audit *a)
{
    a->counts[EVENTS]++;
    forget(a);
}

static void asked(audit *a, int32_t number)
{
    request *r = &a->requests[number];
    a->asked = number;
    r->asked = a->event;
    r->open = r->answer == SAY_REJECT || r->answer == SAY_INVALID;
    a->counts[FIGURES + ROWS + 4 * number + (r->answer)]++;
    tell(a, ROW_ASK, number, NOBODY, r->answer, r->reason, UNSAID);
}

/* The slot of a report, whose instance has ended; NOBODY if there is none, which is told. */
static int32_t ending(audit *a, int32_t number, int32_t instance)
{
    request *r = &a->requests[number];
    const int32_t s = meant(r, instance);
    r->slot_of[instance] = NOBODY;
    if (s >= 0) {
        idle(&r->slots[s]);
        return s;
    }
    a->counts[PASSED]++;
    if (s == NOBODY) {
        const bool waiting = waits(a, number);
        const int32_t answer = waiting ? SAY_WAIT : r->open ? r->answer : SAY_NOTHING;
        tell(a, ROW_RAN, number, instance, answer, waiting ? r->waits_for : r->open ? r->reason : UNSAID, UNSAID);
        r->open = false;
        give_up_waiting(a, number);
    }
    return NOBODY;
}

static void stop_slot(audit *a, int32_t number, int32_t instance)
{
    const int32_t s = meant(&a->requests[number], instance);
    if (s < NOBODY)
        a->counts[PASSED]++;
    else
        take(a, exover_abort(&a->checker, number, s == NOBODY ? instance : s), true);
}

/* ---- deeds ---- */

static bool same_args(audit *a, int32_t number, int32_t s, const exover_value *args)
{
    const request *r = &a->requests[number];
    const exover_value *own = args == NULL ? NULL : exover_args(&a->checker, number, s);
    for (int32_t k = 0; own != NULL && k < r->params; k++) {
        if (own[k].bits != args[k].bits)
            return false;
    }
    return true;
}

static bool claim(audit *a, int32_t number, int32_t instance, const exover_value *args)
{
    request *r = &a->requests[number];
    for (int32_t s = 0; s < r->instances; s++) {
        if (r->slots[s].active && r->slots[s].owner == NOBODY && same_args(a, number, s, args)) {
            r->slots[s].owner = instance;
            r->slot_of[instance] = s;
            return true;
        }
    }
    return false;
}

static void refuse_launch(audit *a, int32_t number, int32_t instance, int32_t answer, int32_t reason)
{
    request *r = &a->requests[number];
    tell(a, ROW_LAUNCHED, number, instance, answer, reason, UNSAID);
    r->slot_of[instance] = REFUSED;
    r->open = false;
    give_up_waiting(a, number);
}

static void vacate(audit *a, int32_t number, int32_t instance)
{
    request *r = &a->requests[number];
    const int32_t s = r->slot_of[instance];
    r->slot_of[instance] = NOBODY;
    if (s >= 0)
        end(a, number, s, EXOVER_INTERRUPTED);
}

static void launched(audit *a, int32_t number, int32_t instance, const exover_value *args)
{
    request *r = &a->requests[number];
    vacate(a, number, instance);
    if (claim(a, number, instance, args))
        return;
    if (waits(a, number)) {
        refuse_launch(a, number, instance, SAY_WAIT, r->waits_for);
    } else if (r->open) {
        refuse_launch(a, number, instance, r->answer, r->reason);
    } else if (args == NULL && r->params != 0) {
        a->counts[UNDECIDED_LAUNCHES]++;
        r->slot_of[instance] = UNDECIDED;
    } else {
        ask(a, number, args);
        if (!claim(a, number, instance, args))
            refuse_launch(a, number, instance, r->answer, r->reason);
    }
}

static void stopped(audit *a, int32_t number, int32_t instance)
{
    request *r = &a->requests[number];
    const int32_t s = meant(r, instance);
    if (s < 0) {
        a->counts[PASSED]++;
        return;
    }
    if (!r->slots[s].stopping) {
        tell(a, ROW_STOPPED, number, instance, SAY_NOTHING, UNSAID, UNSAID);
        a->counts[FOLLOWED]++;
        take(a, exover_abort(&a->checker, number, s), false);
    }
    r->slots[s].killed = a->event;
}

static void waited(audit *a, int32_t number)
{
    request *r = &a->requests[number];
    r->waited = a->event;
    if (r->asked == a->event && r->open && r->held != a->event) {
        tell(a, ROW_OTHERWISE, number, NOBODY, r->answer, r->reason, UNSAID);
        r->open = false;
    }
}

static void rejected(audit *a, int32_t number)
{
    request *r = &a->requests[number];
    r->open = false;
    if (r->denied == a->event && r->denials)
        r->denials--;
    else if (waits(a, number)) {
        tell(a, ROW_OTHERWISE, number, NOBODY, SAY_WAIT, r->waits_for, UNSAID);
        give_up_waiting(a, number);
    }
}

/* What the tables have started, in the event that is told or since, and the robot has not. */
static bool is_withheld(const audit *a, const slot *s)
{
    return s->active && s->owner == NOBODY && (s->pending || s->since == a->event);
}

static void told(audit *a)
{
    a->counts[TOLD_EVENTS]++;
    for (uint64_t i = 0; i < a->stop_count; i++) {
        const stop *each = &a->stops[i];
        slot *s = &a->requests[each->request].slots[each->slot];
        s->noted = 0;
        if (s->stopping && s->owner != NOBODY && s->killed != a->event)
            tell(a, ROW_KEPT, each->request, s->owner, SAY_NOTHING, each->reason, UNSAID);
    }
    a->stop_count = 0;
    if (a->asked != NOBODY) {
        request *r = &a->requests[a->asked];
        if (r->open && r->waited == a->event)
            tell(a, ROW_OTHERWISE, a->asked, NOBODY, r->answer, r->reason, UNSAID);
        r->open = false;
    }
    if (!a->loose)
        return;
    a->loose = false;
    stop *ends = a->stops; /* there is room for every slot */
    uint64_t count = 0;
    for (int32_t number = 0; number < a->request_count; number++) {
        request *r = &a->requests[number];
        const uint64_t before = count;
        for (int32_t s = 0; s < r->instances; s++) {
            if (is_withheld(a, &r->slots[s]))
                ends[count++] = (stop){number, s, UNSAID};
        }
        if (count > before && !r->wanted)
            tell(a, ROW_WITHHELD, number, NOBODY, SAY_LAUNCH, UNSAID, UNSAID);
        r->wanted = count > before;
        a->loose = a->loose || r->wanted;
    }
    for (uint64_t i = 0; i < count; i++) {
        const slot *s = &a->requests[ends[i].request].slots[ends[i].slot];
        if (s->active && s->owner == NOBODY)
            end(a, ends[i].request, ends[i].slot, EXOVER_INTERRUPTED);
    }
}

/* ---- records ---- */

static uint32_t two(const unsigned char *at)
{
    return (uint32_t)at[0] | (uint32_t)at[1] << 8;
}

/* Do what a record says that is known to be one. */
static void apply(audit *a, const unsigned char *at)
{
    const int kind = at[0];
    const int32_t number = (int32_t)two(at + 1);
    const int32_t instance = kind == LAUNCHED || kind == KILLED || kind == REPORT || kind == ABORT || kind >= BAD_ASK ? (int32_t)two(at + 3) : 0;
    exover_value values[256];
    request *r = &a->requests[kind == OBSERVE || kind >= TOLD ? 0 : number];
    a->counts[DEEDS] += kind >= LAUNCHED && kind <= REJECTED;
    switch (kind) {
    case ASK:
        begin(a);
        memcpy(values, at + 3, 8 * (size_t)r->params);
        ask(a, number, values);
        asked(a, number);
        break;
    case REPORT: {
        begin(a);
        const int outcome = at[5];
        const int32_t s = ending(a, number, instance);
        const int32_t status = two(at + 6) == 0xffff ? -1 : (int32_t)two(at + 6);
        const size_t count = outcome == 0 ? (size_t)r->results : 0;
        memcpy(values, at + 8, 8 * count);
        if (s != NOBODY)
            take(a, exover_report(&a->checker, number, s, (enum exover_outcome)(outcome + 1), status, values, count), true);
        break;
    }
    case OBSERVE: {
        begin(a);
        const param *o = &a->observables[number];
        memcpy(values, at + 3, 8);
        take(a, o->stock ? exover_level(&a->checker, o->number, values[0].integer) : exover_observe(&a->checker, o->number, values[0]), true);
        break;
    }
    case ABORT:
        begin(a);
        stop_slot(a, number, instance);
        break;
    case ABORT_WAITING:
        begin(a);
        if (waits(a, number))
            take(a, exover_abort_waiting(&a->checker, number), true);
        else
            a->counts[PASSED]++;
        break;
    case LAUNCHED:
        memcpy(values, at + 6, at[5] ? 8 * (size_t)r->params : 0);
        launched(a, number, instance, at[5] || r->params == 0 ? values : NULL);
        break;
    case KILLED: stopped(a, number, instance); break;
    case WAITED: waited(a, number); break;
    case REJECTED: rejected(a, number); break;
    case TOLD: told(a); break;
    case TIME: memcpy(&a->time, at + 1, 8); break;
    case BAD_ASK:
        begin(a);
        refuse_ask(a, number, at[5]);
        asked(a, number);
        break;
    case BAD_LAUNCH:
        a->counts[DEEDS]++;
        r = &a->requests[number];
        if (instance < r->instances) {
            vacate(a, number, instance);
            refuse_launch(a, number, instance, SAY_INVALID, INVALID - at[5]);
        } else {
            tell(a, ROW_LAUNCHED, number, instance, SAY_INVALID, INVALID - at[5], UNSAID);
        }
        break;
    case BAD_REPORT: {
        begin(a);
        a->counts[INVALID_EVENTS]++;
        const int32_t s = ending(a, number, instance);
        if (s != NOBODY)
            end(a, number, s, EXOVER_FAILED);
        break;
    }
    case BAD_EVENT:
        begin(a);
        a->counts[INVALID_EVENTS]++;
        break;
    case BAD_DEED:
        a->counts[DEEDS]++;
        forget(a);
        break;
    case BAD_LINE: forget(a); break;
    case VOID:
        begin(a);
        a->counts[PASSED]++;
        break;
    case LOST: {
        uint64_t lost;
        memcpy(&lost, at + 1, 8);
        a->counts[LOST_LINES] += lost;
        break;
    }
    default: break;
    }
}

/* Whether a reading is of the type of its observable; one out of range is answered so by the checker itself. */
static bool is_reading(const param *p, const unsigned char *at, size_t size)
{
    return size >= 8 && (p->kind != 0 || (at[0] < 2 && memcmp(at + 1, "\0\0\0\0\0\0", 7) == 0));
}

static bool in_domain(const param *p, const unsigned char *at)
{
    exover_value value;
    memcpy(&value, at, 8);
    if (p->kind == 2) /* -0.0 is read as 0, by the other reader */
        return value.real >= p->least && value.real <= p->most && isfinite(value.real) && value.bits != UINT64_C(1) << 63;
    return value.integer >= p->low && value.integer <= p->high;
}

static bool all_in_domain(const param *p, int32_t count, const unsigned char *at, size_t size)
{
    if (size < 8 * (size_t)count)
        return false;
    for (int32_t k = 0; k < count; k++) {
        if (!in_domain(&p[k], at + 8 * k))
            return false;
    }
    return true;
}

static bool is_time(const unsigned char *at)
{
    double time;
    memcpy(&time, at, 8);
    return !isinf(time); /* NaN: it is not known */
}

/* Whether a record of a file is one exactly. */
static bool is_exact(const audit *a, const unsigned char *at, size_t size)
{
    if (size == 0)
        return false;
    if (at[0] == TOLD)
        return true;
    if (at[0] == TIME)
        return size >= 9 && is_time(at + 1);
    if (size < 3)
        return false;
    const uint32_t number = two(at + 1);
    if (at[0] == OBSERVE)
        return number < a->observable_count && is_reading(&a->observables[number], at + 3, size - 3);
    if (number >= a->request_count)
        return false;
    const request *r = &a->requests[number];
    switch (at[0]) {
    case ASK: return all_in_domain(r->param, r->params, at + 3, size - 3);
    case REPORT:
        if (size < 8 || two(at + 3) >= (uint32_t)r->instances || at[5] > 2)
            return false;
        if (at[5] == 0)
            return all_in_domain(r->result, r->results, at + 8, size - 8);
        return at[5] == 2 || two(at + 6) == 0xffff || two(at + 6) < (uint32_t)r->statuses;
    case ABORT:
    case KILLED: return size >= 5 && two(at + 3) < (uint32_t)r->instances;
    case ABORT_WAITING:
    case WAITED:
    case REJECTED: return true;
    case LAUNCHED:
        return size >= 6 && two(at + 3) < (uint32_t)r->instances && at[5] <= 1
               && (!at[5] || all_in_domain(r->param, r->params, at + 6, size - 6));
    default: return false;
    }
}

static size_t length_at(const unsigned char *at)
{
    return (size_t)two(at) | (size_t)two(at + 2) << 16;
}

static bool has_room(const audit *a)
{
    return a->row_room - a->row_count > (uint64_t)(MOST_DEEDS + a->slot_count + a->request_count);
}

/* Take records as far as they are whole. `trusted`: they are of `a->line`, and none is odd. Returns DONE, ODD or FULL; `used` are
 * the bytes that were taken. */
int audit_records(audit *a, const unsigned char *data, size_t size, int trusted, size_t *used)
{
    size_t at = 0;
    int outcome = DONE;
    while (size - at >= 4) {
        const size_t length = length_at(data + at);
        if (length > size - at - 4)
            break;
        if (!trusted && !has_room(a)) {
            outcome = FULL;
            break;
        }
        if (!trusted && !is_exact(a, data + at + 4, length)) {
            outcome = ODD;
            break;
        }
        a->line += !trusted;
        apply(a, data + at + 4);
        at += 4 + length;
    }
    *used = at;
    return outcome;
}

#include "audit_lines.h"

/* Take the lines that are whole; the last may lack its end if it is the `last` piece. Returns and `used` as for records. A report
 * or an abort without actions is taken when the line behind it is there, which may say that it was none. */
int audit_lines(audit *a, const char *data, size_t size, int last, size_t *used)
{
    size_t at = 0, taken;
    while (at < size) {
        const char *newline = memchr(data + at, '\n', size - at);
        if (newline == NULL && !last)
            break;
        *used = at;
        if (!has_room(a))
            return FULL;
        const size_t length = newline == NULL ? size - at : (size_t)(newline - data) - at;
        long bytes = length >= MOST_LINE ? -1 : audit_line(a, data + at, length, a->scratch, ROOM);
        if (bytes < 0)
            return ODD;
        if (is_bare_end(a->scratch, bytes)) {
            const size_t next = at + length + (newline != NULL);
            const int answer = answer_behind(data + next, size - next, last != 0);
            if (answer < 0)
                return answer == CUT ? DONE : ODD;
            bytes = answer ? make_void(a->scratch) : bytes;
        }
        a->line++;
        (void)audit_records(a, a->scratch, (size_t)bytes, 1, &taken);
        at += length + (newline != NULL);
    }
    *used = at;
    return DONE;
}

/* ---- its beginning and its end ---- */

void audit_free(audit *a)
{
    if (a != NULL) {
        free(a->arena);
        free(a);
    }
}

static void *part(char **at, size_t count, size_t size)
{
    void *found = *at;
    *at += (count * size + 15) & ~(size_t)15;
    return found;
}

static const int64_t *describe(audit *a, param *p, const int64_t *meta)
{
    p->name = a->names[meta[0]];
    p->kind = (int32_t)meta[1];
    p->low = meta[2];
    p->high = meta[3];
    memcpy(&p->least, &meta[2], 8);
    memcpy(&p->most, &meta[3], 8);
    p->values = a->names + meta[4];
    p->stock = (int32_t)meta[5];
    p->number = (int32_t)meta[6];
    return meta + 7;
}

/* Start a mission: the tables in their initial state, nothing counted. At most so many rows are told of it, asks among them only
 * if they are wanted. Returns an exover_status. */
int audit_start(audit *a, int wants_asks, uint64_t rows)
{
    a->rows_left = rows;
    memset(a->counts, 0, (size_t)(FIGURES + ROWS + 4 * a->request_count + a->reason_count) * sizeof *a->counts);
    a->row_count = a->stop_count = a->event = a->line = 0;
    a->time = NAN;
    a->asked = NOBODY;
    a->wants_asks = wants_asks != 0;
    a->loose = false;
    for (int32_t number = 0; number < a->request_count; number++) {
        request *r = &a->requests[number];
        r->asked = r->waited = r->held = r->denied = r->denials = 0;
        r->answer = SAY_NOTHING;
        r->reason = r->waits_for = UNSAID;
        r->open = r->wanted = false;
        for (int32_t s = 0; s < r->instances; s++) {
            r->slots[s] = (slot){.owner = NOBODY};
            r->slot_of[s] = NOBODY;
        }
    }
    return (int)exover_load_stopped(&a->checker, &native_tables, a->memory, NATIVE_MEMORY_BYTES);
}

/* An audit; NULL if there is no memory. `meta` holds the counts of requests, observables, reasons, slots, parameters and names,
 * then what they are; `texts` are the names, whose ends stand in `ends`. */
audit *audit_new(const int64_t *meta, const char *texts, const int64_t *ends)
{
    audit *a = calloc(1, sizeof *a);
    if (a == NULL)
        return NULL;
    const int64_t params = meta[4], names = meta[5];
    a->request_count = meta[0], a->observable_count = meta[1], a->reason_count = meta[2], a->slot_count = meta[3];
    for (a->mask = 15; a->mask < 4 * (uint64_t)(meta[0] + meta[1]); a->mask = 2 * a->mask + 1)
        ;
    a->row_room = (uint64_t)(4 * (MOST_DEEDS + a->slot_count + a->request_count));
    const size_t counts = (size_t)(FIGURES + ROWS + 4 * meta[0] + meta[2]), bytes = names == 0 ? 0 : (size_t)ends[names - 1];
    char *at = calloc(1, ((size_t)meta[0] + 1) * sizeof(request) + (size_t)(params + meta[1]) * sizeof(param)
                             + 2 * ((size_t)a->mask + 1) * sizeof(int32_t) + (size_t)names * sizeof(name) + bytes
                             + a->row_room * sizeof(row) + 2 * ((size_t)meta[3] + 1) * sizeof(stop) + counts * 8 + ROOM
                             + NATIVE_MEMORY_BYTES + 16 + (size_t)meta[3] * (sizeof(slot) + 4)
                             + (2 * (size_t)meta[0] + 16) * 16);
    a->arena = at;
    if (at == NULL) {
        audit_free(a);
        return NULL;
    }
    a->memory = part(&at, NATIVE_MEMORY_BYTES / 8 + 1, 8);
    a->requests = part(&at, (size_t)meta[0] + 1, sizeof(request));
    param *next = part(&at, (size_t)params, sizeof(param));
    a->observables = part(&at, (size_t)meta[1], sizeof(param));
    a->slots_of_names = part(&at, 2 * ((size_t)a->mask + 1), sizeof(int32_t));
    a->names = part(&at, (size_t)names, sizeof(name));
    a->texts = part(&at, bytes, 1);
    a->rows = part(&at, a->row_room, sizeof(row));
    a->stops = part(&at, 2 * ((size_t)meta[3] + 1), sizeof(stop));
    a->counts = part(&at, counts, 8);
    a->scratch = part(&at, ROOM, 1);
    memcpy(a->texts, texts, bytes);
    for (int64_t i = 0; i < names; i++)
        a->names[i] = (name){a->texts + (i ? ends[i - 1] : 0), (size_t)(ends[i] - (i ? ends[i - 1] : 0))};
    const int64_t *from = meta + 6;
    for (int32_t i = 0; i < a->request_count; i++) {
        request *r = &a->requests[i];
        r->name = a->names[from[0]];
        r->instances = (int32_t)from[1], r->params = (int32_t)from[2], r->results = (int32_t)from[3];
        r->statuses = (int32_t)from[4];
        r->status = a->names + from[5];
        r->slots = part(&at, (size_t)r->instances, sizeof(slot));
        r->slot_of = part(&at, (size_t)r->instances, sizeof(int32_t));
        from += 6;
        r->param = next;
        for (int32_t k = 0; k < r->params; k++)
            from = describe(a, next++, from);
        r->result = next;
        for (int32_t k = 0; k < r->results; k++)
            from = describe(a, next++, from);
        enter(a, r->name, i, false);
    }
    for (int32_t i = 0; i < a->observable_count; i++) {
        from = describe(a, &a->observables[i], from);
        enter(a, a->observables[i].name, i, true);
    }
    return a;
}

uint64_t *audit_counts(audit *a)
{
    return a->counts;
}

row *audit_rows(audit *a)
{
    return a->rows;
}

/* How many rows there are; they are taken away. */
uint64_t audit_taken(audit *a)
{
    const uint64_t count = a->row_count;
    a->row_count = 0;
    return count;
}

/* The line that is read next is this one; the records that follow are of it. */
void audit_at(audit *a, uint64_t line)
{
    a->line = line;
}

uint64_t audit_place(const audit *a)
{
    return a->line;
}

int audit_fault(const audit *a)
{
    return (int)exover_fault(&a->checker);
}
