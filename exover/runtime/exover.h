/* exover.h - the checker of an exover spec: asks, reports and readings in; launches, waits, rejections and kills out.
 *
 * C99, freestanding: no heap, no recursion, no library calls, no floating point in the diagrams. The caller owns all
 * memory. The tables are those that `exover emit --target c` writes beside this file; docs/runtime.md describes them.
 *
 *     static uint64_t memory[ROVER_MEMORY_BYTES / 8];
 *     static exover r2c;
 *     exover_load(&r2c, &rover_tables, memory, sizeof memory);
 *     size_t count = exover_ask(&r2c, ROVER_ND_GOTO, args, 3);
 *     count = exover_verify(&r2c, count);
 *     for (size_t i = 0; i < count; i++) obey(&r2c.actions[i]);
 *
 * Whatever goes wrong denies: after a failed load or a fault every ask is answered by a rejection.
 * Decisions on what must never be active together are taken twice, by the diagrams and by bit rows; what the checker
 * remembers is kept with its complement, and every step looks at a few bytes of the tables again.
 * Not thread-safe: one checker belongs to one thread at a time, is neither moved nor copied, and is not called from what
 * interrupts one of its calls: that is a fault. Different checkers share nothing but constants.
 */
#ifndef EXOVER_H
#define EXOVER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifndef EXOVER_WIDTH
#include "exover_config.h"
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* The numbers of the tables have EXOVER_WIDTH bytes, those of the state vector EXOVER_STATE bytes. */
#if EXOVER_WIDTH == 2
typedef int16_t exover_word;
#elif EXOVER_WIDTH == 4
typedef int32_t exover_word;
#elif EXOVER_WIDTH == 8
typedef int64_t exover_word;
#else
#error "EXOVER_WIDTH must be 2, 4 or 8"
#endif

#ifndef EXOVER_STATE
#if EXOVER_WIDTH == 2
#define EXOVER_STATE 4
#else
#define EXOVER_STATE 8
#endif
#endif
#if EXOVER_STATE == 4
typedef int32_t exover_int;
typedef uint32_t exover_uint;
#elif EXOVER_STATE == 8
typedef int64_t exover_int;
typedef uint64_t exover_uint;
#else
#error "EXOVER_STATE must be 4 or 8"
#endif

/* Which sections and actions the tables use, one bit each; code for the others is left out, and tables that use them are refused.
 * With EXOVER_SHAPE, the numbers of `enum exover_shape`, only the tables of that shape and that checksum are taken. */
#ifndef EXOVER_USES
#define EXOVER_USES 0x1ffffff
#endif

/* Whether slots count alike, whatever their arguments. */
#ifndef EXOVER_PLAIN
#define EXOVER_PLAIN 0
#endif

/* How many bytes of the tables every step looks at again, a multiple of 4, besides a cell or value; 0 for neither. */
#ifndef EXOVER_SCRUB
#define EXOVER_SCRUB 4
#endif

/* ---- one build ---- */

/* The version of this runtime, which is that of the toolkit that emitted it. */
#define EXOVER_VERSION_MAJOR 0
#define EXOVER_VERSION_MINOR 1
#define EXOVER_VERSION_PATCH 0
#define EXOVER_VERSION "0.1.0"

/* Host and runtime have to be compiled alike. What decides how a checker is laid out is part of the name of every
 * function, so others do not link; the version, the size and all of it again are compared when tables are loaded. */
#ifdef EXOVER_SHAPE
#define EXOVER_TAKES fixed
#define EXOVER_IS_FIXED 1u
#else
#define EXOVER_TAKES any
#define EXOVER_IS_FIXED 0u
#endif
#ifdef EXOVER_DEBUG
#define EXOVER_KIND_OF_BUILD debug
#define EXOVER_IS_DEBUG 1u
#else
#define EXOVER_KIND_OF_BUILD release
#define EXOVER_IS_DEBUG 0u
#endif
#define EXOVER_BUILD \
    ((uint32_t)EXOVER_VERSION_MAJOR << 26 | (uint32_t)EXOVER_VERSION_MINOR << 18 | (uint32_t)EXOVER_VERSION_PATCH << 10 \
     | (uint32_t)EXOVER_IS_DEBUG << 9 | (uint32_t)EXOVER_IS_FIXED << 8 | (uint32_t)EXOVER_STATE << 4 \
     | (uint32_t)EXOVER_WIDTH)
/* cppcheck-suppress misra-c2012-20.10 ; the configuration is part of the name */
#define EXOVER_JOIN(name, width, state, takes, kind) name##_##width##_##state##_##takes##_##kind
#define EXOVER_JOINED(name, width, state, takes, kind) EXOVER_JOIN(name, width, state, takes, kind)
#define EXOVER_NAME(name) EXOVER_JOINED(name, EXOVER_WIDTH, EXOVER_STATE, EXOVER_TAKES, EXOVER_KIND_OF_BUILD)
#define exover_abort EXOVER_NAME(exover_abort)
#define exover_abort_waiting EXOVER_NAME(exover_abort_waiting)
#define exover_args EXOVER_NAME(exover_args)
#define exover_arity EXOVER_NAME(exover_arity)
#define exover_ask EXOVER_NAME(exover_ask)
#define exover_cost EXOVER_NAME(exover_cost)
#define exover_export EXOVER_NAME(exover_export)
#define exover_fault EXOVER_NAME(exover_fault)
#define exover_holds EXOVER_NAME(exover_holds)
#define exover_level EXOVER_NAME(exover_level)
#define exover_load_built EXOVER_NAME(exover_load_built)
#define exover_observe EXOVER_NAME(exover_observe)
#define exover_report EXOVER_NAME(exover_report)
#define exover_resume_built EXOVER_NAME(exover_resume_built)
#define exover_swap_built EXOVER_NAME(exover_swap_built)
#define exover_place EXOVER_NAME(exover_place)
#define exover_slot EXOVER_NAME(exover_slot)
#define exover_step EXOVER_NAME(exover_step)
#define exover_scrub EXOVER_NAME(exover_scrub)
#define exover_unchecked EXOVER_NAME(exover_unchecked)
#define exover_verify EXOVER_NAME(exover_verify)

/* What an event has cost; with EXOVER_DEBUG it is counted and asserted. */
#ifdef EXOVER_DEBUG
typedef struct exover_spent {
    uint32_t tests, actions, passes;
} exover_spent;
#endif

/* ---- values and answers ---- */

/* An argument, result or reading: `real` for a real, else `integer`: a bool is 0 or 1, an enum value its index. */
typedef union exover_value {
    int64_t integer;
    double real;
    uint64_t bits;
} exover_value;

/* Any two of these, and 0, which is none, differ in seven bits. */
enum exover_kind {
    EXOVER_LAUNCH = 0x1e76, /* start `slot` of `request`; exover_args() has the arguments; `reason` if a rule starts it at once */
    EXOVER_WAIT = 0x4bdc, /* `request` took its waiting place, for `reason` */
    EXOVER_REJECT = 0x45aa, /* `request` is refused, for `reason` */
    EXOVER_KILL = 0x2f5b, /* stop `slot` of `request`, for `reason` */
    EXOVER_VIOLATION = 0x7455, /* the rule `reason` could not be restored */
    EXOVER_INVALID = 0x1369 /* the event was none; `reason` is an exover_invalid; nothing was done */
};

/* Reasons from 0 are those of the spec (its _names.c has their texts); the first of them is `busy`. */
enum exover_reason {
    EXOVER_BUSY = 0,
    EXOVER_UNSAID = -1,     /* of a launch that no launch rule starts at once */
    EXOVER_SUPERSEDED = -2, /* a newer ask of the same request took the waiting place */
    EXOVER_ABORTED = -3,    /* the host's own abort */
    EXOVER_FAULTY = -4      /* the checker is faulty and denies everything */
};

enum exover_invalid {
    EXOVER_BAD_EVENT = 1,
    EXOVER_UNKNOWN_REQUEST,
    EXOVER_UNKNOWN_POSTER,
    EXOVER_UNKNOWN_ARGUMENT, /* more values than parameters */
    EXOVER_MISSING_ARGUMENT, /* fewer */
    EXOVER_OUT_OF_RANGE,     /* also NaN and infinities; of a poster with an `else` value: it was taken as that */
    EXOVER_UNKNOWN_STATUS,
    EXOVER_NOT_ACTIVE,
    EXOVER_NOTHING_TO_ABORT
};

/* Fields that say nothing for a kind are -1. What comes of a required launch, at once or after it has waited, has that
 * launch rule as its `launch_rule`, by the index that it has as a reason; EXOVER_UNSAID of what was asked for. */
typedef struct exover_action {
    exover_word kind;
    exover_word request;
    exover_word slot;
    exover_word reason;
    exover_word launch_rule;
    exover_word check; /* of all others: see exover_holds() */
} exover_action;

enum exover_outcome { EXOVER_OK = 1, EXOVER_FAILED = 2, EXOVER_INTERRUPTED = 3 };

/* What exover_load found, and what exover_fault tells: every cause has a code of its own. */
typedef enum exover_status {
    EXOVER_READY = 0,
    EXOVER_NOT_LOADED,   /* exover_load was never called */
    EXOVER_NO_TABLES,    /* a pointer is NULL */
    EXOVER_NO_MAGIC,     /* not a table at all */
    EXOVER_OTHER_FORMAT, /* the format has another version */
    EXOVER_OTHER_WIDTH,  /* this runtime was compiled for another EXOVER_WIDTH */
    EXOVER_OTHER_USES,   /* this runtime was compiled for an EXOVER_USES that leaves out what the tables need */
    EXOVER_BAD_COUNTS,   /* the numbers of records do not give the size of the arrays */
    EXOVER_BAD_CHECKSUM, /* a bit has changed */
    EXOVER_BAD_INDEX,    /* a number points outside of what it counts */
    EXOVER_BAD_NODE,     /* a child stands before its parent, or an action is none */
    EXOVER_BAD_SUM,      /* a sum is part of a sum */
    EXOVER_BAD_LIMITS,   /* the bounds are none */
    EXOVER_MISALIGNED,   /* the memory does not start at a multiple of 8, or the tables not where their numbers may */
    EXOVER_NO_MEMORY,    /* the memory is smaller than *_MEMORY_BYTES */
    /* Found while running, in tables that were well-formed or in a state that was sound. */
    EXOVER_FAULT_PATH,     /* a diagram did more than its bound allows, or turned back */
    EXOVER_FAULT_ACTIONS,  /* an event had more answers than its bound allows */
    EXOVER_FAULT_PASSES,   /* settling took longer than its bound allows */
    EXOVER_FAULT_DECISION, /* a decision that decides nothing, or launches where no slot is idle */
    EXOVER_FAULT_CHANNELS, /* the diagrams and the bit rows do not agree */
    EXOVER_FAULT_INDEX,    /* a number points outside of what it counts */
    EXOVER_FAULT_STATE,    /* what is remembered is not what its complement says */
    EXOVER_FAULT_TABLES,   /* the checksum of the tables is not what it was */
    EXOVER_FAULT_CHECKER,  /* the checker was moved or copied, or does not know any more where its tables and memory are */
    EXOVER_FAULT_REENTRY,  /* it was called while one of its calls was running */
    EXOVER_FAULT_ANSWERS,  /* what was answered has changed since: exover_verify() */
    EXOVER_OTHER_BUILD,    /* of exover_load: host and runtime were compiled for different checkers; nothing was written */
    /* Why a checker is not loaded, resumed or swapped; it stays as it is, but where it was resumed in vain. */
    EXOVER_LIVE,         /* it is loaded: the host has to say that everything was stopped */
    EXOVER_BAD_RECORD,   /* no record, of another version, cut short, or a bit has changed */
    EXOVER_OTHER_TABLES, /* a record or a map of other tables */
    EXOVER_STALE,        /* a record that is not of the last step of this checker */
    EXOVER_BAD_VALUE,    /* a number of a record that is out of range */
    EXOVER_BROKEN_RULE,  /* what is active breaks a rule */
    EXOVER_BAD_MAP,      /* no map, of another version, cut short, or a bit has changed */
    EXOVER_STILL_ACTIVE  /* a request has to end before the tables are swapped */
} exover_status;

/* ---- tables: constant, emitted; the records are described in docs/runtime.md ---- */

enum { /* the header, as little-endian words of 32 bits */
    EXOVER_HEAD_MAGIC,
    EXOVER_HEAD_FORMAT, /* version in the low half, width in the high half */
    EXOVER_HEAD_FLAGS,
    EXOVER_HEAD_CHECKSUM,
    EXOVER_HEAD_REALS,
    EXOVER_HEAD_DIGEST,
    EXOVER_HEAD_COUNTS = 13,
    EXOVER_SECTIONS = 20,
    EXOVER_HEAD_CHECKS = EXOVER_HEAD_COUNTS + EXOVER_SECTIONS,
    EXOVER_HEAD_WORDS
};

/* The shape of tables and memory: where the words of each section begin, and those of the next; how many records each
 * section has; where the check words of each begin, and those of the doubles, 0 if there are none; where the cells of the
 * state begin; and how much there is of the rest. */
enum exover_shape {
    EXOVER_STARTS = 0,
    EXOVER_COUNTS = EXOVER_STARTS + EXOVER_SECTIONS + 1,
    EXOVER_REALS = EXOVER_COUNTS + EXOVER_SECTIONS,
    EXOVER_CHECKS,
    EXOVER_WORDS = EXOVER_CHECKS + EXOVER_SECTIONS + 1,
    EXOVER_VECTOR, /* the entries that the diagrams test: from 0 */
    EXOVER_PHASES, /* of every request: its slots, then its waiting place */
    EXOVER_HELD,   /* of every request, how many slots are active: for the bit rows alone, as the next */
    EXOVER_ACTIVE, /* bits: requests of which a slot is active, 16 to a cell */
    EXOVER_DIRTY,  /* bits, 32 to a cell: rules to look at */
    EXOVER_BROKEN, /* rules that could not be restored */
    EXOVER_TAKEN,  /* requests whose waiting place is taken */
    EXOVER_ORIGINS, /* if there are launch rules, of every request: the reason of the rule that put there what waits, + 1 */
    EXOVER_REFUSED, /* of every launch rule, for what the last step refused it: twice (a reason + 1), or 0 if it did not */
    EXOVER_MARKS,  /* for one step: launch rules that were tried, requests that fell to waiting */
    EXOVER_CELLS,
    EXOVER_KEPT,     /* arguments of slots and waiting places */
    EXOVER_VALUES,   /* these, and real posters that are compared with other reals */
    EXOVER_SCRATCH,  /* arguments of a required launch */
    EXOVER_CAPACITY, /* answers of one event */
    EXOVER_STEPS,    /* actions of one path */
    EXOVER_CHECKSUM,
    EXOVER_SHAPE_SIZE
};

typedef struct exover_tables {
    uint32_t head[EXOVER_HEAD_WORDS];
    const exover_value *reals;
    size_t real_count;
    const exover_word *words;
    size_t word_count;
} exover_tables;

typedef struct exover_node {
    exover_word code, bound, low, high;
} exover_node;
typedef struct exover_entry {
    exover_word initial, rules, rules_end, sums, sums_end;
} exover_entry;
typedef struct exover_request {
    exover_word decide, slots, instances, values, interrupts_self, statuses;
    exover_word params, results, params_end, orders, orders_end, features, features_end, pasts, pasts_end;
    exover_word consumes, produces, produces_end;
    exover_word effects[5]; /* on launch, ok, failed, interrupted; the end */
    exover_word last, conflicts, conflicts_end;
} exover_request;
typedef struct exover_domain {
    exover_word type, low, high;
} exover_domain;
typedef struct exover_gauge {
    exover_word cuts, cuts_end, value, rank;
} exover_gauge;
typedef struct exover_param {
    exover_domain domain;
    exover_gauge gauge;
} exover_param;
typedef struct exover_order {
    exover_word left, right, entry;
} exover_order;
typedef struct exover_feature {
    exover_word predicate, slot, weight, entries[4]; /* running, stopping, waiting, clearing */
} exover_feature;
typedef struct exover_past {
    exover_word predicate, entry;
} exover_past;
typedef struct exover_amount {
    exover_word stock, amount, predicate;
} exover_amount;
typedef struct exover_effect {
    exover_word kind, target, value;
} exover_effect;
typedef struct exover_variable {
    exover_word role;
    exover_domain domain;
    exover_word initial, has_fallback, fallback;
    exover_gauge gauge;
    exover_word raw, refresh, refresh_end, orders, orders_end;
} exover_variable;
typedef struct exover_latch {
    exover_word variable, condition, resets, resets_end;
} exover_latch;
typedef struct exover_stock {
    exover_word capacity, initial, entry;
} exover_stock;
typedef struct exover_rule {
    exover_word root, reason;
} exover_rule;
typedef struct exover_launch_rule {
    exover_word condition, request, args, reason;
} exover_launch_rule;
typedef struct exover_limits {
    exover_word tests, actions, passes, violations;
} exover_limits;
typedef struct exover_conflict {
    exover_word block, mask; /* bit i of the mask is request 16 * block + i */
} exover_conflict;
typedef struct exover_reason_row {
    exover_word denials;
} exover_reason_row;
typedef struct exover_invariant {
    exover_word root, reason;
} exover_invariant;
typedef struct exover_sum {
    exover_word entry, factor;
} exover_sum;

/* ---- a checker ---- */

/* What is remembered, and its complement. */
typedef struct exover_cell {
    exover_uint now, inverse;
} exover_cell;

typedef struct exover {
    exover_action *actions; /* the answers to the last event, in order; valid until the next */

    /* What follows is private: first what does not change, all of it under the seal. */
    const uint32_t *head;
    const exover_value *reals;
    const exover_word *words;
    exover_value *values; /* then their complements, then the arguments of a required launch */
    exover_cell *cells;
#ifndef EXOVER_SHAPE
    uint32_t shape[EXOVER_SHAPE_SIZE];
#endif
    uintptr_t seal;

    volatile exover_status fault; /* volatile, as the guard: a call may interrupt a step */
    volatile uint32_t guard;      /* the complement of the agenda, but of a faulty checker, and while a step runs */
    uint32_t agenda;              /* what the end of a step has to look at */
    uint32_t scrubbed, sum; /* fours of bytes of the tables, and what they add up to */
    uint32_t whole;         /* what all of them add up to */
    uint32_t compared;      /* cells and values that were compared with their complements */
    uint32_t steps;         /* events that were taken */
    uint32_t live;          /* EXOVER_IS_LIVE since it was loaded */

    /* For one step. */
    const exover_value *loaded_args; /* whose values the entries of arguments have now */
    const exover_value *loaded_results;
    exover_int count; /* of actions */
    uint32_t said;    /* places of actions behind which all have the kind 0 */
    exover_word origin; /* the reason of the launch rule that what is being decided comes of */
    int wrong;        /* with the event: an exover_invalid */
    bool changed;
    exover_cell spare;    /* where a number that points nowhere leads */
    exover_action denial; /* the only action of a checker without memory */
#ifdef EXOVER_DEBUG
    exover_spent spent;
#endif
} exover;

/* Take tables into use, in their initial state; `memory` starts at a multiple of 8 and belongs to `r2c` from now on.
 * Tables and memory stay where they are as long as `r2c` is used. Before it is loaded for the first time all of `r2c` is 0.
 * Everything is checked here once. Returns EXOVER_READY, else why `r2c` denies everything from now on; but EXOVER_LIVE if
 * it is loaded already, faulty or not: what runs would be forgotten, so it stays as it is.
 * Bound: one look at every byte of the tables and of the memory. */
static inline exover_status exover_load(exover *r2c, const exover_tables *tables, void *memory, size_t size);

/* The same, also if it is loaded already: the host says that everything it has launched was stopped. */
static inline exover_status exover_load_stopped(exover *r2c, const exover_tables *tables, void *memory, size_t size);

/* Write what is remembered into a record, *_RECORD_BYTES of them; returns how many bytes it has, 0 if there is no room, or
 * if `r2c` is faulty or finds that it is. Bound: one look at all that is remembered. */
size_t exover_export(exover *r2c, void *record, size_t size);

/* As exover_load, but in the state of a record, which is held against the tables first: every number in its range, no rule
 * broken. Over a checker that is loaded already only if that is faulty and the record is of the last step before.
 * Bound: one look at every byte of the tables, of the memory and of the record, and at every rule. */
static inline exover_status exover_resume(exover *r2c, const exover_tables *tables, void *memory, size_t size,
                                          const void *record, size_t bytes);

/* Go on by other tables, in the state of a record of those before, by a map that `exover swap` has made. Over a checker that
 * is loaded already only if the record is of its last step; then `memory` is not that of before. What waits is decided anew:
 * `count` of `r2c->actions` answer that. Bound: that of exover_resume, and *_PASSES passes. */
static inline exover_status exover_swap(exover *r2c, const exover_tables *tables, void *memory, size_t size,
                                        const void *record, size_t bytes, const void *map, size_t map_bytes, size_t *count);

/* In idle time: look at the next `bytes` of the tables, rounded up to fours, and at one cell or value for each four.
 * Returns EXOVER_READY, or why everything is denied from the next event on. Bound: one look at each of these bytes. */
exover_status exover_scrub(exover *r2c, uint32_t bytes);

/* What these call, with the size of a checker and the build as the host knows them. */
typedef struct exover_home {
    const exover_tables *tables;
    void *memory;
    size_t size, bytes;
    uint32_t build;
} exover_home;
exover_status exover_load_built(exover *r2c, const exover_home *where, bool stopped);
exover_status exover_resume_built(exover *r2c, const exover_home *where, const void *record, size_t size);
exover_status exover_swap_built(exover *r2c, const exover_home *where, const void *record, size_t size, const void *map,
                                size_t map_size, size_t *count);

static inline exover_status exover_load(exover *r2c, const exover_tables *tables, void *memory, size_t size)
{
    const exover_home where = {tables, memory, size, sizeof(exover), EXOVER_BUILD};
    return exover_load_built(r2c, &where, false);
}

static inline exover_status exover_load_stopped(exover *r2c, const exover_tables *tables, void *memory, size_t size)
{
    const exover_home where = {tables, memory, size, sizeof(exover), EXOVER_BUILD};
    return exover_load_built(r2c, &where, true);
}

static inline exover_status exover_resume(exover *r2c, const exover_tables *tables, void *memory, size_t size,
                                          const void *record, size_t bytes)
{
    const exover_home where = {tables, memory, size, sizeof(exover), EXOVER_BUILD};
    return exover_resume_built(r2c, &where, record, bytes);
}

static inline exover_status exover_swap(exover *r2c, const exover_tables *tables, void *memory, size_t size,
                                        const void *record, size_t bytes, const void *map, size_t map_bytes, size_t *count)
{
    const exover_home where = {tables, memory, size, sizeof(exover), EXOVER_BUILD};
    return exover_swap_built(r2c, &where, record, bytes, map, map_bytes, count);
}

/* Whether the tables were emitted although the checks of their spec do not hold. Bound: constant. */
bool exover_unchecked(const exover *r2c);

/* EXOVER_READY, or why everything is denied, whatever bits have changed. Bound: constant. */
exover_status exover_fault(const exover *r2c);

/* Each of the following takes one event, updates the state, and returns the number of `r2c->actions` that answer it;
 * none to a call that interrupts another, which is a fault.
 * Bound of each: as many tests and actions as the emitted constants *_TESTS and *_ACTIONS say. */

/* Somebody asks for `request` with these arguments, in the order of its parameters. */
size_t exover_ask(exover *r2c, int32_t request, const exover_value *args, size_t count);

/* A slot has ended. `status` is the index of a failure, -1 for none; results count only with EXOVER_OK. */
size_t exover_report(exover *r2c, int32_t request, int32_t slot, enum exover_outcome outcome, int32_t status,
                     const exover_value *results, size_t count);

/* A poster reads `value`. */
size_t exover_observe(exover *r2c, int32_t poster, exover_value value);

/* The consumable resource has this level. */
size_t exover_level(exover *r2c, int32_t stock, int64_t level);

/* Slot `slot` shall end, which a faulty checker always answers by a kill; what waits at `request` is given up. */
size_t exover_abort(exover *r2c, int32_t request, int32_t slot);
size_t exover_abort_waiting(exover *r2c, int32_t request);

/* Whether an answer, or a copy of it, is what was answered: any one bit that has changed is found. One whose kind is 0 is
 * none. Bound: constant. */
bool exover_holds(const exover_action *action);

/* The `count` that an event returned, if it and all answers are what they were. If not, the checker is faulty, and what
 * stands in `r2c->actions` then is the kills that hold, and rejections. The typed API does this for each event.
 * Bound: one look at each answer. */
size_t exover_verify(exover *r2c, size_t count);

#ifdef EXOVER_DEBUG
/* What the last event has cost. Bound: constant. */
exover_spent exover_cost(const exover *r2c);
#endif

/* The arguments that a slot was launched with last, kept when it has ended; 0 before its first launch. NULL if there is no
 * such slot, or if they are not what their complements say, which is a fault. Bound: constant. */
const exover_value *exover_args(exover *r2c, int32_t request, int32_t slot);

/* What a slot (the first three) or a waiting place holds: a slot is active while it runs and while it stops, a place is
 * taken while it waits and while its way is cleared. */
typedef enum exover_phase {
    EXOVER_IDLE,
    EXOVER_RUNNING,
    EXOVER_STOPPING,
    EXOVER_WAITING,
    EXOVER_CLEARING,
    EXOVER_UNKNOWN /* there is no such slot, or what is remembered has changed, which is a fault */
} exover_phase;

/* `since` is the number of the step that has put it into this phase; 0 since loading. */
typedef struct exover_view {
    exover_phase phase;
    uint32_t since;
} exover_view;

/* What a slot holds, and the waiting place of a request; of a faulty checker, what it remembers. Bound: constant. */
exover_view exover_slot(exover *r2c, int32_t request, int32_t slot);
exover_view exover_place(exover *r2c, int32_t request);

/* The number of the last step: how many events were taken since loading, whatever they were; modulo 2^29 if EXOVER_STATE
 * is 4, else 2^32, as is each `since`. Bound: constant. */
uint32_t exover_step(const exover *r2c);

/* The number of parameters of a request; 0 if there is no such request. Bound: constant. */
size_t exover_arity(const exover *r2c, int32_t request);

#ifdef __cplusplus
}
#endif

#endif
