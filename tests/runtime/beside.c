/* Flips single bits of tables and state while a checker of any spec runs, beside one that is sound. For tests: hosted.
 *
 * It stands behind runner.c, whose events it reads: MOMENTS times HORIZON of them. Until the fault is found every answer
 * has to be that of the sound checker, and a launch that the sound one does not answer with is one that the rules forbid
 * there: so is any that comes after the fault.
 * Argument: every how many bits. Output, a line for each place: its name, bits flipped, those that even a look at
 * everything does not find, unsafe launches, answers that differ otherwise.
 */
#include <string.h>

enum { MOMENTS = 6, HORIZON = 60, MOST_ACTIONS = 64, MOST_VALUES = 256 };

typedef struct answers {
    size_t count, values;
    exover_action actions[MOST_ACTIONS];
    uint64_t args[MOST_VALUES];
} answers;

static const uint32_t shape[] = {EXOVER_SHAPE};
static event events[MOMENTS * HORIZON];
static answers sound[MOMENTS * HORIZON];
static exover checker_at[MOMENTS];
static uint64_t memory_at[MOMENTS][sizeof memory / 8];
static exover_tables tables;

static void take(const event *e, answers *taken)
{
    taken->count = run(e);
    taken->values = 0;
    for (size_t i = 0; i < taken->count && i < MOST_ACTIONS; i++) {
        const exover_action *action = &checker.actions[i];
        taken->actions[i] = *action;
        if (action->kind == EXOVER_LAUNCH) {
            const exover_value *args = exover_args(&checker, (int32_t)action->request, (int32_t)action->slot);
            size_t arity = args == NULL ? 0 : exover_arity(&checker, (int32_t)action->request);
            for (size_t k = 0; k < arity && taken->values < MOST_VALUES; k++)
                taken->args[taken->values++] = args[k].bits;
        }
    }
}

static int same(const answers *a, const answers *b)
{
    return a->count == b->count && a->values == b->values && memcmp(a->args, b->args, 8 * a->values) == 0
           && memcmp(a->actions, b->actions, a->count * sizeof *a->actions) == 0;
}

static int launches(const answers *taken)
{
    int found = 0;
    for (size_t i = 0; i < taken->count; i++)
        found += taken->actions[i].kind == EXOVER_LAUNCH;
    return found;
}

/* The launches that are not among the sound ones; all of them if arguments differ. */
static int beyond(const answers *taken, const answers *sound_ones)
{
    int found = 0;
    if (taken->values != sound_ones->values || memcmp(taken->args, sound_ones->args, 8 * taken->values) != 0)
        return launches(taken);
    for (size_t i = 0; i < taken->count; i++) {
        int known = taken->actions[i].kind != EXOVER_LAUNCH;
        for (size_t k = 0; k < sound_ones->count; k++)
            known |= memcmp(&taken->actions[i], &sound_ones->actions[k], sizeof taken->actions[i]) == 0;
        found += !known;
    }
    return found;
}

static void flip(const char *place, void *start, size_t size, size_t stride)
{
    unsigned char *bytes = start;
    unsigned long flips = 0, missed = 0, unsafe = 0, differ = 0;
    const int mine = bytes == (unsigned char *)&checker || (bytes >= (unsigned char *)memory && bytes < (unsigned char *)memory + sizeof memory);
    for (size_t bit = 0; bit < 8 * size; bit += stride) {
        for (size_t moment = 0; moment < MOMENTS; moment++) {
            answers taken;
            size_t at = moment * HORIZON, end = at + HORIZON;
            checker = checker_at[moment];
            memcpy(memory, memory_at[moment], sizeof memory);
            bytes[bit / 8] ^= (unsigned char)(1u << bit % 8);
            while (at < end && exover_fault(&checker) == EXOVER_READY) {
                take(&events[at], &taken);
                if (!same(&taken, &sound[at])) {
                    unsafe += (unsigned long)beyond(&taken, &sound[at]);
                    differ += exover_fault(&checker) == EXOVER_READY;
                    at++;
                    break;
                }
                at++;
            }
            if (exover_fault(&checker) == EXOVER_READY)
                (void)exover_scrub(&checker, 8 * NATIVE_SCRUB_STEPS);
            missed += exover_fault(&checker) == EXOVER_READY;
            for (; at < end && exover_fault(&checker) != EXOVER_READY; at++) {
                take(&events[at], &taken);
                unsafe += (unsigned long)launches(&taken);
            }
            if (!mine)
                bytes[bit / 8] ^= (unsigned char)(1u << bit % 8);
            flips++;
        }
    }
    printf("%s %lu %lu %lu %lu\n", place, flips, missed, unsafe, differ);
}

int main(int argc, char **argv)
{
    const size_t stride = argc > 1 ? (size_t)atol(argv[1]) : 1;
    exover_word *words = malloc(native_tables.word_count * sizeof *words);
    exover_value *reals = malloc((native_tables.real_count + 1) * sizeof *reals);
    if (words == NULL || reals == NULL)
        return 2;
    memcpy(words, native_tables.words, native_tables.word_count * sizeof *words);
    if (native_tables.real_count != 0)
        memcpy(reals, native_tables.reals, native_tables.real_count * sizeof *reals);
    tables = native_tables;
    tables.words = words;
    tables.reals = reals;
    if (exover_load(&checker, &tables, memory, sizeof memory) != EXOVER_READY)
        return 3;
    for (size_t i = 0; i < MOMENTS * HORIZON; i++) {
        if (i % HORIZON == 0) {
            checker_at[i / HORIZON] = checker;
            memcpy(memory_at[i / HORIZON], memory, sizeof memory);
        }
        if (!read_event(&events[i]))
            return 4;
        event e = events[i];
        take(&e, &sound[i]);
        events[i].values = malloc(e.count * sizeof *e.values + 1);
        if (events[i].values == NULL)
            return 2;
        memcpy(events[i].values, e.values, e.count * sizeof *e.values);
        if (i + 1 < MOMENTS * HORIZON)
            events[i + 1].values = e.values;
        if (exover_fault(&checker) != EXOVER_READY)
            return 5;
    }
    flip("head", tables.head, sizeof tables.head, stride);
    flip("reals", reals, native_tables.real_count * sizeof *reals, stride);
    flip("words", words, native_tables.word_count * sizeof *words, stride);
    flip("values", memory, 16 * shape[EXOVER_VALUES], stride);
    flip("scratch", &checker.values[2 * shape[EXOVER_VALUES]], 8 * shape[EXOVER_SCRATCH], stride);
    flip("cells", checker.cells, shape[EXOVER_CELLS] * sizeof *checker.cells, stride);
    flip("checker", &checker, sizeof checker, stride);
    return 0;
}
