/* Stops in the middle of a step, changes what only a bit that has changed there could, and goes on. For tests: hosted; it
 * includes exover.c, and so can call what a step consists of.
 *
 * Requests: 0 has arguments and a result, 1 waits for it, 2 kills it, 3 is killed for a poster. Argument: what is looked at. Prints what was seen.
 */
#include "guards_tables.h"

#include "exover.c"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint64_t memory[GUARDS_MEMORY_BYTES / 8 + 1];
static exover checker;
static exover *const c = &checker;
static const exover_value given[] = {{.real = 1}, {.integer = 2}}, none[1];

static void idle(void)
{
    if (exover_load_stopped(c, &guards_tables, memory, GUARDS_MEMORY_BYTES) != EXOVER_READY)
        exit(3);
}

/* Request 0 runs, 1 waits for it. */
static void busy(void)
{
    idle();
    if (exover_ask(c, 0, given, 2) != 1 || exover_ask(c, 1, NULL, 0) != 1 || c->actions[0].kind != EXOVER_WAIT)
        exit(4);
}

static void print(size_t count)
{
    for (size_t i = 0; i < count; i++)
        printf("%d %d %d;", (int)c->actions[i].kind, (int)c->actions[i].request, (int)c->actions[i].reason);
    printf("\n");
}

/* Which calls within a step have answers, or hide that they were made: none. Then how the step ends. */
static void within(void)
{
    static const exover_value reading = {.integer = 1};
    int answers = 0, hidden = 0;
    for (int call = 0; call < 8; call++) {
        busy();
        (void)begin(c);
        switch (call) {
        case 0: answers += (int)exover_ask(c, 2, NULL, 0); break;
        case 1: answers += (int)exover_report(c, 0, 0, EXOVER_OK, -1, none, 1); break;
        case 2: answers += (int)exover_observe(c, 0, reading); break;
        case 3: answers += (int)exover_level(c, 0, 1); break;
        case 4: answers += (int)exover_abort(c, 0, 0); break;
        case 5: answers += (int)exover_abort_waiting(c, 1); break;
        case 6: (void)exover_scrub(c, 4); break;
        default: c->fault = EXOVER_FAULT_REENTRY; answers += (int)exover_verify(c, 1);
        }
        answers += (int)exover_ask(c, 2, NULL, 0); /* the second finds the fault of the first */
        hidden += c->fault != EXOVER_FAULT_REENTRY;
    }
    printf("%d %d\n", answers, hidden);
    print(finish(c, 2));
}

/* The number of answers becomes a greater one where it is used: what is said next, what is killed, the end of a step. */
static void numbers(void)
{
    busy();
    const exover_int room = (exover_int)SHAPE(EXOVER_CAPACITY);
    (void)begin(c);
    c->count = room + 7;
    say_only(c, EXOVER_REJECT, 0, NONE, EXOVER_FAULTY);
    printf("%d %d ", (int)c->fault, (int)(c->count - room));
    c->count = room;
    kill_slot(c, 0, REQUEST(0), 0, EXOVER_ABORTED);
    printf("%d %d ", (int)c->fault, (int)(c->count - room));
    c->count = room + 1000;
    printf("%d ", (int)finish(c, 2) <= (int)room + 1);
    busy();
    (void)begin(c);
    c->count = room + 1;
    printf("%d ", (int)finish(c, 2) <= (int)room + 1);
    printf("%d ", (int)c->fault);
    busy();
    c->count = room + 2;
    printf("%d ", (int)exover_verify(c, (size_t)room + 2) <= (int)room + 1);
    printf("%d\n", (int)c->fault);
}

/* A step that only its agenda knows to be faulty, since the cause has lost its bits. */
static void cause(void)
{
    idle();
    (void)begin(c);
    ask(c, 2, REQUEST(2), NULL, NONE);
    fault(c, EXOVER_FAULT_STATE);
    c->fault = EXOVER_READY;
    print(finish(c, 2));
}

/* Records that say what no emitted one does, after they were read: what they are used for finds a fault. */
static void records(void)
{
    for (int damage = 0; damage < 3; damage++) {
        idle();
        (void)begin(c);
        exover_request row = *REQUEST(0);
        if (damage == 0)
            row.results = (exover_word)(row.params - 1);
        else if (damage == 1)
            row.params_end = (exover_word)(row.results - 1);
        else
            row.params_end = (exover_word)(row.params + COUNT(PARAMS) + 1);
        load(c, &row, given, none);
        printf("%d ", (int)c->fault);
    }
    for (int damage = 0; damage < 2; damage++) {
        idle();
        (void)begin(c);
        exover_gauge gauge = RECORD(param, PARAMS, 0)->gauge;
        if (damage == 0)
            gauge.cuts = (exover_word)(gauge.cuts_end + 1);
        else
            gauge.cuts_end = (exover_word)(COUNT(REALS) + 1);
        measure(c, REAL, &gauge, given[0]);
        printf("%d ", (int)c->fault);
    }
    for (int damage = 0; damage < 3; damage++) {
        idle();
        (void)begin(c);
        exover_feature feature = {ALWAYS, NONE, 1, {0, 0, 0, 0}};
        exover_uint weight = 0;
        if (damage == 0)
            weight = weigh(c, REQUEST(0), given, &feature); /* as it is emitted */
        else if (damage == 1)
            weight = weigh(c, REQUEST(0), NULL, &feature); /* the arguments were not what they were */
        else
            feature.weight = 2, weight = weigh(c, REQUEST(0), given, &feature);
        printf("%d ", (int)weight);
    }
    printf("\n");
}

/* Both slots of request 3 run, and count for a poster; the arguments of the first have changed when it is read. */
static void posters(void)
{
    static const exover_value slow[] = {{.real = 0.5}}, reading = {.real = 1.5};
    idle();
    if (exover_ask(c, 3, slow, 1) != 1 || exover_ask(c, 3, slow, 1) != 1)
        exit(4);
    c->values[REQUEST(3)->values].bits ^= 1;
    print(exover_observe(c, GUARDS_POSTER_TOP, reading));
    printf("%d\n", (int)c->fault);
}

/* A bit of the agenda changes between the swap of tables and the first step by them. */
static void swapped(void)
{
    idle();
    c->agenda ^= 1;
    print(settle_anew(c));
}

int main(int argc, char **argv)
{
    const char *mode = argc > 1 ? argv[1] : "";
    if (strcmp(mode, "within") == 0)
        within();
    else if (strcmp(mode, "numbers") == 0)
        numbers();
    else if (strcmp(mode, "cause") == 0)
        cause();
    else if (strcmp(mode, "posters") == 0)
        posters();
    else if (strcmp(mode, "swapped") == 0)
        swapped();
    else
        records();
    return 0;
}
