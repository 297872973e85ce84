/* Inner loops over And-Inverter Graphs. Of a node there are two literals, both 0 if it is no conjunction; a literal is
   twice a node before it, plus one where that is complemented. */
#include <stddef.h>
#include <stdint.h>

/* Marks the nodes that marked ones depend on: within a step, and in any number of steps through the latches given, of
   each its node and the node of what it is after a step. */
void mark(const uint32_t *literals, size_t count, const uint32_t *latches, size_t followed, uint8_t *restrict marked)
{
    int more = 1;
    while (more) {
        for (size_t node = count; node-- > 0;) {
            if (marked[node] && literals[2 * node + 1]) {
                marked[literals[2 * node] >> 1] = marked[literals[2 * node + 1] >> 1] = 1;
            }
        }
        more = 0;
        for (size_t latch = 0; latch < followed; latch++) {
            if (marked[latches[2 * latch]] && !marked[latches[2 * latch + 1]]) {
                marked[latches[2 * latch + 1]] = 1;
                more = 1;
            }
        }
    }
}

/* Gives each conjunction among `count` nodes, in their order, the next place from `next` on, and writes its operands:
   of its two literals twice the places of their nodes, plus one where they are complemented. Returns the place after
   the last. */
size_t place(const uint32_t *literals, size_t count, const uint32_t *nodes, size_t next, uint32_t *restrict places,
           uint32_t *restrict operands)
{
    for (size_t at = 0; at < count; at++) {
        const uint32_t *pair = literals + 2 * (size_t)nodes[at];
        if (pair[1]) {
            *operands++ = 2 * places[pair[0] >> 1] + (pair[0] & 1);
            *operands++ = 2 * places[pair[1] >> 1] + (pair[1] & 1);
            places[nodes[at]] = (uint32_t)next++;
        }
    }
    return next;
}

/* In the functions below many runs go on at once: a signal is `width` words, a bit for each run. */

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

/* Looks among `count` pairs of signals, two places each, for runs in which both are true: up to `most` runs, each with a
   pair that none before it has. Writes how many to `found`, then which; their bits to `have`, which is all zero before.
   Keeps the pairs that none of them has, in their order, and returns how many these are. */
size_t cover(const uint64_t *signals, size_t width, uint32_t *pairs, size_t count, size_t most, uint32_t *found,
             uint64_t *restrict have)
{
    size_t left = 0;
    found[0] = 0;
    for (size_t pair = 0; pair < count; pair++) {
        const uint32_t first = pairs[2 * pair], second = pairs[2 * pair + 1];
        const uint64_t *one = signals + first * width, *other = signals + second * width;
        uint64_t any = 0, had = 0;
        for (size_t word = 0; word < width; word++) {
            any |= one[word] & other[word];
            had |= one[word] & other[word] & have[word];
        }
        if (any && !had && found[0] < most) {
            size_t word = 0;
            uint32_t bit = 0;
            while (!(one[word] & other[word])) {
                word++;
            }
            while (!(one[word] & other[word] & (uint64_t)1 << bit)) {
                bit++;
            }
            have[word] |= (uint64_t)1 << bit;
            found[++found[0]] = (uint32_t)(64 * word) + bit;
        } else if (!had) {
            pairs[2 * left] = first;
            pairs[2 * left + 1] = second;
            left++;
        }
    }
    return left;
}

/* Writes a number for each of `count` operands, equal for such as are equal in every run; others hardly ever are. */
void sign(const uint64_t *values, size_t width, size_t count, const uint32_t *operands, uint64_t *restrict signatures)
{
    for (size_t number = 0; number < count; number++) {
        const uint64_t *signal = values + (operands[number] >> 1) * width;
        const uint64_t flip = 0 - (uint64_t)(operands[number] & 1);
        uint64_t mixed = 0;
        for (size_t word = 0; word < width; word++) {
            mixed = (mixed ^ signal[word] ^ flip) * UINT64_C(0x9e3779b97f4a7c15);
            mixed ^= mixed >> 32;
        }
        signatures[number] = mixed;
    }
}

/* Writes which of `count` operands, by number, are true in some of the runs, and returns how many are. */
size_t somewhere(const uint64_t *values, size_t width, size_t count, const uint32_t *operands, const uint64_t *runs,
                 uint32_t *restrict found)
{
    size_t many = 0;
    for (size_t number = 0; number < count; number++) {
        const uint64_t *signal = values + (operands[number] >> 1) * width;
        const uint64_t flip = 0 - (uint64_t)(operands[number] & 1);
        uint64_t any = 0;
        for (size_t word = 0; word < width; word++) {
            any |= (signal[word] ^ flip) & runs[word];
        }
        if (any) {
            found[many++] = (uint32_t)number;
        }
    }
    return many;
}
