/* exover_box.c - see exover_box.h; docs/runtime.md describes the bytes. */
#include "exover_box.h"

#define MAGIC 0x58425845u /* "EXBX" */
#define FORMAT 1u
#define MOST_VALUES 0xffffu

enum { HEADER_WORDS = EXOVER_BOX_HEADER / 4, LINE_WORDS = EXOVER_BOX_LINE / 4, DIGEST_WORDS = 8 };
enum { OPENED = 1, ASK, REPORT, OBSERVE, LEVEL, ABORT, ABORT_WAITING, VALUES, ANSWER, END };

/* Bytes of the box are volatile: they are written in this order, and before whatever follows. */
static void put(volatile uint8_t *bytes, uint32_t word)
{
    for (unsigned i = 0; i < 4u; i++) {
        bytes[i] = (uint8_t)(word >> (8u * i));
    }
}

static uint32_t get(const volatile uint8_t *bytes)
{
    uint32_t word = 0;
    for (unsigned i = 0; i < 4u; i++) {
        word |= (uint32_t)bytes[i] << (8u * i);
    }
    return word;
}

/* FNV-1a over words: a change within one word always shows. */
static uint32_t check_of(const uint32_t *words, unsigned count)
{
    uint32_t sum = 2166136261u;
    for (unsigned i = 0; i < count; i++) {
        sum = (sum ^ words[i]) * 16777619u;
    }
    return sum;
}

/* Write so many words, the last of which becomes their check. */
static void write_words(volatile uint8_t *bytes, uint32_t *words, unsigned count)
{
    words[count - 1u] = check_of(words, count - 1u);
    for (unsigned i = 0; i < count; i++) {
        put(&bytes[4u * i], words[i]);
    }
}

/* Read so many words; whether the last is their check. */
static bool read_words(const volatile uint8_t *bytes, uint32_t *words, unsigned count)
{
    for (unsigned i = 0; i < count; i++) {
        words[i] = get(&bytes[4u * i]);
    }
    return words[count - 1u] == check_of(words, count - 1u);
}

/* ---- the box itself ---- */

static uintptr_t seal_of(const exover_box *box)
{
    /* cppcheck-suppress misra-c2012-11.4 ; the seal is made of an address, and never made into one */
    return ~((uintptr_t)box->memory ^ ((uintptr_t)box->lines << 1));
}

static volatile uint8_t *place(const exover_box *box, uint64_t line)
{
    return &box->memory[EXOVER_BOX_HEADER + (size_t)(line % box->lines) * EXOVER_BOX_LINE];
}

/* How many lines were ever written, as the lines say that are still there. */
static uint64_t found(const exover_box *box)
{
    uint64_t most = 0;
    for (uint32_t i = 0; i < box->lines; i++) {
        uint32_t words[LINE_WORDS];
        if (read_words(place(box, i), words, LINE_WORDS)) {
            const uint64_t line = words[0] | (uint64_t)(words[2] >> 24) << 32;
            if (line > most && (line - 1u) % box->lines == i) {
                most = line;
            }
        }
    }
    return most;
}

static void count_to(exover_box *box, uint64_t written)
{
    box->written = written;
    box->unwritten = ~written;
}

/* Whether there is a box to write to. */
static bool is_open(exover_box *box)
{
    if (box->memory == NULL || box->lines == 0u || box->seal != seal_of(box)) {
        return false;
    }
    if (box->written != ~box->unwritten) {
        count_to(box, found(box));
    }
    return true;
}

static void line(exover_box *box, uint32_t step, uint32_t what, uint32_t d, uint32_t a, uint32_t b, uint32_t c, uint32_t e)
{
    if (is_open(box)) {
        const uint64_t at = box->written, number = at + 1u;
        uint32_t words[LINE_WORDS] = {(uint32_t)number, step, what | d << 8 | (uint32_t)(number >> 32) << 24, a, b, c, e, 0};
        count_to(box, number);
        write_words(place(box, at), words, LINE_WORDS);
    }
}

bool exover_box_open(exover_box *box, const exover *r2c, void *memory, size_t size)
{
    const size_t lines = size < EXOVER_BOX_HEADER ? 0u : (size - EXOVER_BOX_HEADER) / EXOVER_BOX_LINE;
    box->memory = NULL;
    box->lines = lines > UINT32_MAX ? UINT32_MAX : (uint32_t)lines;
    if (memory == NULL || lines == 0u || exover_fault(r2c) != EXOVER_READY) {
        return false;
    }
    /* cppcheck-suppress misra-c2012-11.5 ; any memory is bytes */
    box->memory = (uint8_t *)memory;
    box->seal = seal_of(box);
    uint32_t header[HEADER_WORDS];
    for (unsigned i = 0; i < HEADER_WORDS - 1u; i++) {
        const uint32_t start[] = {MAGIC, FORMAT, box->lines, r2c->head[EXOVER_HEAD_CHECKSUM]};
        const bool digest = i >= 4u && i < 4u + DIGEST_WORDS;
        header[i] = i < 4u ? start[i] : digest ? r2c->head[(unsigned)EXOVER_HEAD_DIGEST + i - 4u] : 0u;
    }
    uint32_t there[HEADER_WORDS];
    bool same = read_words(box->memory, there, HEADER_WORDS);
    for (unsigned i = 0; i < HEADER_WORDS - 1u; i++) {
        same = same && there[i] == header[i];
    }
    if (same) {
        count_to(box, found(box));
    } else {
        for (size_t i = 0; i < EXOVER_BOX_BYTES((size_t)box->lines); i++) {
            ((volatile uint8_t *)box->memory)[i] = 0;
        }
        count_to(box, 0);
        write_words(box->memory, header, HEADER_WORDS);
    }
    line(box, exover_step(r2c), OPENED, 0, 0, 0, 0, 0);
    return true;
}

/* ---- events and their answers ---- */

static uint32_t low(exover_value value)
{
    return (uint32_t)value.bits;
}

static uint32_t high(exover_value value)
{
    return (uint32_t)(value.bits >> 32);
}

/* An event, and its values; a host that gives more than any request takes has them counted, and no more. */
static void begin(exover_box *box, const exover *r2c, uint32_t what, const uint32_t *numbers, const exover_value *values,
                  size_t count)
{
    const uint32_t step = exover_step(r2c) + 1u;
    const size_t most = values == NULL || count > MOST_VALUES ? 0u : count;
    line(box, step, what, count > MOST_VALUES ? MOST_VALUES : (uint32_t)count, numbers[0], numbers[1], numbers[2], numbers[3]);
    for (size_t i = 0; i < most; i += 2u) {
        const exover_value zero = {0}, second = i + 1u < most ? values[i + 1u] : zero;
        line(box, step, VALUES, i + 1u < most ? 2u : 1u, low(values[i]), high(values[i]), low(second), high(second));
    }
}

/* The answers, and the end of the step; returns how many there are. */
static size_t end(exover_box *box, exover *r2c, size_t count)
{
    const size_t verified = exover_verify(r2c, count);
    const uint32_t step = exover_step(r2c);
    for (size_t i = 0; i < verified; i++) {
        const exover_action *said = &r2c->actions[i];
        line(box, step, ANSWER, (uint32_t)said->kind & 0xffffu, (uint32_t)said->request, (uint32_t)said->slot,
             (uint32_t)said->reason, (uint32_t)said->launch_rule);
    }
    line(box, step, END, 0, (uint32_t)verified, (uint32_t)exover_fault(r2c), 0, 0);
    return verified;
}

size_t exover_box_ask(exover_box *box, exover *r2c, int32_t request, const exover_value *args, size_t count)
{
    const uint32_t numbers[4] = {(uint32_t)request};
    begin(box, r2c, ASK, numbers, args, count);
    return end(box, r2c, exover_ask(r2c, request, args, count));
}

size_t exover_box_report(exover_box *box, exover *r2c, int32_t request, int32_t slot, enum exover_outcome outcome,
                         int32_t status, const exover_value *results, size_t count)
{
    const uint32_t numbers[4] = {(uint32_t)request, (uint32_t)slot, (uint32_t)outcome, (uint32_t)status};
    begin(box, r2c, REPORT, numbers, results, count);
    return end(box, r2c, exover_report(r2c, request, slot, outcome, status, results, count));
}

size_t exover_box_observe(exover_box *box, exover *r2c, int32_t poster, exover_value value)
{
    const uint32_t numbers[4] = {(uint32_t)poster};
    begin(box, r2c, OBSERVE, numbers, &value, 1);
    return end(box, r2c, exover_observe(r2c, poster, value));
}

size_t exover_box_level(exover_box *box, exover *r2c, int32_t stock, int64_t level)
{
    const uint32_t numbers[4] = {(uint32_t)stock};
    const exover_value value = {.integer = level};
    begin(box, r2c, LEVEL, numbers, &value, 1);
    return end(box, r2c, exover_level(r2c, stock, level));
}

size_t exover_box_abort(exover_box *box, exover *r2c, int32_t request, int32_t slot)
{
    const uint32_t numbers[4] = {(uint32_t)request, (uint32_t)slot};
    begin(box, r2c, ABORT, numbers, NULL, 0);
    return end(box, r2c, exover_abort(r2c, request, slot));
}

size_t exover_box_abort_waiting(exover_box *box, exover *r2c, int32_t request)
{
    const uint32_t numbers[4] = {(uint32_t)request};
    begin(box, r2c, ABORT_WAITING, numbers, NULL, 0);
    return end(box, r2c, exover_abort_waiting(r2c, request));
}
