/* Goes from the tables of one spec to those of another while requests run. For tests: hosted.
 *
 * Arguments: the map. Each mode prints what the calls return. OLD has m.a, m.b(v), m.c, m.gone, m.w; NEW has m.x, m.c, m.b(v),
 * m.a, m.w, where nothing keeps m.w from starting beside m.a.
 */
#include "new_tables.h"
#include "old_tables.h"

#include <stdio.h>
#include <string.h>

static uint64_t first[OLD_MEMORY_BYTES / 8 + 1], second[NEW_MEMORY_BYTES / 8 + 1];
static unsigned char map[1 << 14], record[OLD_RECORD_BYTES];
static size_t map_bytes, bytes;
static exover r2c;

static void told(size_t count)
{
    for (size_t i = 0; i < count; i++)
        printf("%s%d", r2c.actions[i].kind == EXOVER_LAUNCH ? "launch" : r2c.actions[i].kind == EXOVER_REJECT ? "reject" : "other", (int)r2c.actions[i].request);
    printf(" ");
}

static void export(void)
{
    bytes = exover_export(&r2c, record, sizeof record);
}

static void swap(void)
{
    size_t count = 99;
    exover_status status = exover_swap(&r2c, &new_tables, second, sizeof second, record, bytes, map, map_bytes, &count);
    printf("%d:", (int)status);
    told(count);
}

static const exover_value two[] = {{.integer = 2}};

static void begin(void)
{
    exover_load_stopped(&r2c, &old_tables, first, sizeof first);
}

int main(int argc, char **argv)
{
    FILE *file = argc > 1 ? fopen(argv[1], "rb") : NULL;
    if (file == NULL)
        return 2;
    map_bytes = fread(map, 1, sizeof map, file);
    fclose(file);

    /* What may go on goes on: m.c and m.a run, m.w waits for m.a, and starts at once. */
    begin();
    exover_ask(&r2c, OLD_M_C, NULL, 0);
    exover_ask(&r2c, OLD_M_A, NULL, 0);
    exover_ask(&r2c, OLD_M_W, NULL, 0);
    export();
    swap();
    printf("%d%d ", (int)exover_slot(&r2c, NEW_M_A, 0).phase, (int)exover_slot(&r2c, NEW_M_A, 0).since);
    told(exover_ask(&r2c, NEW_M_B, two, 1)); /* m.a runs */
    told(exover_report(&r2c, NEW_M_A, 0, EXOVER_OK, -1, NULL, 0));
    told(exover_ask(&r2c, NEW_M_B, two, 1)); /* m.c runs, which only NEW minds */
    told(exover_report(&r2c, NEW_M_C, 0, EXOVER_OK, -1, NULL, 0));
    told(exover_ask(&r2c, NEW_M_B, two, 1));
    printf("\n");

    /* What has to end first. */
    begin();
    exover_ask(&r2c, OLD_M_GONE, NULL, 0);
    export();
    swap();
    exover_report(&r2c, OLD_M_GONE, 0, EXOVER_OK, -1, NULL, 0);
    exover_ask(&r2c, OLD_M_B, two, 1);
    swap(); /* a record of before */
    export();
    swap();
    exover_report(&r2c, OLD_M_B, 0, EXOVER_OK, -1, NULL, 0);
    export();
    size_t count = 99;
    printf("%d ", (int)exover_swap(&r2c, &new_tables, first, sizeof first, record, bytes, map, map_bytes, &count));
    printf("%d ", (int)exover_swap(&r2c, &new_tables, second, 8, record, bytes, map, map_bytes, &count));
    printf("%d ", (int)exover_swap(&r2c, &old_tables, second, sizeof second, record, bytes, map, map_bytes, &count));
    told(exover_ask(&r2c, OLD_M_A, NULL, 0)); /* it goes on by OLD */
    told(exover_ask(&r2c, OLD_M_B, two, 1));
    export();
    int strange = 0;
    for (size_t bit = 0; bit < 8 * map_bytes; bit++) {
        map[bit / 8] ^= (unsigned char)(1u << bit % 8);
        strange += exover_swap(&r2c, &new_tables, second, sizeof second, record, bytes, map, map_bytes, &count) != EXOVER_BAD_MAP;
        map[bit / 8] ^= (unsigned char)(1u << bit % 8);
    }
    printf("%d ", strange);
    swap();
    told(exover_ask(&r2c, NEW_M_B, two, 1));
    printf("\n");

    /* After a restart. */
    memset(&r2c, 0, sizeof r2c);
    swap();
    told(exover_ask(&r2c, NEW_M_B, two, 1));
    printf("%d\n", (int)exover_resume(&r2c, &old_tables, first, sizeof first, record, bytes));
    return 0;
}
