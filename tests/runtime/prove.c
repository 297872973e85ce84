/* prove.c - what Frama-C's Eva looks at (`make prove`): loading emitted tables into memory that holds anything, and that ends where
 * the size that the host says ends: what is written behind it is an error. Sizes are those around what is needed. */
#include "proved_tables.h"

#include "__fc_builtin.h"

static uint64_t memory[PROVED_MEMORY_BYTES / 8 + 2];
static exover r2c;

int main(void)
{
    const size_t size = (size_t)Frama_C_interval_split(PROVED_MEMORY_BYTES - 12, PROVED_MEMORY_BYTES + 12);
    Frama_C_make_unknown((char *)memory, sizeof memory);
    Frama_C_make_unknown((char *)&r2c, sizeof r2c);
    return (int)exover_load(&r2c, &proved_tables, (char *)memory + sizeof memory - size, size);
}
