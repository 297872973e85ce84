/* exover.h - the checker of an exover spec: asks, reports and readings in; launches, waits, rejections and kills out.
 *
 * C99, freestanding: no heap, no recursion, no library calls, no floating point in the diagrams. The caller owns all
 * memory. The tables are those that `exover emit --target c` writes beside this file; docs/runtime.md describes them.
 *
 *     static uint64_t memory[ROVER_MEMORY_BYTES / 8];
 *     static exover r2c;
 *     exover_load(&r2c, &rover_tables, memory, sizeof memory);
 *     size_t count = exover_ask(&r2c, ROVER_ND_GOTO, args, 3);
 *     for (size_t i = 0; i < count; i++) obey(&r2c.actions[i]);
 *
 * Whatever goes wrong denies: after a failed load or a fault every ask is answered by a rejection.
 * Decisions on what must never be active together are taken twice, by the diagrams and by bit rows; what the checker
 * remembers is kept with its complement, and every step looks at a few bytes of the tables again.
 * Not thread-safe: one checker belongs to one thread at a time. Different checkers share nothing but constants.
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

/* Which sections the tables use, one bit each; code for the others is left out, and tables that use them are refused.
 * With EXOVER_SHAPE, the numbers of `enum exover_shape`, only the tables of that shape and that checksum are taken. */
#ifndef EXOVER_USES
#define EXOVER_USES 0xfffff
#endif

/* Whether slots count alike, whatever their arguments. */
#ifndef EXOVER_PLAIN
#define EXOVER_PLAIN 0
#endif

/* How many bytes of the tables every step looks at again, a multiple of 4, besides a cell or value; 0 for neither. */
#ifndef EXOVER_SCRUB
#define EXOVER_SCRUB 4
#endif

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

enum exover_kind {
    EXOVER_LAUNCH = 1, /* start `slot` of `request`; exover_args() has the arguments; `reason` if a rule starts it at once */
    EXOVER_WAIT,       /* `request` took its waiting place, for `reason` */
    EXOVER_REJECT,     /* `request` is refused, for `reason` */
    EXOVER_KILL,       /* stop `slot` of `request`, for `reason` */
    EXOVER_VIOLATION,  /* the rule `reason` could not be restored */
    EXOVER_INVALID     /* the event was none; `reason` is an exover_invalid; nothing was done */
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
    EXOVER_MISALIGNED,   /* the memory does not start at a multiple of 8 */
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
    EXOVER_FAULT_CHECKER   /* the checker does not know any more where its tables and its memory are */
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
    EXOVER_SECTIONS = 19,
    EXOVER_HEAD_WORDS = 32
};

/* The shape of tables and memory: where the words of each section begin, and those of the next; how many records each
 * section has; where the cells of the state begin; and how much there is of the rest. */
enum exover_shape {
    EXOVER_STARTS = 0,
    EXOVER_COUNTS = EXOVER_STARTS + EXOVER_SECTIONS + 1,
    EXOVER_REALS = EXOVER_COUNTS + EXOVER_SECTIONS,
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

    exover_status fault;
    uint32_t agenda, guard; /* what the end of a step has to look at; its complement, but of a faulty checker */
    uint32_t scrubbed, sum; /* fours of bytes of the tables whose checksum this is */
    uint32_t compared;      /* cells and values that were compared with their complements */

    /* For one step. */
    const exover_value *loaded_args; /* whose values the entries of arguments have now */
    const exover_value *loaded_results;
    exover_int count; /* of actions */
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
 * Tables and memory stay where they are as long as `r2c` is used.
 * Everything is checked here once. Returns EXOVER_READY, else why `r2c` denies everything from now on.
 * Bound: one look at every byte of the tables and of the memory. */
exover_status exover_load(exover *r2c, const exover_tables *tables, void *memory, size_t size);

/* Whether the tables were emitted although the checks of their spec do not hold. Bound: constant. */
bool exover_unchecked(const exover *r2c);

/* EXOVER_READY, or why everything is denied. Bound: constant. */
exover_status exover_fault(const exover *r2c);

/* Each of the following takes one event, updates the state, and returns the number of `r2c->actions` that answer it.
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

/* Slot `slot` shall end; what waits at `request` is given up. */
size_t exover_abort(exover *r2c, int32_t request, int32_t slot);
size_t exover_abort_waiting(exover *r2c, int32_t request);

#ifdef EXOVER_DEBUG
/* What the last event has cost. Bound: constant. */
exover_spent exover_cost(const exover *r2c);
#endif

/* The arguments that a slot was launched with; NULL if there is no such slot. Bound: constant. */
const exover_value *exover_args(const exover *r2c, int32_t request, int32_t slot);

/* The number of parameters of a request; 0 if there is no such request. Bound: constant. */
size_t exover_arity(const exover *r2c, int32_t request);

#ifdef __cplusplus
}
#endif

#endif
