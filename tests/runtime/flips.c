/* Flips single bits of tables and state while a checker runs, and watches what it launches. For tests: hosted.
 *
 * Arguments: every how many bits, and the first. Input (32 bits each, of this machine): the number of requests, a row for
 * each with 1 for every request that must not be active beside it, the steps within which a bit has to be found, the
 * length of the packed tables; then their bytes. The rows come from the rules, not from the tables.
 * Output, a line for each place: its name, bits flipped, flips that were not found in time, launches that were unsafe.
 */
#include "exover.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { HEAD = 4 * EXOVER_HEAD_WORDS, WARM = 200, MOST = 256 };

static uint64_t lot;
static uint32_t requests, period;
static uint32_t rivals[MOST][MOST], rival_count[MOST]; /* which must not be active beside each */
static unsigned char active[MOST], active_before[MOST];
static exover checker, checker_before;
static exover_tables tables;
static exover_value *reals;
static exover_word *words;
static uint64_t memory[1 << 14], memory_before[1 << 14];
static size_t memory_size;

static uint32_t draw(uint32_t below)
{
    lot = lot * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(lot >> 33) % below;
}

static int is_unsafe(uint32_t request)
{
    if (request >= requests || active[request])
        return 1;
    for (uint32_t i = 0; i < rival_count[request]; i++)
        if (active[rivals[request][i]])
            return 1;
    return 0;
}

/* One random event; the number of unsafe launches. */
static int event(void)
{
    int bad = 0;
    uint32_t request = draw(requests);
    size_t count;
    if (active[request] && draw(2)) {
        count = exover_report(&checker, (int32_t)request, 0, EXOVER_OK, -1, NULL, 0);
        active[request] = 0;
    } else if (active[request] && draw(4) == 0) {
        count = exover_abort(&checker, (int32_t)request, 0);
    } else {
        count = exover_ask(&checker, (int32_t)request, NULL, 0);
    }
    for (size_t i = 0; i < count; i++)
        if (checker.actions[i].kind == EXOVER_LAUNCH) {
            uint32_t launched = (uint32_t)checker.actions[i].request;
            bad += is_unsafe(launched);
            if (launched < requests)
                active[launched] = 1;
        }
    return bad;
}

static void remember(void)
{
    checker_before = checker;
    memcpy(memory_before, memory, memory_size);
    memcpy(active_before, active, sizeof active);
}

/* Set everything back but the tables. */
static void restore(uint64_t seed)
{
    checker = checker_before;
    memcpy(memory, memory_before, memory_size);
    memcpy(active, active_before, sizeof active);
    lot = seed;
}

static void flip(const char *place, void *start, size_t size, size_t stride, size_t first)
{
    unsigned char *bytes = start;
    unsigned long flips = 0, missed = 0, unsafe = 0;
    for (size_t bit = first; bit < 8 * size; bit += stride) {
        restore(bit);
        bytes[bit / 8] ^= (unsigned char)(1 << bit % 8);
        uint32_t step = 0;
        for (; step < period && exover_fault(&checker) == EXOVER_READY; step++)
            unsafe += (unsigned long)event();
        missed += exover_fault(&checker) == EXOVER_READY;
        for (int after = 0; after < 5; after++)
            unsafe += (unsigned long)event();
        flips++;
        restore(0);
        if (start != (void *)&checker && (bytes < (unsigned char *)memory || bytes >= (unsigned char *)(memory + (1 << 14))))
            bytes[bit / 8] ^= (unsigned char)(1 << bit % 8);
    }
    printf("%s %lu %lu %lu\n", place, flips, missed, unsafe);
}

static uint32_t number(void)
{
    uint32_t read;
    if (fread(&read, sizeof read, 1, stdin) != 1)
        exit(2);
    return read;
}

static void read_input(void)
{
    requests = number();
    if (requests > MOST)
        exit(2);
    for (uint32_t one = 0; one < requests; one++)
        for (uint32_t other = 0; other < requests; other++)
            if (number() != 0)
                rivals[one][rival_count[one]++] = other;
    period = number();
    uint32_t length = number();
    if (fread(tables.head, HEAD, 1, stdin) != 1)
        exit(2);
    tables.real_count = tables.head[EXOVER_HEAD_REALS];
    tables.word_count = (length - HEAD - 8 * tables.real_count) / sizeof(exover_word);
    reals = malloc(8 * tables.real_count + 1);
    words = malloc(sizeof(exover_word) * tables.word_count + 1);
    if (reals == NULL || words == NULL || fread(reals, 8, tables.real_count, stdin) != tables.real_count
        || fread(words, sizeof(exover_word), tables.word_count, stdin) != tables.word_count)
        exit(2);
    tables.reals = reals;
    tables.words = words;
}

/* The least memory that will do, so that everything behind it is watched by sanitizers or by nobody. */
static void load(void)
{
    memory_size = 8;
    while (exover_load(&checker, &tables, memory, memory_size) == EXOVER_NO_MEMORY && memory_size < sizeof memory)
        memory_size += 8;
    if (exover_fault(&checker) != EXOVER_READY)
        exit(3);
}

int main(int argc, char **argv)
{
    size_t stride = argc > 1 ? (size_t)atol(argv[1]) : 1, first = argc > 2 ? (size_t)atol(argv[2]) : 0;
    int unsafe = 0;
    read_input();
    load();
    lot = 1;
    for (int i = 0; i < WARM; i++)
        unsafe += event();
    printf("sound %d %d %d\n", WARM, exover_fault(&checker) != EXOVER_READY, unsafe);
    remember();
    flip("head", tables.head, HEAD, stride, first);
    flip("reals", reals, 8 * tables.real_count, stride, first);
    flip("words", words, sizeof(exover_word) * tables.word_count, stride, first);
    unsigned char *answers = (unsigned char *)checker.actions;
    flip("state", memory, (size_t)(answers - (unsigned char *)memory), stride, first);
    flip("answers", answers, memory_size - (size_t)(answers - (unsigned char *)memory), stride, first);
#ifdef EXOVER_SHAPE
    flip("frame", &checker, offsetof(exover, seal), stride, first);
#else
    flip("frame", &checker, offsetof(exover, shape) + sizeof checker.shape, stride, first);
#endif
    flip("scalars", &checker.seal, offsetof(exover, scrubbed) - offsetof(exover, seal), stride, first);
    flip("step", (unsigned char *)&checker + offsetof(exover, scrubbed), sizeof checker - offsetof(exover, scrubbed), stride, first);
    free(reals);
    free(words);
    return 0;
}
