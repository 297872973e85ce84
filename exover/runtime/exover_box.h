/* exover_box.h - a black box: the last events and answers of a checker, in memory that the caller owns.
 *
 *     static uint8_t memory[EXOVER_BOX_BYTES(1000)];
 *     static exover_box box;
 *     exover_box_open(&box, &r2c, memory, sizeof memory);
 *     size_t count = exover_box_ask(&box, &r2c, ROVER_ND_GOTO, args, 3);
 *
 * C99, freestanding, on the API of exover.h alone. An event is written before the checker sees it, its answers before
 * they are returned. Nothing that is wrong with a box changes an answer: at worst nothing is written. docs/runtime.md
 * describes the bytes, which `exover replay` reads.
 */
#ifndef EXOVER_BOX_H
#define EXOVER_BOX_H

#include "exover.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { EXOVER_BOX_HEADER = 64, EXOVER_BOX_LINE = 32 }; /* bytes */

/* The memory of so many lines. An event takes 2, 1 for each two values, and 1 for each answer. */
#define EXOVER_BOX_BYTES(lines) ((size_t)EXOVER_BOX_HEADER + (size_t)EXOVER_BOX_LINE * (lines))

#define exover_box_abort EXOVER_NAME(exover_box_abort)
#define exover_box_abort_waiting EXOVER_NAME(exover_box_abort_waiting)
#define exover_box_ask EXOVER_NAME(exover_box_ask)
#define exover_box_level EXOVER_NAME(exover_box_level)
#define exover_box_observe EXOVER_NAME(exover_box_observe)
#define exover_box_open EXOVER_NAME(exover_box_open)
#define exover_box_report EXOVER_NAME(exover_box_report)

/* Private: where the memory is, and how far it is written, each with what tells that it has changed. Wiped, it is no box. */
typedef struct exover_box {
    uint8_t *memory;
    uint32_t lines;
    uintptr_t seal;
    uint64_t written, unwritten; /* lines, and the complement */
} exover_box;

/* Open a box in this memory, for a checker that was loaded. What was written there for the same tables is kept.
 * Returns whether there is a box: false if the checker is not loaded, or if there is no room for a line.
 * Bound: one look at every byte of the memory. */
bool exover_box_open(exover_box *box, const exover *r2c, void *memory, size_t size);

/* Each of these is the function of exover.h without `_box`, verified: returns the number of answers that hold.
 * Bound: that of the function, and one line for each answer and each two values. */
size_t exover_box_ask(exover_box *box, exover *r2c, int32_t request, const exover_value *args, size_t count);
size_t exover_box_report(exover_box *box, exover *r2c, int32_t request, int32_t slot, enum exover_outcome outcome,
                         int32_t status, const exover_value *results, size_t count);
size_t exover_box_observe(exover_box *box, exover *r2c, int32_t poster, exover_value value);
size_t exover_box_level(exover_box *box, exover *r2c, int32_t stock, int64_t level);
size_t exover_box_abort(exover_box *box, exover *r2c, int32_t request, int32_t slot);
size_t exover_box_abort_waiting(exover_box *box, exover *r2c, int32_t request);

#ifdef __cplusplus
}
#endif

#endif
