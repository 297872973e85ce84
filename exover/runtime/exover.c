/* exover.c - see exover.h. What a step means is docs/language.md section 4; what the tables say is docs/runtime.md. */
#include "exover.h"

#ifdef EXOVER_DEBUG
#include <assert.h>
#endif

/* MISRA C:2012, as far as the addon of cppcheck looks; it claims no conformance. What is not kept is explained where it
 * stands; but for what stands in many places:
 *
 *   2.4 2.5  tags and macros that one build or another does not use; enums without a tag, of constants that belong together
 *   10.4 10.8  words of the tables are signed, sizes and bits are not; -Wconversion watches over the rest
 *   11.5 18.4  records, cells and lists stand in memory that is given as one: they are found there by their number
 *   12.1 12.3  C's own precedence; several declarators
 *   14.2 17.8  a loop counts in a parameter, or goes through two arrays at once
 *   15.5  returns where all is known
 *   19.2  a value is a double or an integer, as its type in the tables says
 */

#define NONE (-1)   /* no entry, no slot, no argument; as a node, the end of a path */
#define ALWAYS (-2) /* as a predicate: true of all arguments */
#define MOST_SLOTS 0x1000000

/* Sections of the tables, then what else a field can count. */
enum {
    NODES, ENTRIES, REQUESTS, PARAMS, ORDERS, FEATURES, PASTS, AMOUNTS, EFFECTS, VARIABLES, LATCHES, STOCKS, RULES,
    LAUNCHES, LIMITS, CONFLICTS, REASONS, INVARIANTS, SUMS, LISTS, REALS, CHECKS, WAITS, KILLS, LASTS,
    FLAG, TYPE, ROLE, DENIALS, BLOCKS, NATURAL, ANY
};
enum { REJECT = 1, WAIT, CLEAR, SETTLE, KILL, DISMISS, LAUNCH, VIOLATION, AGREE }; /* actions of nodes */
enum { REAL = 3 };                                                                  /* of types */
enum { POSTER = 0 };                                                                /* of roles */
enum { SET = 0 };                                                                   /* of effects */
enum { CLEARINGS = 1, ALL_DENIALS = 2 };                                            /* of reasons */
/* What a slot (the first three) or a waiting place holds; less one, the entry of a feature. In its cell stands SINCE times
 * the number of the step that put it there above that. */
enum { EMPTY, RUNNING, STOPPING, WAITING, CLEARING, SINCE = 8 };
/* The agenda, what the end of a step has to look at: rules, broken rules, marks of this step, launch rules, a fault, of
 * which all that waits was told; whether this step has touched what decisions read, and whether the last has left marks, since
 * else nothing is decided otherwise than by the last; and how many waiting places are taken, times `PLACE`. */
enum {
    DIRTY = 1, BROKEN = 2, MARKED = 4, REQUIRED = 8, FAULTY = 16, TOLD = 32, TOUCHED = 64, UNSETTLED = 128, PLACE = 256
};
#define EXOVER_IS_LIVE 0x11fe11feu /* of a checker that was loaded */
#define ENTERED 0x5ac3a53cu /* the guard while a step runs: no agenda, and no complement of one */

/* The layout of the tables relies on this: records are arrays of words, doubles have 64 bits. */
/* cppcheck-suppress misra-c2012-2.3 ; it only asserts */
typedef char records_are_packed[sizeof(exover_request) == 26 * sizeof(exover_word)
                                && sizeof(exover_variable) == 16 * sizeof(exover_word)
                                && sizeof(exover_feature) == 7 * sizeof(exover_word) ? 1 : -1];
/* cppcheck-suppress misra-c2012-2.3 ; it only asserts */
typedef char doubles_have_64_bits[sizeof(double) == 8 && sizeof(exover_value) == 8 ? 1 : -1];
/* cppcheck-suppress misra-c2012-2.3 ; it only asserts */
typedef char states_hold_words[EXOVER_STATE >= EXOVER_WIDTH ? 1 : -1];

/* Whether there can be records of a section; if not, the compiler drops what follows. */
#define USES(section) (((uint32_t)(EXOVER_USES) >> (uint32_t)(section) & 1u) != 0u)

/* What every step does, but once, stands in one place. */
#ifdef __GNUC__
#define ONCE __attribute__((noinline))
#else
#define ONCE
#endif
/* What few steps do is small before it is fast. */
#ifdef __GNUC__
#define SELDOM __attribute__((noinline, cold))
#define SMALL __attribute__((cold))
#else
#define SELDOM
#define SMALL
#endif
/* What stands before it is done before what stands behind it, also for whom this step is interrupted by. */
#ifdef __GNUC__
#define IN_ORDER() __asm__ volatile("" ::: "memory")
#else
#define IN_ORDER() ((void)0)
#endif
/* Where speed counts more than size, what every step does many times is not called; where size does, what is used in
 * several places stands in one. */
#if defined(__GNUC__) && defined(__OPTIMIZE__) && !defined(__OPTIMIZE_SIZE__)
#define FAST 1
#define OFTEN inline __attribute__((always_inline))
#define SHARED OFTEN
#elif defined(__GNUC__)
#define FAST 0
#define OFTEN
#define SHARED __attribute__((noinline))
#else
#define FAST 0
#define OFTEN
#define SHARED
#endif

/* The shape of tables and memory, known when this is compiled or found when the tables are loaded; `c` is the checker. */
#ifdef EXOVER_SHAPE
static const uint32_t SHAPE_OF_ALL[EXOVER_SHAPE_SIZE] = {EXOVER_SHAPE};
#define SHAPE(number) SHAPE_OF_ALL[number]
#else
#define SHAPE(number) c->shape[number]
#endif
#define COUNT(section) ((exover_int)SHAPE(EXOVER_COUNTS + (section)))

/* Whether every request is known to have one slot: there are as many slots and waiting places as twice the requests. */
#ifdef EXOVER_SHAPE
#define SINGLE (SHAPE(EXOVER_HELD) - SHAPE(EXOVER_PHASES) == 2 * SHAPE(EXOVER_COUNTS + REQUESTS))
#else
#define SINGLE false
#endif

/* Record `index` of a section, and the list of numbers. */
/* cppcheck-suppress misra-c2012-20.10 ; the name of a record gives the name of its type */
#define WORDS_OF(type) (sizeof(exover_##type) / sizeof(exover_word))
/* cppcheck-suppress [misra-c2012-20.10, misra-c2012-20.12] ; the name of a record gives the name of its type, and is no macro */
#define RECORD(type, section, index) \
    ((const exover_##type *)record(c, FIRST(section), CHECK(section), COUNT(section), WORDS_OF(type), (exover_int)(index)))
#define FIRST(section) (c->words + SHAPE(EXOVER_STARTS + (section)))
#define CHECK(section) (c->words + SHAPE(EXOVER_CHECKS + (section)))
/* cppcheck-suppress misra-c2012-20.10 ; the name of a record gives the name of its type */
#define ALL(type, section) ((const exover_##type *)(const void *)(c->words + SHAPE(EXOVER_STARTS + (section))))
#define REQUEST(index) RECORD(request, REQUESTS, index)
#define LIST (c->words + SHAPE(EXOVER_STARTS + LISTS))

/* In a debug build what an event costs is counted, and held against what exover_config.h says of these tables. */
#ifdef EXOVER_DEBUG
#ifndef EXOVER_TESTS
#define EXOVER_TESTS UINT32_MAX
#define EXOVER_ACTIONS UINT32_MAX
#define EXOVER_PASSES UINT32_MAX
#endif
#define SPEND(count) ((void)(++(count)))
#else
#define SPEND(count) ((void)0)
#endif

/* Sums of numbers that are not believed yet: nothing overflows. */
static OFTEN exover_int plus(exover_int left, exover_int right)
{
    const exover_uint sum = (exover_uint)left + (exover_uint)right;
    return (exover_int)sum;
}

static OFTEN exover_int minus(exover_int left, exover_int right)
{
    const exover_uint difference = (exover_uint)left - (exover_uint)right;
    return (exover_int)difference;
}

/* Volatile, since compilers make a call of the C library of a plain loop. */
static SELDOM void wipe(void *memory, size_t size)
{
    /* cppcheck-suppress misra-c2012-11.5 ; any memory is bytes */
    volatile unsigned char *bytes = (volatile unsigned char *)memory;
    for (size_t i = 0; i < size; i++) {
        bytes[i] = 0;
    }
}

/* ---- faults ---- */

/* Between two steps a checker is sound iff its guard is the complement of its agenda and its fault is none; for that, no
 * bit of either may change alone. No single bit makes a faulty one sound. While a step runs its guard is ENTERED, and a
 * call that finds that has interrupted the step: it denies, and leaves nothing behind but the fault. */
static SELDOM void fault(exover *c, exover_status cause)
{
    if (c->fault == EXOVER_READY) {
        c->fault = cause;
    }
    if ((c->agenda & FAULTY) == 0u) {
        c->agenda = (c->agenda & ~(uint32_t)TOLD) | FAULTY;
    }
    if (c->guard != ENTERED) {
        c->guard = c->agenda; /* else at the end of the step */
    }
}

/* ---- the tables: no index is believed, since a bit may have changed after loading ---- */

/* Whether records have check words: a record and its check word, added without carry, are all ones, and so any one bit
 * that has changed is found. */
static OFTEN bool is_checked(const exover *c)
{
    (void)c;
    return USES(CHECKS) && SHAPE(EXOVER_WORDS) != SHAPE(EXOVER_STARTS + EXOVER_SECTIONS);
}

/* All words of a record, and its check word, added without carry. */
#if defined(__GNUC__) && !defined(__clang__)
#define UNROLLED _Pragma("GCC unroll 8")
#else
#define UNROLLED
#endif
static OFTEN exover_word sum_of_words(const exover_word *word, size_t words, exover_word check)
{
    exover_word sum = check;
    UNROLLED
    for (size_t i = 0; i < words; i++) {
        sum = (exover_word)(sum ^ word[i]);
    }
    return sum;
}

/* Whether record `index` of those from `first` on, of so many words, is what was emitted. */
static SHARED bool holds(exover *c, const exover_word *first, const exover_word *checks, size_t words, exover_int index)
{
    if (is_checked(c) && sum_of_words(&first[words * (size_t)index], words, checks[index]) != -1) {
        fault(c, EXOVER_FAULT_TABLES);
        return false;
    }
    return true;
}

static SHARED const void *record(exover *c, const exover_word *first, const exover_word *checks, exover_int count, size_t words,
                                 exover_int index)
{
    static const exover_word nothing[26] = {NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE,
                                            NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE};
    if ((exover_uint)index >= (exover_uint)count) {
        fault(c, EXOVER_FAULT_INDEX);
    } else if (holds(c, first, checks, words, index)) {
        return &first[words * (size_t)index];
    } else {
        /* it is none */
    }
    return nothing;
}

/* A double of the tables; 0 if it is not what was emitted. */
static exover_value real_at(exover *c, exover_int index)
{
    exover_value value = {0};
    if ((exover_uint)index >= (exover_uint)COUNT(REALS)) {
        fault(c, EXOVER_FAULT_INDEX);
        return value;
    }
    value = c->reals[index];
    if (is_checked(c)) {
        uint64_t sum = (uint64_t)c->words[SHAPE(EXOVER_CHECKS + REALS) + (size_t)index];
        for (unsigned bit = 0; bit < 64u; bit += 8u * (unsigned)sizeof(exover_word)) {
            sum ^= value.bits >> bit;
        }
        if ((exover_word)sum != -1) {
            fault(c, EXOVER_FAULT_TABLES);
        }
    }
    return value;
}

/* The end of a range of records, its beginning if there is no such range, or if they are not what was emitted. */
#define END_OF(type, section, from, to) \
    end_of(c, FIRST(section), CHECK(section), COUNT(section), WORDS_OF(type), (exover_int)(from), (exover_int)(to))

static OFTEN exover_int end_of(exover *c, const exover_word *first, const exover_word *checks, exover_int count, size_t words,
                               exover_int from, exover_int to)
{
    if ((exover_uint)from > (exover_uint)to || (exover_uint)to > (exover_uint)count) {
        fault(c, EXOVER_FAULT_INDEX);
        return from;
    }
    for (exover_int i = from; is_checked(c) && i < to; i++) {
        if (!holds(c, first, checks, words, i)) {
            return from;
        }
    }
    return to;
}

/* ---- what is remembered: cells, compared before use ---- */

/* Cell `index` of the cells `from .. to`; one that counts for nothing if there is no such cell. */
static OFTEN exover_cell *cell_at(exover *c, uint32_t from, uint32_t to, exover_int index)
{
    exover_cell *cell = &c->spare;
    exover_status cause = EXOVER_FAULT_INDEX;
    if ((exover_uint)index < to - from) {
        cell = &c->cells[from + (exover_uint)index];
        if ((cell->now ^ cell->inverse) == (exover_uint)-1) {
            return cell;
        }
        cause = EXOVER_FAULT_STATE;
    }
    fault(c, cause);
    return cell;
}

/* Cell `index` of a region, one of EXOVER_VECTOR to EXOVER_MARKS; and the one that has its bit `index`, 32 to a cell. */
/* cppcheck-suppress misra-c2012-20.10 ; the name of a region gives the names of where it begins and ends */
#define CELL(region, index) cell_at(c, SHAPE(EXOVER_##region), SHAPE(EXOVER_##region + 1), index)
#define BITS(region, index) CELL(region, (exover_int)((exover_uint)(index) >> 5))

static OFTEN void set_cell(exover_cell *cell, exover_uint value)
{
    cell->now = value;
    cell->inverse = (exover_uint)~value;
}

static void set_bit(exover_cell *cell, exover_int index, bool on)
{
    exover_uint bit = (exover_uint)1 << ((exover_uint)index & 31u);
    set_cell(cell, on ? cell->now | bit : cell->now & ~bit);
}

static bool has_bit(const exover_cell *cell, exover_int index)
{
    return (cell->now >> ((exover_uint)index & 31u) & 1u) != 0u;
}

/* The least set bit from `index` on of the cells that begin with `from`; `end`, or more, if there is none below it. */
static exover_int next_bit(exover *c, uint32_t from, exover_int index, exover_int end)
{
    exover_uint at = (exover_uint)index;
    while (at < (exover_uint)end) {
        exover_uint left = cell_at(c, from, SHAPE(EXOVER_CELLS), (exover_int)(at >> 5))->now >> (at & 31u);
        if (left == 0u) {
            at = (at | 31u) + 1u;
        } else {
            for (; (left & 15u) == 0u; left >>= 4) {
                at += 4u;
            }
            for (; (left & 1u) == 0u; left >>= 1) {
                at++;
            }
            return (exover_int)at;
        }
    }
    return end;
}

/* cppcheck-suppress misra-c2012-20.10 ; the name of a region gives the name of where it begins */
#define NEXT(region, index) next_bit(c, SHAPE(EXOVER_##region), index, end)

/* ---- answers ---- */

/* The check word of an answer: it changes with any bit of the others. */
static OFTEN exover_word check_of(exover_int kind, exover_int request, exover_int slot, exover_int reason, exover_int rule)
{
    exover_uint sum = (exover_uint)kind + 3u * (exover_uint)request + 9u * (exover_uint)slot;
    sum = ~(sum + 5u * (exover_uint)reason + 7u * (exover_uint)rule);
    return (exover_word)sum;
}

static SELDOM bool is_said(const exover_action *action)
{
    return action->check == check_of(action->kind, action->request, action->slot, action->reason, action->launch_rule);
}

SMALL bool exover_holds(const exover_action *action)
{
    return is_said(action);
}

/* Answer in the next place, of which there is one more than answers of an event, for a fault; never behind it. */
static SHARED void say(exover *c, enum exover_kind kind, exover_int request, exover_int slot, exover_int reason, exover_int rule)
{
    if ((exover_uint)c->count > SHAPE(EXOVER_CAPACITY)) {
        fault(c, EXOVER_FAULT_ACTIONS);
        c->count = (exover_int)SHAPE(EXOVER_CAPACITY);
    }
    exover_action *action = &c->actions[c->count];
    c->count++;
    action->kind = (exover_word)kind;
    action->request = (exover_word)request;
    action->slot = (exover_word)slot;
    action->reason = (exover_word)reason;
    if (USES(LAUNCHES)) {
        action->launch_rule = (exover_word)rule; /* else it is EXOVER_UNSAID once and for all */
    }
    action->check = check_of((exover_int)kind, request, slot, reason, USES(LAUNCHES) ? rule : EXOVER_UNSAID);
}

static OFTEN void answer(exover *c, enum exover_kind kind, exover_int request, exover_int slot, exover_int reason, exover_int rule)
{
    if ((exover_uint)c->count >= SHAPE(EXOVER_CAPACITY)) {
        fault(c, EXOVER_FAULT_ACTIONS); /* the last place is kept for that */
    } else {
        say(c, kind, request, slot, reason, rule);
    }
}

/* The only answer to what is none, or to what would start something in a faulty checker. */
static SELDOM void say_only(exover *c, enum exover_kind kind, exover_int request, exover_int slot, exover_int reason)
{
    say(c, kind, request, slot, reason, EXOVER_UNSAID);
}

/* The number of answers, behind which there stand none, whatever that number becomes: what was answered to the event
 * before is made none. */
static SELDOM size_t told(exover *c)
{
    const uint32_t count = (uint32_t)c->count, room = SHAPE(EXOVER_CAPACITY) + 1u;
    for (uint32_t i = count; c->cells != NULL && i < c->said && i < room; i++) {
        c->actions[i].kind = 0;
    }
    c->said = count;
    return count;
}

/* End a step that has changed nothing but the checker itself. */
static SHARED void leave(exover *c)
{
    c->guard = (c->agenda & FAULTY) != 0u ? c->agenda : ~c->agenda;
}

/* Whether a step is running, which this call has interrupted: that step ends with a fault, whatever it decides. */
static SELDOM bool interrupts(exover *c)
{
    const bool running = c->guard == ENTERED;
    if (running && c->fault == EXOVER_READY) {
        c->fault = EXOVER_FAULT_REENTRY;
    }
    return running;
}

/* Reject what waits, once: a faulty checker launches nothing. What either half of a cell says waits is rejected. */
static SELDOM void give_up(exover *c)
{
    if (c->cells == NULL || (c->agenda & TOLD) != 0u) {
        return;
    }
    c->agenda |= TOLD;
    for (exover_int request = 0; USES(WAITS) && request < COUNT(REQUESTS); request++) {
        exover_cell taken = *BITS(TAKEN, request);
        taken.now |= (exover_uint)~taken.inverse;
        if (has_bit(&taken, request)) {
            say_only(c, EXOVER_REJECT, request, NONE, EXOVER_FAULTY);
        }
    }
    leave(c);
}

/* The answer of a faulty checker to whatever would start something, after what waits was rejected; none to who interrupts
 * a step, whose answers stand there. */
static SELDOM size_t deny(exover *c, exover_int request)
{
    if (interrupts(c)) {
        return 0;
    }
    c->count = 0;
    give_up(c);
    say_only(c, EXOVER_REJECT, request, NONE, EXOVER_FAULTY);
    return told(c);
}

/* ---- the second channel: bit rows, and counts of active slots that the diagrams never read ---- */

/* Whether a request with which this one must never be active is active. */
static OFTEN bool in_conflict(exover *c, const exover_request *row)
{
    const exover_cell *active = &c->cells[SHAPE(EXOVER_ACTIVE)];
    exover_uint met = 0, right = (exover_uint)-1;
    if ((exover_uint)row->conflicts > (exover_uint)row->conflicts_end
        || (exover_uint)row->conflicts_end > (exover_uint)COUNT(CONFLICTS)) {
        fault(c, EXOVER_FAULT_INDEX);
        return true;
    }
    const exover_conflict *block = &ALL(conflict, CONFLICTS)[row->conflicts], *end = &ALL(conflict, CONFLICTS)[row->conflicts_end];
    for (; block < end && met == 0; block++) {
        exover_int number = block->block, mask = block->mask;
        if (is_checked(c) && !holds(c, FIRST(CONFLICTS), CHECK(CONFLICTS), WORDS_OF(conflict), (exover_int)(block - ALL(conflict, CONFLICTS)))) {
            return true;
        }
        if ((exover_uint)number >= SHAPE(EXOVER_DIRTY) - SHAPE(EXOVER_ACTIVE)) {
            fault(c, EXOVER_FAULT_INDEX);
            return true;
        }
        right &= active[number].now ^ active[number].inverse;
        met = active[number].now & (exover_uint)mask;
    }
    if (right != (exover_uint)-1) {
        fault(c, EXOVER_FAULT_STATE);
    }
    return met != 0;
}

/* Count a slot of a request in (1) or out (-1), and keep its bit, which is count enough of a single slot. */
static OFTEN void occupy(exover *c, exover_int request, int change)
{
    exover_cell *held = &c->cells[SHAPE(EXOVER_HELD) + (exover_uint)request];
    exover_cell *active = &(&c->cells[SHAPE(EXOVER_ACTIVE)])[(size_t)request / 16];
    exover_uint bits = active->now, right = bits ^ active->inverse, bit = (exover_uint)1 << ((exover_uint)request & 15u);
    bool counts = ((bits & bit) == 0) == (change > 0);
    if (!SINGLE) {
        exover_uint before = held->now, after = before + (exover_uint)change;
        right &= before ^ held->inverse;
        counts = after != (exover_uint)-1;
        set_cell(held, after);
        bit = (before == 0) == (after == 0) ? 0 : bit;
    }
    set_cell(active, bits ^ bit);
    if (right != (exover_uint)-1) {
        fault(c, EXOVER_FAULT_STATE);
    }
    if (!counts) {
        fault(c, EXOVER_FAULT_CHANNELS);
    }
}

/* ---- the state vector and the diagrams ---- */

/* Whether anything is done at the end of a step; if so, remember that it has something to look at. */
#define SETTLES (USES(RULES) || USES(LAUNCHES) || USES(WAITS))

static OFTEN void touch(exover *c)
{
    if (SETTLES) {
        c->agenda |= TOUCHED;
    }
}

/* Add to one entry, and remember the rules to look at. NULL if there is no such entry. */
static OFTEN const exover_entry *bump(exover *c, exover_int index, exover_uint delta)
{
    if ((exover_uint)index >= (exover_uint)COUNT(ENTRIES)) {
        fault(c, EXOVER_FAULT_INDEX);
        return NULL;
    }
    const exover_entry *entry = &ALL(entry, ENTRIES)[index];
    exover_cell *cell = &c->cells[SHAPE(EXOVER_VECTOR) + (exover_uint)index];
    if (is_checked(c) && !holds(c, FIRST(ENTRIES), CHECK(ENTRIES), WORDS_OF(entry), index)) {
        return NULL;
    }
    if ((cell->now ^ cell->inverse) != (exover_uint)-1) {
        fault(c, EXOVER_FAULT_STATE);
    }
    set_cell(cell, cell->now + delta);
    touch(c);
    if (USES(RULES) && entry->rules != entry->rules_end) {
        exover_int end = END_OF(word, LISTS, entry->rules, entry->rules_end);
        for (exover_int i = entry->rules; i < end; i++) {
            set_bit(BITS(DIRTY, LIST[i]), LIST[i], true);
        }
        c->agenda |= DIRTY;
    }
    return entry;
}

/* Add to an entry and to the sums it is part of; a sum is part of no sum. */
static OFTEN void add(exover *c, exover_int index, exover_uint delta)
{
    const exover_entry *entry = bump(c, index, delta);
    if (USES(SUMS) && entry != NULL && entry->sums != entry->sums_end) {
        exover_int end = END_OF(sum, SUMS, entry->sums, entry->sums_end);
        for (exover_int i = entry->sums; i < end; i++) {
            const exover_sum *sum = &ALL(sum, SUMS)[i];
            (void)bump(c, sum->entry, (exover_uint)sum->factor * delta);
        }
    }
}

static void put(exover *c, exover_int index, exover_int value)
{
    if (index >= 0) {
        exover_uint old = CELL(VECTOR, index)->now;
        if (old != (exover_uint)value) {
            add(c, index, (exover_uint)value - old);
        }
    }
}

/* The first action on the path from a node, NULL if there is none. Children stand after their parents. */
static OFTEN const exover_node *walk(exover *c, exover_int index)
{
    const exover_node *nodes = ALL(node, NODES);
    const exover_cell *vector = &c->cells[SHAPE(EXOVER_VECTOR)];
    const exover_word *checks = &c->words[SHAPE(EXOVER_CHECKS + NODES)];
    exover_uint right = (exover_uint)-1;
    exover_int emitted = -1;
    size_t at = (size_t)index, before = at;
    bool forward = true;
    while (at < (size_t)COUNT(NODES) && forward) {
        const exover_node *node = &nodes[at];
        const size_t code = (size_t)node->code;
        if (is_checked(c)) {
            emitted &= node->code ^ node->bound ^ node->low ^ node->high ^ checks[at];
        }
        if (code >= (size_t)COUNT(ENTRIES)) {
            break;
        }
        const exover_uint now = vector[code].now;
        SPEND(c->spent.tests);
        right &= now ^ vector[code].inverse;
        before = at;
        at = (size_t)((exover_int)now <= node->bound ? node->low : node->high);
        forward = at > before;
    }
    if (is_checked(c) && emitted != -1) {
        fault(c, EXOVER_FAULT_TABLES);
    } else if (right != (exover_uint)-1) {
        fault(c, EXOVER_FAULT_STATE);
    } else if (!forward) {
        fault(c, EXOVER_FAULT_PATH);
    } else if (at < (size_t)COUNT(NODES) && nodes[at].code < 0) {
        return &nodes[at];
    } else if (at != (size_t)NONE) {
        fault(c, EXOVER_FAULT_INDEX);
    } else {
        /* the path has ended */
    }
    return NULL;
}

/* Whether a predicate or condition holds: its path says `AGREE`. */
static bool agrees(exover *c, exover_int predicate)
{
    return predicate == ALWAYS || walk(c, predicate) != NULL;
}

/* The actions on the path of the last walk; they stand behind the answers. */
static exover_word *path_of(const exover *c)
{
    /* cppcheck-suppress misra-c2012-11.8 ; the checker is not written to here, and where its answers stand is no part of it */
    return (exover_word *)(void *)&c->actions[SHAPE(EXOVER_CAPACITY) + 1];
}

/* Collect the actions on the path from a node, none of which is done before the path has ended. */
static exover_int collect(exover *c, exover_int index)
{
    const exover_node *nodes = ALL(node, NODES);
    exover_int found = 0;
    for (const exover_node *node = walk(c, index); node != NULL; node = walk(c, node->low)) {
        /* cppcheck-suppress misra-c2012-18.4 ; both point into the array of nodes */
        const ptrdiff_t here = node - nodes;
        if (found == (exover_int)SHAPE(EXOVER_STEPS) || (node->low <= here && node->low != NONE)) {
            fault(c, EXOVER_FAULT_PATH);
            return 0;
        }
        path_of(c)[found] = (exover_word)here;
        found++;
    }
    return found;
}

static const exover_node *step(const exover *c, exover_int index)
{
    return &ALL(node, NODES)[path_of(c)[index]];
}

/* ---- values ---- */

static OFTEN exover_int params_of(const exover_request *row)
{
    return USES(PARAMS) ? minus(row->results, row->params) : 0;
}

/* Put a value into the entry that tests of it read: of a real, twice the number of cuts below it, one more if it is a
 * cut itself. */
static void measure(exover *c, exover_word type, const exover_gauge *gauge, exover_value value)
{
    if (!USES(REALS) || type != REAL) {
        put(c, gauge->value, (exover_int)value.integer);
    } else if (gauge->rank >= 0) {
        exover_int low = gauge->cuts, end = gauge->cuts_end, high = end;
        if ((exover_uint)low > (exover_uint)end || (exover_uint)end > (exover_uint)COUNT(REALS)) {
            fault(c, EXOVER_FAULT_INDEX);
            return;
        }
        while (low < high) {
            exover_int middle = (low + high) / 2;
            if (real_at(c, middle).real < value.real) {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        bool cut = low < end && real_at(c, low).real <= value.real;
        put(c, gauge->rank, 2 * (low - gauge->cuts) + cut);
    } else {
        /* nothing reads it */
    }
}

/* So many values that are remembered, compared before use; NULL if there are no such, or one has changed. */
static exover_value *kept(exover *c, exover_int first, exover_int count)
{
    exover_int all = (exover_int)SHAPE(EXOVER_VALUES);
    if (first < 0 || count < 0 || count > all || first > all - count) {
        fault(c, EXOVER_FAULT_INDEX);
        return NULL;
    }
    exover_value *values = &c->values[first];
    for (exover_int i = 0; i < count; i++) {
        if (values[i].bits != ~values[all + i].bits) {
            fault(c, EXOVER_FAULT_STATE);
            return NULL;
        }
    }
    return values;
}

static void keep(const exover *c, exover_value *at, exover_value value)
{
    (void)c;
    *at = value;
    at[SHAPE(EXOVER_VALUES)].bits = ~value.bits;
}

/* Where the value of a real poster is remembered; NULL if it is not. */
static exover_value *raw_of(exover *c, exover_int variable)
{
    const exover_int raw = RECORD(variable, VARIABLES, variable)->raw;
    return raw < 0 ? NULL : kept(c, plus((exover_int)SHAPE(EXOVER_KEPT), raw), 1);
}

/* What stands at a side of a comparison: parameter `k`, result `k - params`, or poster `-1 - k`. */
static double side(exover *c, exover_int k, exover_int params)
{
    const exover_value *value = NULL;
    if (k < 0) {
        value = raw_of(c, -1 - k);
    } else if (k < params) {
        value = &c->loaded_args[k];
    } else {
        value = &c->loaded_results[k - params];
    }
    return value == NULL ? 0 : value->real;
}

static void compare(exover *c, exover_int from, exover_int to, exover_int params, exover_int all)
{
    if (!USES(ORDERS) || from == to) {
        return;
    }
    exover_int end = END_OF(order, ORDERS, from, to);
    for (exover_int i = from; i < end; i++) {
        const exover_order *order = &ALL(order, ORDERS)[i];
        if (order->left < all && order->right < all) {
            double left = side(c, order->left, params), right = side(c, order->right, params);
            put(c, order->entry, left < right ? 0 : left > right ? 2 : 1);
        }
    }
}

/* Put arguments, and results if there are any, into the entries that tests of them read. */
static void load(exover *c, const exover_request *row, const exover_value *args, const exover_value *results)
{
    const exover_int params = params_of(row);
    const exover_int all = USES(PARAMS) && results != NULL ? minus(row->params_end, row->params) : params;
    if (params < 0 || all < params || all > COUNT(PARAMS)) {
        fault(c, EXOVER_FAULT_INDEX);
    }
    if (all == 0 || (c->loaded_args == args && c->loaded_results == results) || (c->agenda & FAULTY)) {
        return;
    }
    const uint32_t before = c->agenda & TOUCHED; /* what arguments are looked at is no change of the state */
    c->loaded_args = args;
    c->loaded_results = results;
    for (exover_int k = 0; k < all; k++) {
        const exover_param *param = RECORD(param, PARAMS, plus(row->params, k));
        measure(c, param->domain.type, &param->gauge, k < params ? args[k] : results[k - params]);
    }
    compare(c, row->orders, row->orders_end, params, all);
    c->agenda = (c->agenda & ~(uint32_t)TOUCHED) | before;
}

static bool fits(exover *c, const exover_request *row, exover_int predicate, const exover_value *args,
                 const exover_value *results)
{
    if (predicate >= 0) {
        load(c, row, args, results);
    }
    return agrees(c, predicate);
}

/* ---- slots and waiting places: slot `instances` of a request is its waiting place ---- */

static OFTEN exover_int instances_of(const exover_request *row)
{
    return SINGLE ? 1 : row->instances;
}

static exover_value *args_of(exover *c, const exover_request *row, exover_int slot)
{
    const exover_int params = params_of(row);
    const exover_uint before = (exover_uint)slot * (exover_uint)params; /* unsigned, since nothing is believed yet */
    return params != 0 ? kept(c, plus(row->values, (exover_int)before), params) : NULL;
}

/* Which of the phases is that of a slot or place. */
static OFTEN exover_int phase_at(exover_int request, const exover_request *row, exover_int slot)
{
    return SINGLE ? 2 * request + slot : plus(plus(row->slots, request), slot);
}

static OFTEN exover_uint in_phase(const exover_cell *cell)
{
    return cell->now & (SINCE - 1u);
}

static OFTEN exover_uint phase_of(exover *c, exover_int request, const exover_request *row, exover_int slot)
{
    return in_phase(CELL(PHASES, phase_at(request, row, slot)));
}

static OFTEN bool is_waiting(exover *c, exover_int request, const exover_request *row)
{
    return USES(WAITS) && c->agenda >= PLACE && phase_of(c, request, row, instances_of(row)) != EMPTY;
}

/* What a slot or place counts for in a feature that looks at arguments. */
static SELDOM exover_uint weigh(exover *c, const exover_request *row, const exover_value *args, const exover_feature *feature)
{
    if (!fits(c, row, feature->predicate, args, NULL)) {
        return 0;
    }
    return feature->weight < 0 || feature->weight >= params_of(row) || args == NULL ? 1
                                                                                    : (exover_uint)args[feature->weight].integer;
}

/* What a slot or place counts for in a feature. */
static OFTEN exover_uint count_for(exover *c, const exover_request *row, exover_int slot, const exover_feature *feature)
{
    if (EXOVER_PLAIN) {
        return 1;
    }
    if (feature->slot != NONE && feature->slot != slot) {
        return 0;
    }
    return feature->predicate == ALWAYS && feature->weight < 0 ? 1 : weigh(c, row, args_of(c, row, slot), feature);
}

/* Count what a slot or place holds in (1) or out of (-1) every feature of its request. */
static OFTEN void tally(exover *c, const exover_request *row, exover_int slot, exover_uint phase, int sign)
{
    const exover_int from = row->features, end = END_OF(feature, FEATURES, from, row->features_end);
    if (from >= end) {
        return;
    }
    const exover_feature *last = &ALL(feature, FEATURES)[end];
    for (const exover_feature *feature = &ALL(feature, FEATURES)[from]; feature < last; feature++) {
        exover_int entry = feature->entries[(phase - 1) & 3];
        exover_uint weight = entry < 0 ? 0 : count_for(c, row, slot, feature);
        if (weight != 0) {
            add(c, entry, weight * (exover_uint)sign);
        }
    }
}

/* Let a slot or place remember arguments, if they are not its own. */
static OFTEN void remember(exover *c, const exover_request *row, exover_int slot, const exover_value *args)
{
    exover_value *own = args_of(c, row, slot);
    if (USES(PARAMS) && own != args && own != NULL) {
        for (exover_int k = 0; k < params_of(row); k++) {
            keep(c, &own[k], args[k]);
        }
        c->loaded_args = NULL;
    }
}

/* Let a slot or place, whose phase is in this cell and counts no more, hold something else, which is not counted yet. */
static OFTEN void set_phase(exover *c, const exover_request *row, exover_int slot, exover_cell *cell, exover_uint next,
                            const exover_value *args)
{
    set_cell(cell, next + SINCE * (exover_uint)c->steps);
    c->changed = SETTLES; /* else nothing is repeated */
    touch(c);
    if (next != EMPTY) {
        remember(c, row, slot, args);
    }
}

/* The same for whom it is not worth to stand there again. */
static ONCE void recount_slot(exover *c, const exover_request *row, exover_int slot, exover_uint phase, int sign)
{
    tally(c, row, slot, phase, sign);
}

/* Let a slot or place hold something else: in this phase, these arguments. */
static void hold(exover *c, exover_int request, const exover_request *row, exover_int slot, exover_uint next,
                 const exover_value *args)
{
    exover_cell *cell = CELL(PHASES, phase_at(request, row, slot));
    exover_uint phase = in_phase(cell);
    if (slot == instances_of(row)) {
        if (phase == next && (next == EMPTY || args_of(c, row, slot) == args)) {
            return;
        }
        if ((phase == EMPTY) != (next == EMPTY)) {
            c->agenda += next == EMPTY ? (uint32_t)0 - PLACE : (uint32_t)PLACE;
        }
        set_bit(BITS(TAKEN, request), request, next != EMPTY);
    }
    if (phase != EMPTY) {
        recount_slot(c, row, slot, phase, -1);
    }
    set_phase(c, row, slot, cell, next, args);
    if (next != EMPTY) {
        recount_slot(c, row, slot, next, 1);
    }
}

/* The reason of the launch rule that put there what waits at a request; EXOVER_UNSAID if it was asked for. */
static exover_word origin_of(exover *c, exover_int request)
{
    return (exover_word)(COUNT(LAUNCHES) != 0 ? (exover_int)CELL(ORIGINS, request)->now - 1 : EXOVER_UNSAID);
}

/* Say that what stands, or stood, in a waiting place is rejected. */
static OFTEN void say_rejected(exover *c, exover_int request, exover_int reason)
{
    answer(c, EXOVER_REJECT, request, NONE, reason, USES(LAUNCHES) ? origin_of(c, request) : EXOVER_UNSAID);
}

static void vacate(exover *c, exover_int request, exover_int reason)
{
    const exover_request *row = REQUEST(request);
    hold(c, request, row, instances_of(row), EMPTY, NULL);
    say_rejected(c, request, reason);
}

static SELDOM void kill_slot(exover *c, exover_int request, const exover_request *row, exover_int slot, exover_int reason)
{
    if (phase_of(c, request, row, slot) == RUNNING) {
        hold(c, request, row, slot, STOPPING, args_of(c, row, slot));
        if ((exover_uint)c->count >= SHAPE(EXOVER_CAPACITY)) {
            fault(c, EXOVER_FAULT_ACTIONS);
        } else {
            say_only(c, EXOVER_KILL, request, slot, reason);
        }
    }
}

/* Kill what a node says: all slots of a request, or one slot of all. */
static void kill_target(exover *c, const exover_node *node)
{
    exover_int target = node->high, request = 0, end = COUNT(REQUESTS);
    if (target >= 0) {
        const exover_request *row = REQUEST(target);
        for (exover_int slot = 0; slot < instances_of(row) && (c->agenda & FAULTY) == 0; slot++) {
            kill_slot(c, target, row, slot, node->bound);
        }
        return;
    }
    target = -1 - target;
    while (end - request > 1) {
        exover_int middle = (request + end) / 2;
        if (REQUEST(middle)->slots <= target) {
            request = middle;
        } else {
            end = middle;
        }
    }
    const exover_request *row = REQUEST(request);
    kill_slot(c, request, row, minus(target, row->slots), node->bound);
}

/* ---- variables, pasts, effects ---- */

/* Count the slots out (-1) or in (1) whose features read a poster. */
static void recount(exover *c, const exover_variable *row, int sign)
{
    if (!USES(ORDERS) || row->refresh == row->refresh_end) {
        return;
    }
    exover_int end = END_OF(word, LISTS, row->refresh, row->refresh_end);
    for (exover_int i = row->refresh; i < end; i++) {
        const exover_request *request = REQUEST(LIST[i]);
        for (exover_int slot = 0; slot < instances_of(request) && (c->agenda & FAULTY) == 0; slot++) {
            exover_uint phase = phase_of(c, LIST[i], request, slot);
            if (phase != EMPTY) {
                recount_slot(c, request, slot, phase, sign);
            }
        }
    }
}

/* Let a poster, state or latch read a value. */
static void take_reading(exover *c, exover_int variable, exover_value value)
{
    const exover_variable *row = RECORD(variable, VARIABLES, variable);
    recount(c, row, -1);
    measure(c, row->domain.type, &row->gauge, value);
    if (USES(ORDERS) && row->raw >= 0) {
        exover_value *raw = raw_of(c, variable);
        if (raw != NULL) {
            keep(c, raw, value);
            touch(c);
        }
        c->loaded_args = NULL;
    }
    compare(c, row->orders, row->orders_end, 0, 0);
    recount(c, row, 1);
}

static void read_integer(exover *c, exover_int variable, exover_int number)
{
    exover_value value;
    value.integer = number;
    take_reading(c, variable, value);
}

static void latch(exover *c, exover_int cleared_by)
{
    for (exover_int i = 0; USES(LATCHES) && i < COUNT(LATCHES); i++) {
        const exover_latch *row = RECORD(latch, LATCHES, i);
        bool is_set = agrees(c, row->condition), changes = is_set;
        exover_int end = END_OF(word, LISTS, row->resets, row->resets_end);
        for (exover_int k = row->resets; k < end; k++) {
            changes |= LIST[k] == cleared_by;
        }
        if (changes) {
            read_integer(c, row->variable, is_set);
        }
    }
}

static void affect(exover *c, const exover_word *edge)
{
    if (!USES(EFFECTS) || edge[0] == edge[1]) {
        return;
    }
    exover_int end = END_OF(effect, EFFECTS, edge[0], edge[1]);
    for (exover_int i = edge[0]; i < end; i++) {
        const exover_effect *effect = &ALL(effect, EFFECTS)[i];
        if (effect->kind == SET) {
            read_integer(c, effect->target, effect->value);
        } else {
            const exover_request *row = REQUEST(effect->target);
            exover_int last = END_OF(past, PASTS, row->pasts, row->pasts_end);
            for (exover_int k = row->pasts; k < last; k++) {
                put(c, ALL(past, PASTS)[k].entry, 0);
            }
        }
    }
}

/* Take (sign -1) what a launch consumes, or give (sign 1) what a success produces, never above the capacity. */
static void supply(exover *c, const exover_request *row, exover_int from, exover_int to, const exover_value *args,
                   exover_int sign)
{
    if (!USES(AMOUNTS) || from == to) {
        return;
    }
    exover_int end = END_OF(amount, AMOUNTS, from, to);
    for (exover_int i = from; i < end; i++) {
        const exover_amount *amount = &ALL(amount, AMOUNTS)[i];
        const exover_stock *stock = RECORD(stock, STOCKS, amount->stock);
        if (stock->entry >= 0 && fits(c, row, amount->predicate, args, NULL)) {
            exover_int room = (exover_int)((exover_uint)stock->capacity - CELL(VECTOR, stock->entry)->now);
            exover_int given = amount->amount < room ? amount->amount : room;
            add(c, stock->entry, sign < 0 ? (exover_uint)0 - (exover_uint)amount->amount : (exover_uint)given);
        }
    }
}

/* ---- decisions ---- */

/* The reason of the launch rule that what is being decided comes of; EXOVER_UNSAID if it was asked for. */
static OFTEN exover_int origin(const exover *c)
{
    return USES(LAUNCHES) ? c->origin : EXOVER_UNSAID;
}

/* The diagrams say launch; nothing is launched unless the bit rows say so too. */
static OFTEN void launch(exover *c, exover_int request, const exover_request *row, const exover_value *args, bool met,
                         exover_int required)
{
    exover_int slot = 0;
    exover_cell *cell = CELL(PHASES, phase_at(request, row, 0));
    while (in_phase(cell) != EMPTY && slot + 1 < instances_of(row)) {
        slot++;
        cell = CELL(PHASES, phase_at(request, row, slot));
    }
    if (in_phase(cell) != EMPTY) {
        fault(c, EXOVER_FAULT_DECISION);
    } else if (met) {
        fault(c, EXOVER_FAULT_CHANNELS);
    } else {
        /* both channels agree */
    }
    if ((c->agenda & FAULTY) != 0u) {
        return;
    }
    occupy(c, request, 1);
    if (USES(WAITS) && c->agenda >= PLACE) {
        hold(c, request, row, instances_of(row), EMPTY, NULL);
    }
    set_phase(c, row, slot, cell, RUNNING, args);
    tally(c, row, slot, RUNNING, 1);
    supply(c, row, row->consumes, row->produces, args, -1);
    affect(c, &row->effects[0]);
    answer(c, EXOVER_LAUNCH, request, slot, required, origin(c));
}

/* Whether a denial shows that a request of the bit row is active. */
static OFTEN bool shows_conflict(exover *c, const exover_node *first)
{
    if (first->code < -CLEAR) {
        return false;
    }
    exover_word denials = RECORD(reason_row, REASONS, first->bound)->denials;
    return denials == ALL_DENIALS || (denials == CLEARINGS && first->code == -CLEAR);
}

/* The first action of the decision on a request; a rejection if there is none, which is a fault. */
static OFTEN const exover_node *decide(exover *c, const exover_request *row, const exover_value *args, bool *met)
{
    if (params_of(row) != 0) {
        load(c, row, args, NULL);
    }
    static const exover_node refused = {-REJECT, EXOVER_FAULTY, NONE, NONE};
    const exover_node *first = walk(c, row->decide);
    if (first == NULL) {
        fault(c, EXOVER_FAULT_DECISION);
        return &refused;
    }
    *met = in_conflict(c, row);
    if (!*met && shows_conflict(c, first)) {
        fault(c, EXOVER_FAULT_CHANNELS);
    }
    return first;
}

/* Do what a decision says that is no rejection; return what the newcomer waits for, EXOVER_UNSAID if it does not. */
static OFTEN exover_int carry_out(exover *c, exover_int request, const exover_request *row, const exover_value *args,
                            const exover_node *first, bool met, exover_int required)
{
    if (first->code == -LAUNCH && first->low == NONE) {
        launch(c, request, row, args, met, required);
        return EXOVER_UNSAID;
    }
    if (!USES(WAITS) && !USES(KILLS)) {
        fault(c, EXOVER_FAULT_DECISION);
        return EXOVER_UNSAID;
    }
    exover_int waits = EXOVER_UNSAID, found = collect(c, (exover_int)(first - ALL(node, NODES)));
    for (exover_int i = 0; i < found; i++) {
        const exover_node *node = step(c, i);
        switch (node->code) {
        case -WAIT:
        case -CLEAR:
        case -SETTLE:
            waits = node->bound;
            hold(c, request, row, instances_of(row), node->code == -WAIT ? WAITING : CLEARING, args);
            break;
        case -KILL:
            kill_target(c, node);
            break;
        case -DISMISS:
            if (is_waiting(c, node->high, REQUEST(node->high))) {
                vacate(c, node->high, node->bound);
            }
            break;
        case -LAUNCH:
            launch(c, request, row, args, met, required);
            break;
        default:
            fault(c, EXOVER_FAULT_DECISION);
            break;
        }
    }
    return waits;
}

/* Whether the last step refused a launch rule for the same reason; that this step does is remembered. */
static bool is_repeated(exover *c, exover_int rule, exover_int reason)
{
    exover_cell *cell = CELL(REFUSED, rule);
    const exover_uint before = cell->now, now = 2u * ((exover_uint)reason + 1u);
    set_cell(cell, now + 1u); /* odd until this step ends */
    return before == now;
}

/* Handle an ask, or what launch rule `rule` requires. */
static OFTEN void ask(exover *c, exover_int request, const exover_request *row, const exover_value *args, exover_int rule)
{
    exover_int reason = EXOVER_BUSY;
    if (!is_waiting(c, request, row) || row->interrupts_self) {
        bool met = false;
        const exover_node *first = decide(c, row, args, &met);
        if (first->code != -REJECT) {
            if (is_waiting(c, request, row)) {
                say_rejected(c, request, EXOVER_SUPERSEDED);
            }
            reason = carry_out(c, request, row, args, first, met, origin(c));
            if (reason != EXOVER_UNSAID) {
                if (COUNT(LAUNCHES) != 0) {
                    set_cell(CELL(ORIGINS, request), (exover_uint)c->origin + 1u);
                }
                answer(c, EXOVER_WAIT, request, NONE, reason, origin(c));
            }
            return;
        }
        reason = first->bound;
    }
    if (!USES(LAUNCHES) || rule == NONE || !is_repeated(c, rule, reason)) {
        answer(c, EXOVER_REJECT, request, NONE, reason, origin(c));
    }
}

/* ---- steps 3 to 5 ---- */

static void recover(exover *c)
{
    const exover_int end = COUNT(RULES);
    c->agenda &= ~(uint32_t)DIRTY;
    for (exover_int rule = NEXT(DIRTY, 0); rule < end; rule = NEXT(DIRTY, rule + 1)) {
        set_bit(BITS(DIRTY, rule), rule, false);
        set_bit(BITS(BROKEN, rule), rule, false);
        exover_int found = collect(c, RECORD(rule, RULES, rule)->root);
        for (exover_int i = 0; i < found; i++) {
            const exover_node *node = step(c, i);
            if (node->code == -KILL) {
                kill_target(c, node);
            } else if (node->code == -VIOLATION) {
                set_bit(BITS(BROKEN, rule), rule, true);
                c->agenda |= BROKEN;
            } else {
                /* nothing else restores a rule */
            }
        }
    }
}

static void launch_required(exover *c)
{
    for (exover_int i = 0; USES(LAUNCHES) && i < COUNT(LAUNCHES); i++) {
        const exover_launch_rule *row = RECORD(launch_rule, LAUNCHES, i);
        if (has_bit(BITS(MARKS, i), i) || !agrees(c, row->condition)) {
            continue;
        }
        set_bit(BITS(MARKS, i), i, true);
        c->agenda |= MARKED;
        const exover_request *request = REQUEST(row->request);
        exover_value *scratch = c->values + 2 * SHAPE(EXOVER_VALUES);
        const exover_int params = params_of(request), last = plus(row->args, params);
        if (params < 0 || params > (exover_int)SHAPE(EXOVER_SCRATCH) || END_OF(word, LISTS, row->args, last) != last) {
            fault(c, EXOVER_FAULT_INDEX);
            return;
        }
        for (exover_int k = 0; k < params; k++) {
            exover_word word = LIST[row->args + k];
            if (RECORD(param, PARAMS, plus(request->params, k))->domain.type != REAL) {
                scratch[k].integer = word;
            } else {
                scratch[k] = real_at(c, word);
            }
        }
        c->loaded_args = NULL;
        c->origin = row->reason;
        ask(c, row->request, request, scratch, i);
    }
}

/* Keep for what this step refused launch rules, and forget for what the last one did. */
static void forget_refusals(exover *c)
{
    for (exover_int i = 0; i < COUNT(LAUNCHES); i++) {
        exover_cell *cell = CELL(REFUSED, i);
        set_cell(cell, (cell->now & 1u) != 0u ? cell->now - 1u : 0u);
    }
}

static void settle(exover *c)
{
    const exover_int end = COUNT(REQUESTS);
    for (exover_int request = NEXT(TAKEN, 0); request < end; request = NEXT(TAKEN, request + 1)) {
        const exover_request *row = REQUEST(request);
        exover_int mark = COUNT(LAUNCHES) + request;
        const exover_value *args = args_of(c, row, instances_of(row));
        bool met = false;
        const exover_node *first = decide(c, row, args, &met);
        if ((c->agenda & FAULTY) != 0u) {
            return;
        }
        if (first->code == -REJECT) {
            vacate(c, request, first->bound);
        } else if (first->code != -LAUNCH && first->code != -DISMISS
                   && (first->code == -WAIT || has_bit(BITS(MARKS, mark), mark))) {
            if (phase_of(c, request, row, instances_of(row)) == CLEARING) {
                set_bit(BITS(MARKS, mark), mark, true);
                c->agenda |= MARKED;
            }
            hold(c, request, row, instances_of(row), WAITING, args);
        } else {
            if (USES(LAUNCHES)) {
                c->origin = origin_of(c, request);
            }
            (void)carry_out(c, request, row, args, first, met, EXOVER_UNSAID);
        }
    }
}

/* Raise every rule that is still broken once; the copies of a rule stand together. */
static void violations(exover *c)
{
    const exover_int end = COUNT(RULES);
    exover_int last = NONE;
    c->agenda &= ~(uint32_t)BROKEN;
    for (exover_int rule = NEXT(BROKEN, 0); rule < end; rule = NEXT(BROKEN, rule + 1)) {
        exover_int reason = RECORD(rule, RULES, rule)->reason;
        if (reason != last) {
            answer(c, EXOVER_VIOLATION, NONE, NONE, reason, EXOVER_UNSAID);
        }
        last = reason;
        c->agenda |= BROKEN;
    }
}

/* ---- the checker itself: its seal, and the scrubbing ---- */

static OFTEN uintptr_t address(const void *place)
{
    /* cppcheck-suppress misra-c2012-11.6 ; the seal is made of addresses, and never made into one */
    return (uintptr_t)place;
}

/* Add to a seal: what came before is turned by 7 bits, so that the same bit of two parts leaves two traces. */
static OFTEN uintptr_t sealed(uintptr_t before, uintptr_t part)
{
    return (before << 7 | before >> (8u * sizeof before - 7u)) ^ part;
}

/* The seal of all that does not change between two loads, and of where the checker itself is; no seal of nothing. */
static SHARED uintptr_t seal_of(const exover *c)
{
    uintptr_t found = (uintptr_t)0x5ea1edu;
#ifndef EXOVER_SHAPE
    for (int i = 0; i < EXOVER_SHAPE_SIZE; i++) {
        found = sealed(found, c->shape[i]);
    }
#endif
    found = sealed(found ^ address(c), address(c->actions));
    found = sealed(sealed(found, address(c->head)), address(c->reals));
    found = sealed(sealed(found, address(c->words)), address(c->values));
    return sealed(found, address(c->cells));
}

/* Whether the seal holds, for whom it is not worth to stand there again. */
static SELDOM bool is_sealed(const exover *c)
{
    return c->seal == seal_of(c);
}

/* What a byte makes of a CRC-32 (the one of Ethernet). */
static uint32_t add_byte(uint32_t before)
{
    uint32_t sum = before;
    for (int bit = 0; bit < 8; bit++) {
        sum = (sum >> 1) ^ (0xedb88320u * (sum & 1u));
    }
    return sum;
}

/* How many fours of bytes the tables have; two bytes may be left. */
static OFTEN uint32_t fours(const exover *c)
{
    (void)c;
    return EXOVER_HEAD_WORDS + 2 * SHAPE(EXOVER_REALS) + EXOVER_WIDTH * SHAPE(EXOVER_WORDS) / 4u;
}

static OFTEN bool has_rest(const exover *c)
{
    (void)c;
    return EXOVER_WIDTH * SHAPE(EXOVER_WORDS) % 4u != 0u;
}

static OFTEN uint32_t rest_of(const exover *c)
{
    return (uint32_t)(uint16_t)c->words[SHAPE(EXOVER_WORDS) - 1u];
}

/* The `at`-th four bytes of the tables. */
static OFTEN uint32_t four_at(const exover *c, uint32_t at)
{
    const uint32_t reals = EXOVER_HEAD_WORDS, words = reals + 2u * SHAPE(EXOVER_REALS);
    const uint32_t half = at % 2u * 32u; /* of 8 bytes */
    if (at >= words) {
#if EXOVER_WIDTH == 2
        size_t number = at;
        number -= words;
        const exover_word *word = &c->words[2u * number];
        return (uint32_t)(uint16_t)word[0] | ((uint32_t)(uint16_t)word[1] << 16);
#elif EXOVER_WIDTH == 4
        return (uint32_t)c->words[at - words];
#else
        return (uint32_t)((uint64_t)c->words[(at - words) / 2u] >> half);
#endif
    }
    return at >= reals ? (uint32_t)(c->reals[(at - reals) / 2u].bits >> half) : c->head[at];
}

/* Add four bytes to those before, so that any change of them changes the sum; which is no CRC, but takes few steps. */
static OFTEN uint32_t mixed(uint32_t before, uint32_t four)
{
    const uint32_t sum = (before ^ four) * 0x9e3779b1u;
    return sum << 13 | sum >> 19;
}

/* Look at the next so many bytes of the tables, and at the next of what is remembered. */
static SHARED void scrub(exover *c, uint32_t count)
{
    uint32_t at = c->scrubbed, sum = c->sum, next = c->compared;
    c->compared = next + 1u;
    for (uint32_t bytes = 0; bytes < count; bytes += 4u) {
        if (at < fours(c)) {
            sum = mixed(sum, four_at(c, at++));
        } else {
            if ((has_rest(c) ? mixed(sum, rest_of(c)) : sum) != c->whole) {
                fault(c, EXOVER_FAULT_TABLES);
            }
            at = 0;
            sum = 0;
        }
    }
    c->scrubbed = at;
    c->sum = sum;
    if (next < SHAPE(EXOVER_CELLS)) {
        if ((c->cells[next].now ^ c->cells[next].inverse) != (exover_uint)-1) {
            fault(c, EXOVER_FAULT_STATE);
        }
    } else if (next - SHAPE(EXOVER_CELLS) < SHAPE(EXOVER_VALUES)) {
        const uint32_t value = next - SHAPE(EXOVER_CELLS);
        (void)kept(c, (exover_int)value, 1);
    } else {
        c->compared = 0;
    }
}

/* A checker that was not loaded, or that does not know any more where its memory is: only its own place is left. */
static SELDOM bool lost(exover *c)
{
    if (c->actions == NULL || c->cells == NULL) {
        fault(c, EXOVER_NOT_LOADED);
    }
    fault(c, EXOVER_FAULT_CHECKER);
    leave(c);
    c->actions = &c->denial;
    c->denial.launch_rule = EXOVER_UNSAID;
    c->said = 0;
    c->cells = NULL;
    return false;
}

/* Begin no event, since the guard does not hold: of a faulty checker, or while a step is running. */
static SELDOM bool refuse(exover *c)
{
    if (c->guard != ENTERED) {
        c->count = 0;
        if (!is_sealed(c)) {
            return lost(c);
        }
        fault(c, EXOVER_FAULT_STATE);
        leave(c);
    }
    return false;
}

/* Begin an event; false if everything is denied. */
static ONCE bool begin(exover *c)
{
    if (c->guard != ~(c->agenda ^ (uint32_t)c->fault)) {
        return refuse(c);
    }
    c->guard = ENTERED;
    IN_ORDER();
    c->count = 0;
#ifdef EXOVER_DEBUG
    wipe(&c->spent, sizeof c->spent);
#endif
    if (USES(PARAMS)) {
        c->loaded_args = NULL;
        c->loaded_results = NULL; /* a host may report other results at the same place, of a request without arguments */
    }
    if (USES(LAUNCHES)) {
        c->origin = EXOVER_UNSAID;
    }
    if (c->seal != seal_of(c)) {
        return lost(c);
    }
    if (EXOVER_SCRUB > 0) {
        scrub(c, (uint32_t)EXOVER_SCRUB);
    }
    if ((c->agenda & FAULTY) != 0u) {
        leave(c);
        return false;
    }
    c->steps++;
    return true;
}

static exover_status cause_of(const exover *c)
{
    const exover_status found = c->fault;
    if ((uint32_t)found > (uint32_t)EXOVER_STILL_ACTIVE) {
        return EXOVER_FAULT_STATE; /* a number that is none has lost a bit */
    }
    return c->actions == NULL && found == EXOVER_READY ? EXOVER_NOT_LOADED : found;
}

SMALL exover_status exover_scrub(exover *c, uint32_t bytes)
{
    if (c->guard != ~(c->agenda ^ (uint32_t)c->fault)) {
        (void)refuse(c);
        (void)interrupts(c);
    } else if (!is_sealed(c)) {
        (void)lost(c);
    } else {
        c->guard = ENTERED;
        for (uint32_t left = bytes; left > 0u; left -= left < 4u ? left : 4u) {
            scrub(c, 4u);
        }
        if (c->fault != EXOVER_READY) {
            c->agenda |= FAULTY; /* also if a call has interrupted this */
        }
        leave(c);
    }
    return cause_of(c);
}

/* Nothing starts in a step that ends with a fault, but what was told to stop shall stop. Whatever else would have started
 * or was given up is rejected, and what waits; at last what was asked for, for which the last place was kept. */
static void keep_kills(exover *c, exover_int request, exover_uint count)
{
    c->count = 0;
    for (exover_uint i = 0; i < count && i <= SHAPE(EXOVER_CAPACITY); i++) {
        const exover_action said = c->actions[i];
        const bool holds = is_said(&said);
        if (holds && said.kind == EXOVER_KILL) {
            c->actions[c->count] = said;
            c->count++;
        } else if (holds && (said.kind == EXOVER_LAUNCH || said.kind == EXOVER_REJECT) && said.request != request) {
            say_only(c, EXOVER_REJECT, said.request, NONE, EXOVER_FAULTY);
        } else {
            /* what waits is rejected below, as what was asked for */
        }
    }
    give_up(c);
    say_only(c, EXOVER_REJECT, request, NONE, EXOVER_FAULTY);
}

SMALL size_t exover_verify(exover *c, size_t count)
{
    if (c->guard == ENTERED) {
        return 0; /* this interrupts a step, whose answers are not complete */
    }
    if (!is_sealed(c)) {
        if (c->actions == &c->denial && c->cells == NULL && count == 1u && is_said(&c->denial)) {
            return 1;
        }
        (void)lost(c);
        return deny(c, NONE);
    }
    bool holds = count == (size_t)c->count && count <= (size_t)SHAPE(EXOVER_CAPACITY) + 1u;
    for (size_t i = 0; holds && i < count; i++) {
        holds = is_said(&c->actions[i]);
    }
    if (!holds) {
        fault(c, EXOVER_FAULT_ANSWERS);
        keep_kills(c, NONE, (exover_uint)SHAPE(EXOVER_CAPACITY) + 1u);
        return told(c);
    }
    return count;
}

/* Repeat steps 3 to 5 until nothing changes; return whether marks of this step may keep the next from doing the same. */
static OFTEN bool repeat(exover *c)
{
    const exover_int most = RECORD(limits, LIMITS, 0)->passes;
    exover_int passes = 0;
    c->changed = true;
    while (c->changed && (c->agenda & FAULTY) == 0 && (c->agenda >= PLACE || (c->agenda & (DIRTY | REQUIRED)))) {
        c->changed = false;
        SPEND(c->spent.passes);
        if (passes >= most) {
            fault(c, EXOVER_FAULT_PASSES);
        }
        passes++;
        if (USES(RULES) && (c->agenda & DIRTY)) {
            recover(c);
        }
        launch_required(c);
        if (USES(WAITS) && c->agenda >= PLACE) {
            settle(c);
        }
    }
    return passes > 1;
}

/* Steps 3 to 5, and what they leave behind. Where nothing has changed since the last step they would change nothing. */
static OFTEN void settle_all(exover *c)
{
    bool leaves_marks = false;
    if ((c->agenda & (DIRTY | TOUCHED | UNSETTLED)) != 0u) {
        leaves_marks = repeat(c);
        if (USES(LAUNCHES)) {
            forget_refusals(c);
        }
    }
    if (USES(RULES) && (c->agenda & BROKEN)) {
        violations(c);
    }
    c->agenda &= ~((uint32_t)TOUCHED | (uint32_t)UNSETTLED);
    if ((c->agenda & MARKED) != 0u) {
        c->agenda = (c->agenda & ~(uint32_t)MARKED) | (leaves_marks ? (uint32_t)UNSETTLED : 0u);
        for (uint32_t i = SHAPE(EXOVER_MARKS); i < SHAPE(EXOVER_CELLS); i++) {
            set_cell(&c->cells[i], 0);
        }
    }
}

/* End a step in which a fault was found. */
static SELDOM void fail(exover *c, exover_int request)
{
    c->agenda |= FAULTY; /* also if a call has interrupted this step */
    c->steps--;          /* what is remembered of it is not believed */
    keep_kills(c, request, (exover_uint)c->count);
}

/* The end of a step that leaves something to look at. */
static SELDOM size_t attend(exover *c, exover_int request)
{
    if (SETTLES) {
        settle_all(c);
    }
    if (c->fault != EXOVER_READY || (c->agenda & FAULTY) != 0u) {
        fail(c, request);
    }
    leave(c);
    return told(c);
}

/* End a step; return the number of answers. */
static SHARED size_t finish(exover *c, exover_int request)
{
    IN_ORDER();
    size_t count = (size_t)c->count;
    if (count > SHAPE(EXOVER_CAPACITY)) {
        fault(c, EXOVER_FAULT_ACTIONS);
    }
    if (((c->agenda & ~(SETTLES ? (uint32_t)TOUCHED : 0u)) | (uint32_t)c->fault) != 0u) {
        count = attend(c, request);
    } else {
        c->agenda = 0;
        const uint32_t said = c->said;
        c->said = (uint32_t)count;
        if (said == count + 1u) {
            c->actions[count].kind = 0; /* as told() does, in the case that is nearly every */
        } else if (said > count) {
            c->said = said;
            count = told(c);
        } else {
            /* as many as before, or more */
        }
        c->guard = ~(uint32_t)0;
    }
#ifdef EXOVER_DEBUG
    assert(c->spent.tests <= EXOVER_TESTS || (c->agenda & FAULTY) != 0);
    assert(count <= EXOVER_ACTIONS || (c->agenda & FAULTY) != 0);
    assert(c->spent.passes <= EXOVER_PASSES || (c->agenda & FAULTY) != 0);
#endif
    return count;
}

/* Answer that the event was none; `c->wrong` tells why. If that was seen in what is not believed any more, deny. */
static SELDOM size_t invalid(exover *c, exover_int request)
{
    if (c->guard == ENTERED && (c->agenda & FAULTY) != 0u) {
        return attend(c, request);
    }
    say_only(c, EXOVER_INVALID, NONE, NONE, c->wrong);
    leave(c);
    return told(c);
}

/* ---- validation: 0, or an exover_invalid ---- */

static bool in_domain(exover *c, const exover_domain *domain, exover_value value)
{
    if (USES(REALS) && domain->type == REAL) {
        return (value.bits >> 52 & 0x7ff) != 0x7ff && value.real >= real_at(c, domain->low).real
               && value.real <= real_at(c, domain->high).real;
    }
    return value.integer >= domain->low && value.integer <= domain->high;
}

static int wrong_values(exover *c, exover_int from, exover_int to, const exover_value *values, size_t count)
{
    const size_t expected = USES(PARAMS) ? (size_t)minus(to, from) : 0;
    if (count != expected || (count != 0 && values == NULL)) {
        return count > expected ? EXOVER_UNKNOWN_ARGUMENT : EXOVER_MISSING_ARGUMENT;
    }
    for (; USES(PARAMS) && from < to; from++, values++) {
        if (!in_domain(c, &RECORD(param, PARAMS, from)->domain, *values)) {
            return EXOVER_OUT_OF_RANGE;
        }
    }
    return 0;
}

/* The record of a request; NULL if there is no such slot, `c->wrong` tells why. */
static OFTEN const exover_request *slot_at(exover *c, int32_t request, int32_t slot)
{
    if ((uint32_t)request < (exover_uint)COUNT(REQUESTS)) {
        const exover_request *row = REQUEST(request);
        if (slot >= 0 && slot < instances_of(row)) {
            return row;
        }
        c->wrong = EXOVER_OUT_OF_RANGE;
    } else {
        c->wrong = EXOVER_UNKNOWN_REQUEST;
    }
    return NULL;
}

/* Whether something is wrong with an event; nothing is if the code is 0. */
static OFTEN bool is_wrong(exover *c, int code)
{
    if (code != 0) {
        c->wrong = code;
    }
    return code != 0;
}

/* ---- events ---- */

size_t exover_ask(exover *c, int32_t request, const exover_value *args, size_t count)
{
    if (!begin(c)) {
        return deny(c, request);
    }
    const exover_request *row = slot_at(c, request, 0);
    if (row == NULL || is_wrong(c, wrong_values(c, row->params, row->results, args, count))) {
        return invalid(c, request);
    }
    static const exover_value nothing = {0}; /* of a newcomer without parameters: not those of what waits */
    ask(c, request, row, USES(PARAMS) && count != 0u ? args : &nothing, NONE);
    return finish(c, request);
}

static int wrong_report(exover *c, const exover_request *row, int outcome, int32_t status, const exover_value *results,
                        size_t count)
{
    if (outcome < EXOVER_OK || outcome > EXOVER_INTERRUPTED) {
        return EXOVER_BAD_EVENT;
    }
    if (status != NONE && (status < 0 || outcome != EXOVER_FAILED || status >= row->statuses)) {
        return EXOVER_UNKNOWN_STATUS;
    }
    return outcome == EXOVER_OK ? wrong_values(c, row->results, row->params_end, results, count) : 0;
}

size_t exover_report(exover *c, int32_t request, int32_t slot, enum exover_outcome outcome, int32_t status,
                     const exover_value *results, size_t count)
{
    const bool ready = begin(c);
    if (!ready && (c->cells == NULL || interrupts(c))) {
        return deny(c, request);
    }
    const exover_request *row = slot_at(c, request, slot);
    if (row == NULL || is_wrong(c, wrong_report(c, row, (int)outcome, status, results, count))) {
        return invalid(c, request);
    }
    exover_cell *cell = CELL(PHASES, phase_at(request, row, slot));
    const exover_uint phase = in_phase(cell);
    if (is_wrong(c, phase == EMPTY ? EXOVER_NOT_ACTIVE : 0)) {
        return invalid(c, request);
    }
    if (!ready) {
        set_cell(cell, EMPTY); /* the rest of the state is not trusted any more */
        return deny(c, request);
    }
    const exover_value *args = args_of(c, row, slot);
    occupy(c, request, -1);
    tally(c, row, slot, phase, -1);
    set_phase(c, row, slot, cell, EMPTY, NULL);
    if (USES(LASTS)) {
        put(c, row->last, (exover_int)outcome);
    }
    if (outcome == EXOVER_OK) {
        exover_int end = USES(PASTS) ? END_OF(past, PASTS, row->pasts, row->pasts_end) : NONE;
        for (exover_int i = row->pasts; USES(PASTS) && i < end; i++) {
            const exover_past *past = &ALL(past, PASTS)[i];
            put(c, past->entry, fits(c, row, past->predicate, args, results));
        }
        supply(c, row, row->produces, row->produces_end, args, 1);
    }
    affect(c, &row->effects[outcome]);
    latch(c, outcome == EXOVER_OK ? request : NONE);
    return finish(c, request);
}

size_t exover_observe(exover *c, int32_t poster, exover_value value)
{
    if (!begin(c)) {
        return deny(c, NONE);
    }
    c->wrong = EXOVER_UNKNOWN_POSTER;
    if (!USES(VARIABLES) || poster < 0 || poster >= COUNT(VARIABLES)) {
        return invalid(c, NONE);
    }
    const exover_variable *row = RECORD(variable, VARIABLES, poster);
    if (row->role != POSTER) {
        return invalid(c, NONE);
    }
    exover_value reading = value;
    if (!in_domain(c, &row->domain, value)) {
        c->wrong = EXOVER_OUT_OF_RANGE;
        if (!row->has_fallback) {
            return invalid(c, NONE);
        }
        say_only(c, EXOVER_INVALID, NONE, NONE, c->wrong);
        reading.integer = row->fallback;
        if (row->domain.type == REAL) {
            reading = real_at(c, row->fallback);
        }
    }
    take_reading(c, poster, reading);
    latch(c, NONE);
    return finish(c, NONE);
}

size_t exover_level(exover *c, int32_t stock, int64_t level)
{
    if (!begin(c)) {
        return deny(c, NONE);
    }
    c->wrong = EXOVER_UNKNOWN_POSTER;
    if (!USES(STOCKS) || stock < 0 || stock >= COUNT(STOCKS)) {
        return invalid(c, NONE);
    }
    const exover_stock *row = RECORD(stock, STOCKS, stock);
    c->wrong = EXOVER_OUT_OF_RANGE;
    if (level < 0 || level > row->capacity) {
        return invalid(c, NONE);
    }
    put(c, row->entry, (exover_int)level);
    latch(c, NONE);
    return finish(c, NONE);
}

/* What a faulty checker adds to its answers to an abort: what the host wants to end shall end, whatever is remembered of it. */
static SELDOM size_t stop(exover *c, int32_t request, int32_t slot)
{
    if (interrupts(c)) {
        return 0;
    }
    c->wrong = EXOVER_UNKNOWN_REQUEST;
    if (request < 0 || slot < 0 || (exover_word)request != request || (exover_word)slot != slot) {
        return invalid(c, request);
    }
    if (c->cells != NULL) {
        if (request >= COUNT(REQUESTS)) {
            return invalid(c, request);
        }
        const exover_request *row = &ALL(request, REQUESTS)[request];
        if (slot < instances_of(row)) {
            set_cell(CELL(PHASES, phase_at(request, row, slot)), STOPPING); /* so that its end can be reported */
        }
    }
    say_only(c, EXOVER_KILL, request, slot, EXOVER_ABORTED);
    give_up(c);
    return told(c);
}

SMALL size_t exover_abort(exover *c, int32_t request, int32_t slot)
{
    if (!begin(c)) {
        return stop(c, request, slot);
    }
    const exover_request *row = slot_at(c, request, slot);
    if (row == NULL || is_wrong(c, phase_of(c, request, row, slot) == EMPTY ? EXOVER_NOTHING_TO_ABORT : 0)) {
        if ((c->agenda & FAULTY) == 0u) {
            return invalid(c, request);
        }
        c->steps--;
        leave(c);
        return stop(c, request, slot);
    }
    kill_slot(c, request, row, slot, EXOVER_ABORTED);
    const size_t count = finish(c, request);
    return (c->agenda & FAULTY) != 0u ? stop(c, request, slot) : count;
}

SMALL size_t exover_abort_waiting(exover *c, int32_t request)
{
    if (!begin(c)) {
        return deny(c, request);
    }
    const exover_request *row = slot_at(c, request, 0);
    if (row == NULL || is_wrong(c, is_waiting(c, request, row) ? 0 : EXOVER_NOTHING_TO_ABORT) || !USES(WAITS)) {
        return invalid(c, request);
    }
    vacate(c, request, EXOVER_ABORTED);
    return finish(c, request);
}

/* The record of a request, if the checker knows where it is and has so many slots. */
static const exover_request *known(const exover *c, int32_t request, int32_t slot)
{
    if (c->cells == NULL || !is_sealed(c) || request < 0 || request >= COUNT(REQUESTS)) {
        return NULL;
    }
    const exover_request *row = &ALL(request, REQUESTS)[request];
    return slot >= 0 && slot < instances_of(row) ? row : NULL;
}

SMALL const exover_value *exover_args(exover *c, int32_t request, int32_t slot)
{
    const exover_request *row = known(c, request, slot);
    if (row == NULL) {
        return NULL;
    }
    return params_of(row) == 0 ? c->values : args_of(c, row, slot);
}

/* What stands in a slot, or in the waiting place behind the last. */
static exover_view view(exover *c, int32_t request, const exover_request *row, exover_int slot)
{
    static const exover_phase PHASES[] = {EXOVER_IDLE, EXOVER_RUNNING, EXOVER_STOPPING, EXOVER_WAITING, EXOVER_CLEARING};
    exover_view found = {EXOVER_UNKNOWN, 0u};
    if (row != NULL) {
        const exover_cell *cell = CELL(PHASES, phase_at(request, row, slot));
        if ((cell->now ^ cell->inverse) == (exover_uint)-1 && in_phase(cell) <= CLEARING) {
            found.phase = PHASES[in_phase(cell)];
            found.since = (uint32_t)(cell->now / SINCE);
        }
    }
    return found;
}

SMALL exover_view exover_slot(exover *c, int32_t request, int32_t slot)
{
    return view(c, request, known(c, request, slot), slot);
}

SMALL exover_view exover_place(exover *c, int32_t request)
{
    const exover_request *row = known(c, request, 0);
    return view(c, request, row, row == NULL ? 0 : instances_of(row));
}

uint32_t exover_step(const exover *c)
{
    return (uint32_t)((exover_uint)c->steps * SINCE / SINCE);
}

SMALL size_t exover_arity(const exover *c, int32_t request)
{
    const exover_request *row = known(c, request, 0);
    const exover_int params = row == NULL ? 0 : params_of(row);
    return params < 0 || params > COUNT(PARAMS) ? 0 : (size_t)params;
}

SMALL bool exover_unchecked(const exover *c)
{
    return c->cells != NULL && is_sealed(c) && (c->head[EXOVER_HEAD_FLAGS] & 1);
}

#ifdef EXOVER_DEBUG
exover_spent exover_cost(const exover *c)
{
    exover_spent spent = c->spent;
    spent.actions = (uint32_t)c->count;
    return spent;
}
#endif

exover_status exover_fault(const exover *c)
{
    return cause_of(c);
}

/* ---- loading ---- */

#ifndef EXOVER_SHAPE
/* cppcheck-suppress misra-c2012-20.1 ; it is a part of this file that checkers of one shape leave out */
#include "exover_form.h"

#else /* tables of one shape, whose checksum is known: they are what was emitted, so nothing more is asked of them */

static bool counts_fit(const exover *c, const exover_tables *tables)
{
    (void)c;
    return tables->real_count == SHAPE(EXOVER_REALS) && tables->word_count == SHAPE(EXOVER_WORDS);
}

static bool sections_fit(const exover *c)
{
    (void)c;
    return true;
}

static exover_status form_of(const exover *c)
{
    (void)c;
    return EXOVER_READY;
}

#endif

/* Add a number of so many bytes to the CRC-32 of the tables, and to what scrubbing will compare them with. */
static SELDOM uint32_t add_bytes(exover *c, uint32_t before, uint32_t number, uint32_t counted, uint32_t bytes)
{
    uint32_t sum = before ^ counted;
    for (uint32_t byte = 0; byte < bytes; byte++) {
        sum = add_byte(sum);
    }
    c->whole = mixed(c->whole, number);
    return sum;
}

/* Whether the bytes have the checksum that they say, itself taken as 0. */
static bool bytes_hold(exover *c)
{
    uint32_t sum = 0xffffffffu;
    for (uint32_t at = 0; at < fours(c); at++) {
        const uint32_t four = four_at(c, at);
        sum = add_bytes(c, sum, four, at == (uint32_t)EXOVER_HEAD_CHECKSUM ? 0u : four, 4);
    }
    if (has_rest(c)) {
        sum = add_bytes(c, sum, rest_of(c), rest_of(c), 2);
    }
    return ~sum == SHAPE(EXOVER_CHECKSUM) && c->head[EXOVER_HEAD_CHECKSUM] == SHAPE(EXOVER_CHECKSUM);
}

/* As much as a value has to be aligned. */
struct after_a_byte {
    char byte;
    exover_value value;
};

static bool aligned(const void *array, size_t by)
{
    return address(array) % by == 0u;
}

static exover_status check(exover *c, const exover_tables *tables, const void *memory)
{
    if (tables == NULL || memory == NULL || tables->words == NULL || (tables->reals == NULL && tables->real_count != 0)) {
        return EXOVER_NO_TABLES;
    }
    if (address(memory) % 8u != 0u || !aligned(tables->words, sizeof(exover_word))
        || (tables->real_count != 0 && !aligned(tables->reals, offsetof(struct after_a_byte, value)))) {
        return EXOVER_MISALIGNED;
    }
    if (tables->head[EXOVER_HEAD_MAGIC] != 0x564f5845) { /* "EXOV" */
        return EXOVER_NO_MAGIC;
    }
    if ((tables->head[EXOVER_HEAD_FORMAT] & 0xffff) != 3) {
        return EXOVER_OTHER_FORMAT;
    }
    if (tables->head[EXOVER_HEAD_FORMAT] >> 16 != EXOVER_WIDTH) {
        return EXOVER_OTHER_WIDTH;
    }
    c->head = tables->head;
    c->reals = tables->reals;
    c->words = tables->words;
    if (!counts_fit(c, tables)) {
        return EXOVER_BAD_COUNTS;
    }
    if (!sections_fit(c)) {
        return EXOVER_OTHER_USES;
    }
    if (!bytes_hold(c)) {
        return EXOVER_BAD_CHECKSUM;
    }
    return form_of(c);
}

/* The bytes of so many things of this size, rounded up to 8. */
static uint64_t rounded(size_t size, uint64_t count)
{
    return (size * count + 7) / 8 * 8;
}

/* Give the arrays of the state their places, all wiped; false if they do not fit. docs/runtime.md has the same sum. */
static bool place(exover *c, unsigned char *memory, size_t size)
{
    const uint64_t cells = 8 * (2 * (uint64_t)SHAPE(EXOVER_VALUES) + SHAPE(EXOVER_SCRATCH));
    const uint64_t actions = cells + rounded(sizeof(exover_cell), SHAPE(EXOVER_CELLS));
    const uint64_t path = actions + rounded(sizeof(exover_action), (uint64_t)SHAPE(EXOVER_CAPACITY) + 1); /* one for a fault */
    const uint64_t end = path + rounded(sizeof(exover_word), SHAPE(EXOVER_STEPS));
    if (end > size) {
        return false;
    }
    wipe(memory, (size_t)end);
    /* cppcheck-suppress misra-c2012-11.5 ; a multiple of 8 from where the memory begins, and so aligned */
    c->values = (exover_value *)(void *)memory;
    /* cppcheck-suppress misra-c2012-11.5 ; a multiple of 8 from where the memory begins, and so aligned */
    c->cells = (exover_cell *)(void *)(memory + cells);
    /* cppcheck-suppress misra-c2012-11.5 ; a multiple of 8 from where the memory begins, and so aligned */
    c->actions = (exover_action *)(void *)(memory + actions);
    for (uint32_t i = 0; !USES(LAUNCHES) && i <= SHAPE(EXOVER_CAPACITY); i++) {
        c->actions[i].launch_rule = EXOVER_UNSAID;
    }
    return true;
}

/* Posters and states as they start, every rule to be looked at, everything else idle. */
static void start(exover *c)
{
    for (exover_int i = 0; i < COUNT(ENTRIES); i++) {
        c->cells[SHAPE(EXOVER_VECTOR) + (exover_uint)i].now = (exover_uint)ALL(entry, ENTRIES)[i].initial;
    }
    for (uint32_t i = 0; i < SHAPE(EXOVER_CELLS); i++) {
        c->cells[i].inverse = (exover_uint)~c->cells[i].now;
    }
    for (uint32_t i = 0; i < SHAPE(EXOVER_VALUES); i++) {
        c->values[SHAPE(EXOVER_VALUES) + i].bits = ~c->values[i].bits;
    }
    for (exover_int i = 0; USES(ORDERS) && i < COUNT(VARIABLES); i++) {
        const exover_variable *row = &ALL(variable, VARIABLES)[i];
        if (row->raw >= 0) {
            keep(c, c->values + SHAPE(EXOVER_KEPT) + row->raw, c->reals[row->initial]);
        }
    }
    for (exover_int i = 0; i < COUNT(RULES); i++) {
        set_bit(BITS(DIRTY, i), i, true);
    }
    c->agenda = (COUNT(RULES) ? (uint32_t)DIRTY : 0) | (COUNT(LAUNCHES) ? (uint32_t)REQUIRED | UNSETTLED : 0);
    c->guard = ~c->agenda;
    c->live = EXOVER_IS_LIVE;
    c->seal = seal_of(c);
}

/* Take tables and memory, whatever was there before. */
static SELDOM exover_status take_tables(exover *c, const exover_home *home)
{
    void *const memory = home->memory;
    wipe(c, sizeof *c);
    exover_status found = check(c, home->tables, memory);
    if (found == EXOVER_READY && !place(c, memory, home->size)) {
        found = EXOVER_NO_MEMORY;
    }
    if (found == EXOVER_READY) {
        start(c);
    } else {
        wipe(c, sizeof *c);
        c->fault = found;
    }
    return found;
}

/* Whether a checker was loaded, and so may have launched what still runs: no one bit decides it. */
static SELDOM bool is_live(const exover *c)
{
    return c->live == EXOVER_IS_LIVE || (c->cells != NULL && is_sealed(c));
}

SMALL exover_status exover_load_built(exover *c, const exover_home *home, bool stopped)
{
    if (c == NULL) {
        return EXOVER_NO_TABLES;
    }
    if (home->bytes != sizeof *c || home->build != EXOVER_BUILD) {
        return EXOVER_OTHER_BUILD; /* nothing is written: it is not known what there is room for */
    }
    return !stopped && is_live(c) ? EXOVER_LIVE : take_tables(c, home);
}

#ifndef EXOVER_NO_RESUME
/* cppcheck-suppress misra-c2012-20.1 ; it is a part of this file that a small target leaves out */
#include "exover_resume.h"
#endif
