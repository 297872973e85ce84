/* Loads packed tables from standard input and runs random events on those that load. For tests: hosted, unlike exover.c.
 *
 * Input: again and again a seed, a number of events, a length (32 bits each, of this machine) and so many bytes.
 * Output for each: the status of the load, the least memory that it takes, the fault after the events, and a sum of
 * all answers.
 */
#include "exover.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "events.h"

/* The least memory with which the tables load; 0 if they never do. */
static size_t least_memory(exover *c, const exover_tables *tables)
{
    size_t low = 0, high = (size_t)1 << 18;
    void *memory = malloc(high);
    if (memory == NULL || exover_load_stopped(c, tables, memory, high) != EXOVER_READY)
        high = 0;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (exover_load_stopped(c, tables, memory, middle) == EXOVER_READY)
            high = middle;
        else
            low = middle + 1;
    }
    free(memory);
    return high;
}

static void run(const unsigned char *bytes, size_t length, uint32_t events)
{
    enum { HEAD = 4 * EXOVER_HEAD_WORDS };
    exover c;
    exover_tables tables;
    if (length < HEAD) {
        printf("-1 0 0 0\n");
        return;
    }
    memcpy(tables.head, bytes, HEAD);
    tables.real_count = tables.head[EXOVER_HEAD_REALS];
    if (tables.real_count > (length - HEAD) / 8)
        tables.real_count = (length - HEAD) / 8;
    tables.word_count = (length - HEAD - 8 * tables.real_count) / sizeof(exover_word);
    exover_value *reals = malloc(8 * tables.real_count + 1);
    exover_word *words = malloc(sizeof(exover_word) * tables.word_count + 1);
    if (reals == NULL || words == NULL)
        exit(1);
    memcpy(reals, bytes + HEAD, 8 * tables.real_count);
    memcpy(words, bytes + HEAD + 8 * tables.real_count, sizeof(exover_word) * tables.word_count);
    tables.reals = reals;
    tables.words = words;
    size_t size = least_memory(&c, &tables);
    void *memory = malloc(size + (size == 0));
    exover_status status = exover_load_stopped(&c, &tables, memory, size);
    uint64_t sum = 0;
    for (uint32_t i = 0; i < events; i++) {
        size_t count = event(&c);
        for (size_t k = 0; k < count; k++) {
            const exover_action *action = &c.actions[k];
            sum = 31 * sum + (uint64_t)action->kind + 7 * (uint64_t)action->request + 77 * (uint64_t)action->reason;
            if (action->kind == EXOVER_LAUNCH) {
                const exover_value *args = exover_args(&c, (int32_t)action->request, (int32_t)action->slot);
                for (size_t arg = 0; args != NULL && arg < exover_arity(&c, (int32_t)action->request); arg++)
                    sum = 31 * sum + args[arg].bits;
                if (status != EXOVER_READY)
                    printf("launched although the load failed\n");
            }
        }
    }
    printf("%d %zu %d %016llx\n", (int)status, size, (int)exover_fault(&c), (unsigned long long)sum);
    free(memory);
    free(reals);
    free(words);
}

int main(void)
{
    uint32_t head[3];
    while (fread(head, sizeof head, 1, stdin) == 1) {
        unsigned char *bytes = malloc(head[2] + 1u);
        if (bytes == NULL || (head[2] != 0 && fread(bytes, head[2], 1, stdin) != 1))
            return 1;
        lot = head[0];
        run(bytes, head[2], head[1]);
        free(bytes);
    }
    return 0;
}
