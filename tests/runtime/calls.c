/* Calls with what no host should give, and of checkers of which bits have changed between two calls: prints what each
 * returns. For tests: hosted. */
#include "calls_tables.h"

#include <stdio.h>
#include <string.h>

static uint64_t memory[CALLS_MEMORY_BYTES / 8 + 2];
static exover r2c, copy, fresh;

static int load(const exover_word *words, const exover_value *reals, void *where)
{
    static exover_tables tables; /* it stays where it is as long as the checker is used */
    tables = calls_tables;
    tables.words = words;
    tables.reals = reals;
    return (int)exover_load_stopped(&r2c, &tables, where, sizeof memory);
}

/* The status of loading tables that say other sizes than they have, or more than can be. */
static int claimed(uint32_t reals, size_t real_count, size_t word_count)
{
    static exover_tables tables;
    tables = calls_tables;
    memset(&tables.head[EXOVER_HEAD_COUNTS], 0, (EXOVER_SECTIONS + 1) * sizeof tables.head[0]);
    tables.head[EXOVER_HEAD_REALS] = reals;
    tables.real_count = real_count;
    tables.word_count = word_count;
    for (int section = 0; section < 3; section++) /* nodes, entries and requests, as many of each */
        tables.head[EXOVER_HEAD_COUNTS + section] = (uint32_t)(word_count / 35);
    return (int)exover_load_stopped(&r2c, &tables, memory, sizeof memory);
}

/* The status of loading tables of which this word of the head, or the number of doubles or words, is another. */
static int headed(int word, uint32_t change, size_t reals, size_t words)
{
    static exover_tables tables;
    tables = calls_tables;
    tables.head[word] ^= change;
    tables.real_count += reals;
    tables.word_count += words;
    return (int)exover_load_stopped(&r2c, &tables, memory, sizeof memory);
}

/* What does not say any more that it is live, but is sealed; then neither. */
static void lives(void)
{
    r2c.live ^= 1;
    printf("%d ", (int)exover_load(&r2c, &calls_tables, memory, sizeof memory));
    r2c.seal ^= 1;
    printf("%d\n", (int)exover_load(&r2c, &calls_tables, memory, sizeof memory));
}

static int reason(size_t count)
{
    count = exover_verify(&r2c, count);
    return count == 1 && r2c.actions[0].kind == EXOVER_INVALID ? (int)r2c.actions[0].reason : -99;
}

/* Bits have changed: of the number of places that answers have stood in; of the only place of a checker that is lost; and
 * of a phase, with those of its complement. */
static void changed(void)
{
    r2c.said = UINT32_MAX;
    printf("%d ", (int)exover_verify(&r2c, exover_ask(&r2c, CALLS_M_B, NULL, 0)));
    copy = r2c;
    (void)exover_ask(&copy, CALLS_M_B, NULL, 0);
    copy.denial.reason ^= 1;
    printf("%d ", (int)exover_verify(&copy, 1));
    printf("%d ", (int)copy.denial.reason);
    printf("%d ", (int)exover_verify(&copy, 2));
    copy.cells = r2c.cells;
    printf("%d ", (int)exover_verify(&copy, 1));
    for (exover_cell *cell = r2c.cells; (void *)cell < (void *)r2c.actions; cell++) {
        cell->now = 7;
        cell->inverse = ~cell->now;
    }
    printf("%d %d ", (int)exover_slot(&r2c, CALLS_M_A, 0).phase, (int)exover_fault(&r2c));
    r2c.agenda ^= 1;
    (void)exover_ask(&r2c, CALLS_M_B, NULL, 0);
    printf("%d %d\n", reason(exover_abort(&r2c, CALLS_M_A + 0x10000, 0)), reason(exover_abort(&r2c, CALLS_M_A, 0x10000)));
}

int main(void)
{
    const exover_tables *all = &calls_tables;
    const exover_value *const odd = (const exover_value *)(const void *)((const char *)all->reals + 4);
    printf("%d %d ", (int)exover_load_stopped(NULL, all, memory, sizeof memory), exover_unchecked(&r2c));
    printf("%d ", (int)exover_load_stopped(&r2c, NULL, memory, sizeof memory));
    printf("%d %d ", load(all->words, all->reals, NULL), load(NULL, all->reals, memory));
    printf("%d ", load(all->words, NULL, memory));
    printf("%d %d ", load(all->words, odd, memory), load(all->words, all->reals, (char *)memory + 4));
    printf("%d ", headed(EXOVER_HEAD_CHECKSUM, 1, 0, 0));
    printf("%d %d ", headed(EXOVER_HEAD_MAGIC, 0, 1, 0), headed(EXOVER_HEAD_MAGIC, 0, 0, 1));
    printf("%d %d ", claimed(1, 2, 0), claimed(0x4000000, 0x4000000, 0));
    printf("%d %d\n", claimed(0, 0, (size_t)(INT32_MAX / 32) * 35), claimed(0, 0, (size_t)(INT32_MAX / 35) * 35));
    printf("%d ", (int)exover_fault(&fresh));
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
    copy = r2c;
    printf("%d %d ", exover_args(&copy, CALLS_M_A, 0) == NULL, exover_unchecked(&copy));
    printf("%d %d\n", (int)exover_scrub(&r2c, 8), (int)exover_fault(&r2c));
    printf("%d ", exover_args(&r2c, CALLS_M_B + 1, 0) == NULL);
    lives();
    changed();
    return 0;
}
