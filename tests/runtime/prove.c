/* prove.c - what Frama-C's Eva looks at (`make prove`), each with the tables of one spec:
 *
 * nothing defined   loading into memory that holds anything, and that ends where the size that the host says ends: what is
 *                   written behind it is an error. Sizes are those around what is needed.
 * SCRUB             scrubbing any number of bytes of a checker that has been loaded.
 * EVENT=0 to 5      any first event of a kind: any request, slot and values, also those that there are not. */
#include "proved_tables.h"

#include "__fc_builtin.h"

static uint64_t memory[PROVED_MEMORY_BYTES / 8 + 2];
static exover r2c;

#if defined SCRUB || defined EVENT
static bool is_loaded(void)
{
    return exover_load(&r2c, &proved_tables, memory, sizeof memory) == EXOVER_READY;
}
#endif

#if defined EVENT
/* Requests, posters and stocks are numbered from 0, and there are at most four of each; slots, too. */
static void any_event(void)
{
    static exover_value values[3];
    Frama_C_make_unknown((char *)values, sizeof values);
    const int32_t subject = Frama_C_interval_split(-1, 4), slot = Frama_C_interval_split(-2, 3);
    const size_t count = (size_t)Frama_C_interval_split(0, 3);
    const exover_value *given = values + 3 - count; /* behind the last of them there is nothing */
    switch (EVENT) {
    case 0:
        exover_ask(&r2c, subject, given, count);
        break;
    case 1:
        exover_report(&r2c, subject, slot, (enum exover_outcome)Frama_C_interval_split(0, 3),
                      Frama_C_interval_split(-1, 1), given, count);
        break;
    case 2:
        exover_observe(&r2c, subject, values[0]);
        break;
    case 3:
        exover_level(&r2c, subject, values[0].integer);
        break;
    case 4:
        exover_abort(&r2c, subject, slot);
        break;
    default:
        exover_abort_waiting(&r2c, subject);
        break;
    }
}
#endif

int main(void)
{
#if defined SCRUB
    return is_loaded() ? (int)exover_scrub(&r2c, (uint32_t)Frama_C_interval_split(0, 64)) : 0;
#elif defined EVENT
    if (is_loaded()) {
        any_event();
    }
    return 0;
#else
    const size_t size = (size_t)Frama_C_interval_split(PROVED_MEMORY_BYTES - 12, PROVED_MEMORY_BYTES + 12);
    Frama_C_make_unknown((char *)memory, sizeof memory);
    Frama_C_make_unknown((char *)&r2c, sizeof r2c);
    return (int)exover_load(&r2c, &proved_tables, (char *)memory + sizeof memory - size, size);
#endif
}
