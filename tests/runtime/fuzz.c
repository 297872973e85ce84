/* libFuzzer on exover_load and on events: bytes that load run within their arrays, and a faulty checker launches nothing.
 *
 * The input is packed tables without their check words, then events (corpus.py). Check words and the checksum are made
 * here, so that what is behind them is looked at. With ALONE it is a program without libFuzzer: it takes the files that
 * are named, and prints for each how it was loaded and how many events launched something.
 */
#include "exover.c" /* for the records and their check words */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { HEAD = 4 * EXOVER_HEAD_WORDS, MOST_REALS = 1000, MOST_RECORDS = 0xffff };

static exover_status loaded;
static unsigned launches;

static uint32_t crc(uint32_t sum, const uint8_t *bytes, size_t size)
{
    while (size-- > 0) {
        sum ^= *bytes++;
        for (int bit = 0; bit < 8; bit++)
            sum = sum >> 1 ^ (sum & 1 ? 0xedb88320u : 0u);
    }
    return sum;
}

static exover_value value(const uint8_t *byte)
{
    static const double reals[] = {0.0, 0.5, 1.0, -1.0, 1e300, 0.2, 40.0, 1e-300};
    exover_value found;
    if (*byte & 1)
        found.real = reals[*byte >> 1 & 7];
    else
        found.integer = (int64_t)(int8_t)*byte / 2;
    return found;
}

/* One event of four bytes; whether something was launched. */
static int event(exover *c, const uint8_t *bytes)
{
    exover_value values[64];
    int32_t request = bytes[1] % 16 - 1, slot = bytes[2] >> 6;
    size_t count = exover_arity(c, request);
    for (size_t i = 0; i < 64; i++)
        values[i] = value(&bytes[2 + i % 2]);
    count = count < 64 ? count : 64;
    switch (bytes[0] % 8) {
    case 0:
    case 1:
    case 2: count = exover_ask(c, request, values, count); break;
    case 3:
    case 4: count = exover_report(c, request, slot, (enum exover_outcome)(bytes[3] % 5), bytes[2] % 4 - 1, values, bytes[3] % 3); break;
    case 5: count = exover_observe(c, request, values[0]); break;
    case 6: count = exover_level(c, request, values[0].integer); break;
    default: count = bytes[3] & 1 ? exover_abort(c, request, slot) : exover_abort_waiting(c, request);
    }
    int launched = 0;
    for (size_t i = 0; i < count; i++)
        launched |= c->actions[i].kind == EXOVER_LAUNCH;
    return launched;
}

/* The words of so many records of each section. */
static size_t words_of(const uint32_t *counts)
{
    size_t words = 0;
    for (unsigned section = 0; section < EXOVER_SECTIONS; section++)
        words += (size_t)counts[section] * FIELDS[section];
    return words;
}

/* Write a check word for each record and each double; how many. */
static size_t add_checks(const exover_word *word, const uint32_t *counts, const uint8_t *reals, size_t doubles, exover_word *check)
{
    const exover_word *first = check;
    for (unsigned section = 0; section < EXOVER_SECTIONS; section++)
        for (uint32_t i = 0; i < counts[section]; i++, word += FIELDS[section])
            *check++ = (exover_word)~sum_of_words(word, FIELDS[section], 0);
    for (size_t i = 0; i < doubles; i++) {
        exover_word parts[8 / sizeof(exover_word)];
        memcpy(parts, reals + 8 * i, 8);
        *check++ = (exover_word)~sum_of_words(parts, 8 / sizeof(exover_word), 0);
    }
    return (size_t)(check - first);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static uint64_t memory[1 << 13];
    exover c;
    exover_tables tables;
    if (size < HEAD)
        return 0;
    memcpy(tables.head, data, HEAD);
    uint32_t *counts = &tables.head[EXOVER_HEAD_COUNTS];
    size_t records = 0, doubles = tables.head[EXOVER_HEAD_REALS];
    for (unsigned section = 0; section < EXOVER_SECTIONS; section++)
        records += counts[section] &= MOST_RECORDS;
    size_t words = words_of(counts), body = 8 * doubles + sizeof(exover_word) * words;
    if (doubles > MOST_REALS || HEAD + body > size)
        return 0;
    const uint8_t *packed = data + HEAD, *events = packed + body;
    exover_value *reals = malloc(8 * doubles + 1);
    exover_word *all = malloc(sizeof(exover_word) * (words + records + doubles) + 1);
    if (reals == NULL || all == NULL)
        abort();
    memcpy(reals, packed, 8 * doubles);
    memcpy(all, packed + 8 * doubles, sizeof(exover_word) * words);
    size_t checks = tables.head[EXOVER_HEAD_CHECKS] != 0 ? add_checks(all, counts, packed, doubles, all + words) : 0;
    tables.head[EXOVER_HEAD_CHECKS] = (uint32_t)checks;
    tables.head[EXOVER_HEAD_CHECKSUM] = 0;
    uint32_t sum = crc(0xffffffffu, (const uint8_t *)tables.head, HEAD);
    sum = crc(sum, packed, 8 * doubles);
    tables.head[EXOVER_HEAD_CHECKSUM] = ~crc(sum, (const uint8_t *)all, sizeof(exover_word) * (words + checks));
    tables.reals = reals;
    tables.real_count = doubles;
    tables.words = all;
    tables.word_count = words + checks;
    loaded = exover_load_stopped(&c, &tables, memory, sizeof memory);
    launches = 0;
    for (; events + 4 <= data + size; events += 4) {
        int faulty = exover_fault(&c) != EXOVER_READY, launched = event(&c, events);
        launches += (unsigned)launched;
        if (launched && (faulty || loaded != EXOVER_READY))
            abort();
    }
    free(all);
    free(reals);
    return 0;
}

#ifdef ALONE
int main(int count, char **files)
{
    static uint8_t bytes[1 << 20];
    for (int i = 1; i < count; i++) {
        FILE *file = fopen(files[i], "rb");
        if (file == NULL)
            return 1;
        (void)LLVMFuzzerTestOneInput(bytes, fread(bytes, 1, sizeof bytes, file));
        (void)fclose(file);
        printf("%d %u\n", (int)loaded, launches);
    }
    return 0;
}
#endif
