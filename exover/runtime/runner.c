/* runner.c - the checker as a process of its own: events come on standard input, answers go to standard output.
 *
 * Hosted, unlike exover.c; it is what `exover simulate --engine c` talks to. Words are separated by blanks: indices in
 * decimal, values as the 16 hexadecimal digits of their 64 bits. An event is one of
 *
 *     a REQUEST COUNT VALUES          r REQUEST SLOT OUTCOME STATUS COUNT VALUES      o POSTER VALUE
 *     l STOCK VALUE                   k REQUEST SLOT                                  w REQUEST
 *
 * and its answer a line of actions `KIND REQUEST SLOT REASON LAUNCH_RULE VALUES`, each ended by `;`. `z` starts anew, `f`
 * flushes.
 * With the argument N it reads all events first, then runs them N times and prints the seconds that took.
 */
#include "native_tables.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef struct event {
    char kind;
    int32_t numbers[4];
    size_t count;
    exover_value *values;
} event;

static uint64_t memory[NATIVE_MEMORY_BYTES / 8 + 1];
static exover checker;

static void give_up(const char *why)
{
    fprintf(stderr, "runner: %s\n", why);
    exit(1);
}

static void start(void)
{
    exover_status status = exover_load_stopped(&checker, &native_tables, memory, NATIVE_MEMORY_BYTES);
    if (status != EXOVER_READY) {
        fprintf(stderr, "runner: the tables were refused: %d\n", (int)status);
        exit(1);
    }
}

static int32_t number(void)
{
    long read;
    if (scanf("%ld", &read) != 1)
        give_up("a number is missing");
    return (int32_t)read;
}

static exover_value value(void)
{
    exover_value read;
    if (scanf("%" SCNx64, &read.bits) != 1)
        give_up("a value is missing");
    return read;
}

/* Read an event; false at the end. Its values are allocated once and grow. */
static int read_event(event *e)
{
    int count = 0;
    if (scanf(" %c", &e->kind) != 1)
        return 0;
    switch (e->kind) {
    case 'a': count = 1; break;
    case 'r': count = 4; break;
    case 'o':
    case 'l': count = 1; break;
    case 'k': count = 2; break;
    case 'w': count = 1; break;
    case 'f':
    case 'z': break;
    default: give_up("no such event");
    }
    for (int i = 0; i < count; i++)
        e->numbers[i] = number();
    e->count = e->kind == 'o' || e->kind == 'l' ? 1 : e->kind == 'a' || e->kind == 'r' ? (size_t)number() : 0;
    if (e->count != 0) {
        e->values = realloc(e->values, e->count * sizeof *e->values);
        if (e->values == NULL)
            give_up("no memory");
    }
    for (size_t i = 0; i < e->count; i++)
        e->values[i] = value();
    return 1;
}

static size_t run(const event *e)
{
    const int32_t *n = e->numbers;
    switch (e->kind) {
    case 'a': return exover_ask(&checker, n[0], e->values, e->count);
    case 'r':
        return exover_report(&checker, n[0], n[1], (enum exover_outcome)n[2], n[3], e->values, e->count);
    case 'o': return exover_observe(&checker, n[0], e->values[0]);
    case 'l': return exover_level(&checker, n[0], e->values[0].integer);
    case 'k': return exover_abort(&checker, n[0], n[1]);
    case 'w': return exover_abort_waiting(&checker, n[0]);
    default: return 0;
    }
}

static void print(size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const exover_action *action = &checker.actions[i];
        int32_t request = (int32_t)action->request, slot = (int32_t)action->slot;
        printf("%d %" PRId32 " %" PRId32 " %d %d", (int)action->kind, request, slot, (int)action->reason,
               (int)action->launch_rule);
        if (action->kind == EXOVER_LAUNCH) {
            const exover_value *args = exover_args(&checker, request, slot);
            for (size_t k = 0; args != NULL && k < exover_arity(&checker, request); k++)
                printf(" %016" PRIx64, args[k].bits);
        }
        printf(";");
    }
    printf("\n");
}

static void answer_all(void)
{
    event e = {0, {0}, 0, NULL};
    printf("ready\n");
    fflush(stdout);
    while (read_event(&e)) {
        if (e.kind == 'f')
            fflush(stdout);
        else if (e.kind == 'z')
            start();
        else
            print(run(&e));
    }
    free(e.values);
}

static void measure(long repeats)
{
    size_t length = 0, room = 0;
    event *events = NULL;
    event e = {0, {0}, 0, NULL};
    while (read_event(&e)) {
        if (length == room) {
            room = 2 * room + 64;
            events = realloc(events, room * sizeof *events);
            if (events == NULL)
                give_up("no memory");
        }
        events[length++] = e;
        e.values = NULL;
    }
    free(e.values);
    size_t answers = 0;
    clock_t begin = clock();
    for (long i = 0; i < repeats; i++) {
        for (size_t k = 0; k < length; k++)
            answers += run(&events[k]);
    }
    clock_t end = clock();
    printf("%.9f %zu\n", (double)(end - begin) / CLOCKS_PER_SEC, answers);
    for (size_t k = 0; k < length; k++)
        free(events[k].values);
    free(events);
}

int main(int argc, char **argv)
{
    start();
    if (argc > 1)
        measure(strtol(argv[1], NULL, 10));
    else
        answer_all();
    return ferror(stdout) || fflush(stdout) != 0;
}
