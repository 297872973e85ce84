/* A checker whose state goes out in records and comes back. For tests: hosted; it stands behind runner.c, whose events it
 * reads.
 *
 * `swaps MAP`: see below. `trip`: all events once; then again, the checker taken away before each, and resumed. Prints how many answers differ.
 * `show N`: N events; then prints the record in hexadecimal. `try RECORD…`: prints for each file the status of resuming
 * it, and whether it is denied then what is asked first. `live`: prints what a loaded checker, sound and faulty, refuses.
 * `maps`, `exports`, `calls`: see below.
 */
#include <string.h>

enum { MOST = 4096, ANSWERS = 32, ROOM = NATIVE_RECORD_BYTES };

static unsigned char record[ROOM + 8];
static event events[MOST];
static exover_action first[MOST][ANSWERS];
static size_t counts[MOST];
static unsigned char map[1 << 16];

static int take_away_and_resume(void)
{
    size_t bytes = exover_export(&checker, record, ROOM);
    if (bytes != ROOM)
        return -1;
    memset(&checker, 0, sizeof checker);
    memset(memory, 0xa5, sizeof memory);
    return (int)exover_resume(&checker, &native_tables, memory, sizeof memory, record, bytes);
}

/* Answers all events, notes them with their answers, and starts anew; returns how many there are. */
static size_t answered(void)
{
    size_t length = 0;
    event e = {0, {0}, 0, NULL};
    for (; length < MOST && read_event(&e); e.values = NULL) {
        events[length] = e;
        counts[length] = run(&e);
        memcpy(first[length], checker.actions, (counts[length] < ANSWERS ? counts[length] : ANSWERS) * sizeof first[0][0]);
        length++;
    }
    start();
    return length;
}

/* Answers a noted event again; returns whether the answers differ from those noted. */
static int differs(size_t number)
{
    size_t count = run(&events[number]);
    return count != counts[number] || memcmp(checker.actions, first[number], count * sizeof first[0][0]) != 0;
}

/* Reads a file of at most `most` bytes; returns its size. */
static size_t contents(const char *path, unsigned char *bytes, size_t most)
{
    FILE *file = fopen(path, "rb");
    if (file == NULL)
        give_up("no such file");
    size_t size = fread(bytes, 1, most, file);
    fclose(file);
    return size;
}

static void trip(void)
{
    size_t length = answered(), differ = 0, refused = 0;
    for (size_t i = 0; i < length; i++) {
        refused += take_away_and_resume() != EXOVER_READY;
        differ += differs(i);
    }
    printf("%zu %zu %zu %u\n", length, refused, differ, (unsigned)(exover_step(&checker) - (uint32_t)length));
}

/* As `trip`, but by a map from these tables to themselves, into two memories in turn. */
static void swaps(const char *path)
{
    static uint64_t other[sizeof memory / 8];
    size_t map_bytes = contents(path, map, sizeof map);
    size_t length = answered(), differ = 0, refused = 0, spoke = 0;
    for (size_t i = 0; i < length; i++) {
        size_t said = 0, bytes = exover_export(&checker, record, ROOM);
        refused += exover_swap(&checker, &native_tables, i % 2 != 0 ? memory : other, sizeof memory, record, bytes, map,
                               map_bytes, &said) != EXOVER_READY;
        spoke += said;
        differ += differs(i);
    }
    printf("%zu %zu %zu %zu\n", length, refused, differ, spoke);
}

static void show(long number)
{
    event e = {0, {0}, 0, NULL};
    while (number-- > 0 && read_event(&e))
        run(&e);
    free(e.values);
    size_t bytes = exover_export(&checker, record, ROOM);
    for (size_t i = 0; i < bytes; i++)
        printf("%02x", record[i]);
    printf("\n%zu %zu %zu\n", exover_export(&checker, record, ROOM - 1), exover_export(&checker, NULL, ROOM),
           exover_export(&checker, record, ROOM));
}

static void try(const char *path)
{
    static unsigned char bytes[2 * ROOM + 64];
    size_t size = contents(path, bytes, sizeof bytes);
    memset(&checker, 0, sizeof checker);
    int status = (int)exover_resume(&checker, &native_tables, memory, sizeof memory, bytes, size);
    size_t count = exover_ask(&checker, 0, NULL, 0);
    printf("%d %d\n", status, count == 1 && checker.actions[0].kind == EXOVER_REJECT && checker.actions[0].reason == EXOVER_FAULTY);
}

/* The status of going on by a map from these tables to themselves, for each file; with one request running. */
static void maps(int count, char **paths)
{
    static uint64_t other[sizeof memory / 8];
    for (int i = 0; i < count; i++) {
        size_t said, size = contents(paths[i], map, sizeof map);
        start();
        size_t bytes = exover_export(&checker, record, ROOM);
        printf("%d ", (int)exover_swap(&checker, &native_tables, other, sizeof other, record, bytes, map, size, &said));
        record[0] ^= 1;
        printf("%d\n", (int)exover_swap(&checker, &native_tables, other, sizeof other, record, bytes, map, size, &said));
    }
}

/* How many bytes are exported of: a record longer than memory; a copy; a checker whose agenda, cells or values have changed,
 * or that is faulty whatever its guard says. */
static void exports(void)
{
    printf("%zu ", exover_export(&checker, record, SIZE_MAX));
    exover other = checker;
    printf("%zu ", exover_export(&other, record, ROOM));
    checker.agenda ^= 1;
    printf("%zu ", exover_export(&checker, record, ROOM));
    start();
    checker.agenda ^= 16;
    checker.guard ^= 16;
    printf("%zu ", exover_export(&checker, record, ROOM));
    start();
    for (exover_cell *cell = checker.cells; (void *)cell < (void *)checker.actions; cell++)
        cell->now ^= 4;
    printf("%zu ", exover_export(&checker, record, ROOM));
    start();
    checker.values[0].bits ^= 1;
    printf("%zu\n", exover_export(&checker, record, ROOM));
}

/* What resuming and swapping return of no checker, no tables, another build, no record, and one that is longer than memory. */
static void calls(void)
{
    size_t said;
    start();
    size_t bytes = exover_export(&checker, record, ROOM);
    const exover_home home = {&native_tables, memory, sizeof memory, sizeof checker, EXOVER_BUILD};
    exover_home homes[] = {home, home, home, home};
    homes[1].tables = NULL;
    homes[2].bytes++;
    homes[3].build++;
    for (int i = 0; i < 4; i++) {
        exover *of = i == 0 ? NULL : &checker;
        printf("%d ", (int)exover_resume_built(of, &homes[i], record, bytes));
        printf("%d ", (int)exover_swap_built(of, &homes[i], record, bytes, NULL, 0, &said));
    }
    memset(&checker, 0, sizeof checker);
    printf("%d %d ", (int)exover_resume_built(&checker, &home, NULL, bytes), (int)exover_resume_built(&checker, &home, record, SIZE_MAX));
    start();
    checker.cells[0].now ^= 4; /* it is faulty, and live: so it stays, if it is resumed in vain */
    exover_scrub(&checker, 4 * 8);
    homes[0].size = 8;
    printf("%d ", (int)exover_resume_built(&checker, &homes[0], record, bytes));
    printf("%d\n", (int)exover_load(&checker, &native_tables, memory, sizeof memory));
}

static int again(void)
{
    return (int)exover_load(&checker, &native_tables, memory, sizeof memory);
}

static int back(size_t bytes)
{
    return (int)exover_resume(&checker, &native_tables, memory, sizeof memory, record, bytes);
}

/* The first two requests exclude each other. */
static void live(void)
{
    size_t bytes = exover_export(&checker, record, ROOM);
    printf("%d %d ", again(), back(bytes));
    exover_ask(&checker, 0, NULL, 0);
    printf("%d ", again());
    size_t count = exover_ask(&checker, 1, NULL, 0);
    printf("%d ", count == 1 && checker.actions[0].kind == EXOVER_REJECT);
    unsigned char stale[ROOM];
    memcpy(stale, record, sizeof stale);
    bytes = exover_export(&checker, record, ROOM);
    checker.cells[0].now ^= 4; /* a fault, found by the step that comes */
    exover_ask(&checker, 1, NULL, 0);
    exover_ask(&checker, 1, NULL, 0);
    printf("%d %d %zu ", (int)exover_fault(&checker), again(), exover_export(&checker, record + 0, 0));
    unsigned char good[ROOM];
    memcpy(good, record, sizeof good);
    memcpy(record, stale, sizeof stale);
    printf("%d ", back(bytes));
    memcpy(record, good, sizeof good);
    printf("%d ", back(bytes));
    count = exover_ask(&checker, 1, NULL, 0);
    printf("%d ", count == 1 && checker.actions[0].kind == EXOVER_REJECT && checker.actions[0].reason >= 0);
    exover_report(&checker, 0, 0, EXOVER_OK, -1, NULL, 0);
    count = exover_ask(&checker, 1, NULL, 0);
    printf("%d ", count == 1 && checker.actions[0].kind == EXOVER_LAUNCH);
    checker.seal ^= 1; /* lost: not even where its memory is */
    printf("%d ", again());
    exover_ask(&checker, 0, NULL, 0);
    printf("%d ", again());
    start();
    printf("%d\n", exover_ask(&checker, 0, NULL, 0) == 1 && checker.actions[0].kind == EXOVER_LAUNCH);
}

int main(int argc, char **argv)
{
    const char *mode = argc > 1 ? argv[1] : "";
    start();
    if (strcmp(mode, "trip") == 0)
        trip();
    else if (strcmp(mode, "swaps") == 0)
        swaps(argv[2]);
    else if (strcmp(mode, "show") == 0)
        show(strtol(argv[2], NULL, 10));
    else if (strcmp(mode, "maps") == 0)
        maps(argc - 2, argv + 2);
    else if (strcmp(mode, "exports") == 0)
        exports();
    else if (strcmp(mode, "calls") == 0)
        calls();
    else if (strcmp(mode, "live") == 0)
        live();
    else
        for (int i = 2; i < argc; i++)
            try(argv[i]);
    return 0;
}
