/* Puts extreme numbers into each word of the tables of a running checker. For tests: hosted, with sanitizers.
 *
 * An argument: check words stay as they are, and so find each number.
 *
 * Input: packed tables of this width. Every word becomes the least number, the greatest, and some between; with each the
 * checker takes random events. Prints how many words there were, how often a fault was found.
 */
#include "exover.c" /* for the seal: here a changed number is not to be found by its check word */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "events.h"

enum { HEAD = 4 * EXOVER_HEAD_WORDS, MOST = 1 << 16, WARM = 40, EVENTS = 16 };

static unsigned char packed[MOST];
static exover_value reals[MOST / 8];
static exover_word words[MOST / sizeof(exover_word)];
static uint64_t memory[MOST], memory_before[MOST];

int main(int count, char **arguments)
{
    static exover checker, before;
    static exover_tables tables;
    const int64_t greatest = (int64_t)(UINT64_MAX >> (65 - 8 * EXOVER_WIDTH));
    const int64_t extremes[] = {-greatest - 1, -1, greatest / 2 + 1, greatest};
    size_t length = fread(packed, 1, MOST, stdin);
    memcpy(tables.head, packed, HEAD);
    tables.real_count = tables.head[EXOVER_HEAD_REALS];
    tables.word_count = (length - HEAD - 8 * tables.real_count) / sizeof(exover_word);
    memcpy(reals, packed + HEAD, 8 * tables.real_count);
    memcpy(words, packed + HEAD + 8 * tables.real_count, sizeof(exover_word) * tables.word_count);
    tables.reals = reals;
    tables.words = words;
    if (exover_load_stopped(&checker, &tables, memory, sizeof memory) != EXOVER_READY)
        return 2;
    for (int i = 0; i < WARM; i++)
        (void)event(&checker);
    const uint32_t size = checker.shape[EXOVER_STARTS + EXOVER_SECTIONS];
    (void)arguments;
    if (count == 1)
        checker.shape[EXOVER_WORDS] = size;
    checker.seal = seal_of(&checker);
    before = checker;
    memcpy(memory_before, memory, sizeof memory);
    unsigned long found = 0;
    for (size_t at = 0; at < size; at++) {
        const exover_word was = words[at];
        for (size_t k = 0; k < sizeof extremes / sizeof *extremes; k++) {
            checker = before;
            memcpy(memory, memory_before, 1 << 14);
            words[at] = (exover_word)extremes[k];
            lot = at + k;
            for (int i = 0; i < EVENTS; i++)
                (void)event(&checker);
            found += exover_fault(&checker) != EXOVER_READY;
        }
        words[at] = was;
    }
    printf("%lu %lu\n", (unsigned long)size, found);
    return 0;
}
