/* libFuzzer on exover_load and on events: bytes that load run within their arrays, and a faulty checker launches nothing.
 *
 * The input is packed tables, then events. The checksum is put right, so that what is behind it is looked at.
 */
#include "exover.h"

#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { HEAD = 4 * EXOVER_HEAD_WORDS };

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

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    exover c;
    exover_tables tables;
    if (size < HEAD)
        return 0;
    memcpy(tables.head, data, HEAD);
    size_t all = 0, room = (size_t)1 << 16;
    static const size_t fields[EXOVER_SECTIONS] = {4, 5, 26, 7, 3, 7, 2, 3, 3, 16, 4, 3, 2, 4, 4, 2, 1, 2, 1};
    for (int i = 0; i < EXOVER_SECTIONS; i++)
        all += (tables.head[EXOVER_HEAD_COUNTS + i] & 0xffff) * fields[i];
    tables.real_count = tables.head[EXOVER_HEAD_REALS];
    tables.word_count = all;
    if (tables.real_count > 1000 || HEAD + 8 * tables.real_count + 2 * all > size)
        return 0;
    const uint8_t *body = data + HEAD, *events = body + 8 * tables.real_count + 2 * all;
    tables.head[EXOVER_HEAD_CHECKSUM] = 0;
    uint32_t sum = crc(0xffffffffu, (const uint8_t *)tables.head, HEAD);
    tables.head[EXOVER_HEAD_CHECKSUM] = ~crc(sum, body, (size_t)(events - body));
    exover_value *reals = malloc(8 * tables.real_count + 1);
    exover_word *words = malloc(2 * all + 1);
    void *memory = malloc(room);
    if (reals == NULL || words == NULL || memory == NULL)
        abort();
    memcpy(reals, body, 8 * tables.real_count);
    memcpy(words, body + 8 * tables.real_count, 2 * all);
    tables.reals = reals;
    tables.words = words;
    exover_status status = exover_load_stopped(&c, &tables, memory, room);
    for (; events + 4 <= data + size; events += 4) {
        int faulty = exover_fault(&c) != EXOVER_READY;
        if (event(&c, events) && (faulty || status != EXOVER_READY))
            abort();
    }
    free(memory);
    free(words);
    free(reals);
    return 0;
}
