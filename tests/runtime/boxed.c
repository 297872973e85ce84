/* boxed.c - runner.c with a black box of $LINES lines, dumped into $BOX at the end. What stands in that file is there when the
 * program starts. */
#include "native_tables.h"
#include "exover_box.h"

#include <stdio.h>
#include <stdlib.h>

static uint8_t record[EXOVER_BOX_BYTES(20000)];
static size_t length;
static exover_box box;

static void dump(void)
{
    FILE *file = fopen(getenv("BOX"), "wb");
    fwrite(record, 1, length, file);
    fclose(file);
}

/* Change a bit of the box itself. */
static void lose(void)
{
    const char *field = getenv("FIELD");
    if (field == NULL || *field == 0)
        return;
    if (*field == 'm')
        box.memory = (uint8_t *)((uintptr_t)box.memory ^ 1u << 20);
    else if (*field == 'l')
        box.lines ^= 1u << 9;
    else
        box.seal ^= 1u;
}

static exover_status load(exover *r2c, const exover_tables *tables, void *memory, size_t size)
{
    static bool running;
    length = EXOVER_BOX_BYTES((size_t)atoi(getenv("LINES")));
    FILE *file = running ? NULL : fopen(getenv("BOX"), "rb");
    const exover_status found = exover_load_stopped(r2c, tables, memory, size);
    if (file != NULL) {
        if (fread(record, 1, length, file) != length)
            exit(3);
        fclose(file);
    }
    if (!running)
        atexit(dump);
    running = true;
    if (!exover_box_open(&box, r2c, record, length))
        exit(4);
    lose();
    return found;
}

#undef exover_ask
#undef exover_report
#undef exover_observe
#undef exover_level
#undef exover_abort
#undef exover_abort_waiting
#define exover_ask(...) exover_box_ask(&box, __VA_ARGS__)
#define exover_report(...) exover_box_report(&box, __VA_ARGS__)
#define exover_observe(...) exover_box_observe(&box, __VA_ARGS__)
#define exover_level(...) exover_box_level(&box, __VA_ARGS__)
#define exover_abort(...) exover_box_abort(&box, __VA_ARGS__)
#define exover_abort_waiting(...) exover_box_abort_waiting(&box, __VA_ARGS__)
#define exover_load_stopped(...) load(__VA_ARGS__)

#include "runner.c"
