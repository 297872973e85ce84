/* library.c - the checker as a shared library: one call is one event.
 *
 * Hosted, unlike exover.c; it is what `exover gate` loads. An event is six numbers and values: a letter as in runner.c, how
 * many values there are, and what follows the letter there. An answer is six numbers, KIND REQUEST SLOT REASON LAUNCH_RULE
 * COUNT, and COUNT values: the arguments of a launch.
 */
#include "native_tables.h"

typedef struct host {
    exover checker;
    uint64_t memory[NATIVE_MEMORY_BYTES / 8 + 1];
} host;

/* The bytes of a host, which start at a multiple of 8. */
size_t library_bytes(void)
{
    return sizeof(host);
}

/* Start, or start anew; returns an exover_status. */
int library_start(host *self)
{
    return (int)exover_load_stopped(&self->checker, &native_tables, self->memory, NATIVE_MEMORY_BYTES);
}

/* EXOVER_READY, or why everything is denied. */
int library_fault(const host *self)
{
    return (int)exover_fault(&self->checker);
}

static size_t take(exover *r2c, char letter, const int32_t *n, const exover_value *values, size_t count)
{
    switch (letter) {
    case 'a': return exover_ask(r2c, n[0], values, count);
    case 'r': return exover_report(r2c, n[0], n[1], (enum exover_outcome)n[2], n[3], values, count);
    case 'o': return exover_observe(r2c, n[0], values[0]);
    case 'l': return exover_level(r2c, n[0], values[0].integer);
    case 'k': return exover_abort(r2c, n[0], n[1]);
    case 'w': return exover_abort_waiting(r2c, n[0]);
    default: return 0;
    }
}

/* Take an event and write the status and its answers to `said`, which has room for them all; returns how many there are. */
size_t library_step(host *self, const int32_t *sent, int64_t *said)
{
    exover *r2c = &self->checker;
    const size_t answers = exover_verify(r2c, take(r2c, (char)sent[0], sent + 2, (const void *)(sent + 6), (size_t)sent[1]));
    *said++ = library_fault(self);
    for (size_t i = 0; i < answers; i++) {
        const exover_action *action = &r2c->actions[i];
        const bool launch = action->kind == EXOVER_LAUNCH;
        const exover_value *args = launch ? exover_args(r2c, (int32_t)action->request, (int32_t)action->slot) : NULL;
        const size_t arity = args == NULL ? 0 : exover_arity(r2c, (int32_t)action->request);
        const int64_t head[] = {action->kind, action->request, action->slot, action->reason, action->launch_rule, (int64_t)arity};
        for (size_t k = 0; k < sizeof head / sizeof *head; k++)
            *said++ = head[k];
        for (size_t k = 0; k < arity; k++)
            *said++ = args[k].integer;
    }
    return answers;
}
