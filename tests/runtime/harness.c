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

static uint64_t lot;

static uint32_t draw(uint32_t below)
{
    lot = lot * 6364136223846793005u + 1442695040888963407u;
    return below == 0 ? 0 : (uint32_t)(lot >> 33) % below;
}

static exover_value any_value(void)
{
    static const double REALS[] = {0.0, 0.5, 1.0, -1.0, 1e300, 0.2, 40.0};
    exover_value value;
    switch (draw(8)) {
    case 0: value.bits = lot; break;
    case 1: value.bits = UINT64_C(0x7ff8000000000000); break;
    case 2:
    case 3:
    case 4: value.real = REALS[draw(7)]; break;
    default: value.integer = (int64_t)draw(5) - 1;
    }
    return value;
}

static size_t event(exover *c)
{
    exover_value values[64];
    int32_t request = (int32_t)draw(c->shape[EXOVER_COUNTS + 2] + 2) - 1;
    int32_t slot = draw(8) == 0 ? (int32_t)draw(4) - 1 : 0;
    size_t count = draw(16) == 0 ? draw(4) : exover_arity(c, request);
    for (size_t i = 0; i < 64; i++)
        values[i] = any_value();
    count = count < 64 ? count : 64;
    switch (draw(8)) {
    case 0:
    case 1:
    case 2: return exover_ask(c, request, values, count);
    case 3:
    case 4:
        count = draw(4);
        return exover_report(c, request, slot, (enum exover_outcome)(draw(4)), (int32_t)draw(3) - 1, values, count);
    case 5: return exover_observe(c, (int32_t)draw(c->shape[EXOVER_COUNTS + 9] + 2) - 1, values[0]);
    case 6: return exover_level(c, (int32_t)draw(c->shape[EXOVER_COUNTS + 11] + 2) - 1, values[0].integer);
    default: return draw(2) ? exover_abort(c, request, slot) : exover_abort_waiting(c, request);
    }
}

/* The least memory with which the tables load; 0 if they never do. */
static size_t least_memory(exover *c, const exover_tables *tables)
{
    size_t low = 0, high = (size_t)1 << 18;
    void *memory = malloc(high);
    if (memory == NULL || exover_load(c, tables, memory, high) != EXOVER_READY)
        high = 0;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (exover_load(c, tables, memory, middle) == EXOVER_READY)
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
    exover_status status = exover_load(&c, &tables, memory, size);
    uint64_t sum = 0;
    for (uint32_t i = 0; i < events; i++) {
        size_t count = event(&c);
        for (size_t k = 0; k < count; k++) {
            const exover_action *action = &c.actions[k];
            sum = 31 * sum + (uint64_t)action->kind + 7 * (uint64_t)action->request + 77 * (uint64_t)action->reason;
            if (action->kind == EXOVER_LAUNCH) {
                const exover_value *args = exover_args(&c, (int32_t)action->request, (int32_t)action->slot);
                for (size_t arg = 0; arg < exover_arity(&c, (int32_t)action->request); arg++)
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
