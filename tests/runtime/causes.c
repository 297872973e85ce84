/* Brings a running checker to each of its faults, and looks at what it answers from then on. For tests: hosted.
 *
 * The spec has requests 0, 1 and 2, of which 2 interrupts 0 and 1, and 3, which must not run beside 0. Argument: the
 * cause. Output: the status, then the answers to what follows, as KIND REQUEST SLOT REASON.
 */
#include "causes_tables.h"

#include "exover.c" /* for the seal of what is damaged here on purpose */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint64_t memory[CAUSES_MEMORY_BYTES / 8 + 1];
static exover_word words[sizeof memory];
static exover_tables tables;
static exover checker;

static void print(size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const exover_action *action = &checker.actions[i];
        printf("%d %d %d %d %d;", (int)action->kind, (int)action->request, (int)action->slot, (int)action->reason,
               (int)action->launch_rule);
    }
    printf("\n");
}

static exover_word *section(int number)
{
    return words + checker.shape[EXOVER_STARTS + number];
}

static exover_request *request(int number)
{
    return (exover_request *)(void *)section(2) + number;
}

static exover_word node_of(int code, int reason)
{
    const exover_node *nodes = (const exover_node *)(const void *)section(0);
    for (exover_word i = 0; i < (exover_word)checker.shape[EXOVER_COUNTS]; i++)
        if (nodes[i].code == -code && (reason < 0 || nodes[i].bound == reason))
            return i;
    exit(4);
}

static void reshape(enum exover_shape number, uint32_t value)
{
    checker.shape[number] = value;
    checker.seal = seal_of(&checker);
}

static void demand(int number)
{
    print(exover_ask(&checker, number, NULL, 0));
}

/* Damage; then ask what meets it. Request 0 runs. */
static void damage(const char *cause)
{
    if (strcmp(cause, "tables") != 0 && strcmp(cause, "not loaded") != 0)
        reshape(EXOVER_WORDS, checker.shape[EXOVER_STARTS + EXOVER_SECTIONS]); /* as if there were no check words */
    if (strcmp(cause, "path") == 0) {
        reshape(EXOVER_STEPS, 0);
        demand(2);
    } else if (strcmp(cause, "turning back") == 0) {
        exover_node *root = (exover_node *)(void *)section(0) + request(1)->decide;
        root->low = root->high = 0;
        demand(1);
    } else if (strcmp(cause, "going on before") == 0) {
        ((exover_node *)(void *)section(0))[node_of(5, -1)].low = 0;
        demand(2);
    } else if (strcmp(cause, "actions") == 0) {
        reshape(EXOVER_CAPACITY, 0);
        demand(1);
    } else if (strcmp(cause, "passes") == 0) {
        ((exover_limits *)(void *)section(14))->passes = 0;
        demand(2);
    } else if (strcmp(cause, "decision") == 0) {
        request(1)->decide = -1;
        demand(1);
    } else if (strcmp(cause, "no slot") == 0) {
        request(0)->decide = node_of(7, -1);
        demand(0);
    } else if (strcmp(cause, "only rows") == 0) {
        request(3)->decide = node_of(7, -1);
        demand(3);
    } else if (strcmp(cause, "only diagrams") == 0) {
        request(1)->decide = node_of(1, CAUSES_REASON_STILL);
        demand(1);
    } else if (strcmp(cause, "not counted") == 0) {
        exover_cell *held = &checker.cells[checker.shape[EXOVER_HELD]];
        held->inverse = ~(exover_uint)0;
        held->now = 0;
        print(exover_report(&checker, 0, 0, EXOVER_OK, -1, NULL, 0));
        demand(0);
    } else if (strcmp(cause, "index") == 0) {
        request(1)->decide = 30000;
        demand(1);
    } else if (strcmp(cause, "state") == 0) {
        checker.cells[1].now ^= 4;
        demand(1);
    } else if (strcmp(cause, "active") == 0) {
        checker.cells[checker.shape[EXOVER_ACTIVE]].now ^= 0x100; /* of no request; the block is that of all */
        demand(1);
    } else if (strcmp(cause, "agenda") == 0) {
        checker.agenda ^= 32;
        demand(1);
    } else if (strcmp(cause, "tables") == 0) {
        words[tables.word_count - 1] ^= 1;
        for (int i = 0; i < CAUSES_SCRUB_STEPS && exover_fault(&checker) == EXOVER_READY; i++)
            (void)exover_abort(&checker, 3, 0);
        demand(1);
    } else if (strcmp(cause, "checker") == 0) {
        checker.cells += 1;
        demand(1);
    } else if (strcmp(cause, "not loaded") == 0) {
        memset(&checker, 0, sizeof checker);
        demand(1);
    }
}

int main(int argc, char **argv)
{
    memcpy(&tables, &causes_tables, sizeof tables);
    memcpy(words, causes_tables.words, causes_tables.word_count * sizeof *words);
    tables.words = words;
    if (argc != 2 || exover_load_stopped(&checker, &tables, memory, CAUSES_MEMORY_BYTES) != EXOVER_READY)
        return 3;
    demand(0);
    damage(argv[1]);
    printf("%d\n", (int)exover_fault(&checker));
    demand(1);
    print(exover_observe(&checker, 0, (exover_value){.integer = 1}));
    print(exover_abort(&checker, 0, 0));
    print(exover_report(&checker, 0, 0, EXOVER_OK, -1, NULL, 0));
    printf("%d\n", (int)exover_fault(&checker));
    memcpy(words, causes_tables.words, causes_tables.word_count * sizeof *words);
    printf("%d\n", (int)exover_load_stopped(&checker, &tables, memory, CAUSES_MEMORY_BYTES));
    demand(1);
    return 0;
}
