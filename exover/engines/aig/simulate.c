/* Many runs of an And-Inverter Graph at once: a signal is `width` words, a bit for each run. */
#include <stddef.h>
#include <stdint.h>

/* Writes the values of `count` conjunctions behind those of the first `known` signals. Of each conjunction there are
   two operands: twice the place of a signal before it, plus one where that is complemented. */
void simulate(uint64_t *values, size_t width, size_t known, size_t count, const uint32_t *operands)
{
    uint64_t *restrict to = values + known * width;
    for (size_t gate = 0; gate < count; gate++, to += width) {
        const uint32_t left = operands[2 * gate], right = operands[2 * gate + 1];
        const uint64_t *one = values + (left >> 1) * width, *other = values + (right >> 1) * width;
        const uint64_t flip = 0 - (uint64_t)(left & 1), turn = 0 - (uint64_t)(right & 1);
        for (size_t word = 0; word < width; word++) {
            to[word] = (one[word] ^ flip) & (other[word] ^ turn);
        }
    }
}

/* Writes what `count` latches are after the step: what operands say in the runs that are going, and in the others what
   they were. The signals of the latches are those after the first. */
void follow(const uint64_t *values, size_t width, size_t count, const uint32_t *following, const uint64_t *going,
            uint64_t *restrict after)
{
    for (size_t latch = 0; latch < count; latch++, after += width) {
        const uint64_t *before = values + (1 + latch) * width, *next = values + (following[latch] >> 1) * width;
        const uint64_t flip = 0 - (uint64_t)(following[latch] & 1);
        for (size_t word = 0; word < width; word++) {
            after[word] = before[word] ^ ((before[word] ^ next[word] ^ flip) & going[word]);
        }
    }
}
