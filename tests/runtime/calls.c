/* Calls with what no host should give: prints what each returns. For tests: hosted. */
#include "calls_tables.h"

#include <stdio.h>
#include <string.h>

static uint64_t memory[CALLS_MEMORY_BYTES / 8 + 2];
static exover r2c, copy;

static int load(const exover_word *words, const exover_value *reals, void *where)
{
    static exover_tables tables; /* it stays where it is as long as the checker is used */
    tables = calls_tables;
    tables.words = words;
    tables.reals = reals;
    return (int)exover_load_stopped(&r2c, &tables, where, sizeof memory);
}

static int reason(size_t count)
{
    count = exover_verify(&r2c, count);
    return count == 1 && r2c.actions[0].kind == EXOVER_INVALID ? (int)r2c.actions[0].reason : -99;
}

int main(void)
{
    const exover_tables *all = &calls_tables;
    const exover_value *const odd = (const exover_value *)(const void *)((const char *)all->reals + 4);
    printf("%d %d ", (int)exover_load_stopped(NULL, all, memory, sizeof memory), exover_unchecked(&r2c));
    printf("%d ", (int)exover_load_stopped(&r2c, NULL, memory, sizeof memory));
    printf("%d %d ", load(all->words, all->reals, NULL), load(NULL, all->reals, memory));
    printf("%d ", load(all->words, NULL, memory));
    printf("%d %d\n", load(all->words, odd, memory), load(all->words, all->reals, (char *)memory + 4));
    printf("%d ", (int)exover_verify(&r2c, exover_ask(&r2c, CALLS_M_A, NULL, 0))); /* of a checker that is not loaded */
    printf("%d ", load(all->words, all->reals, memory));
    printf("%d\n", exover_unchecked(&r2c));
    const exover_value given[] = {{.real = 1}};
    printf("%d ", reason(exover_ask(&r2c, CALLS_M_A, NULL, 1)));
    printf("%d ", (int)exover_verify(&r2c, exover_ask(&r2c, CALLS_M_A, given, 1)));
    printf("%d ", reason(exover_report(&r2c, CALLS_M_A, 0, EXOVER_FAILED, -2, NULL, 0)));
    printf("%d ", reason(exover_abort(&r2c, CALLS_M_A + 0x10000, 0)));
    printf("%d ", reason(exover_abort(&r2c, CALLS_M_A, 0x10000)));
    printf("%d %d ", (int)exover_slot(&r2c, CALLS_M_A, -1).phase, (int)exover_slot(&r2c, -1, 0).phase);
    printf("%d %d\n", (int)exover_slot(&r2c, CALLS_M_A, 0).phase, (int)exover_fault(&r2c));
    copy = r2c;
    printf("%d ", (int)exover_scrub(&copy, 8));
    printf("%d ", (int)exover_scrub(&copy, 8));
    copy = r2c;
    printf("%d ", (int)exover_verify(&copy, 1));
    printf("%d ", (int)exover_fault(&copy));
    printf("%d %d\n", (int)exover_scrub(&r2c, 8), (int)exover_fault(&r2c));
    return 0;
}
