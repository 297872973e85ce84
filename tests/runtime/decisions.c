/* Random decisions of the emitted checker against the rules read a second time, one after another. For tests: hosted.
 *
 * Argument: how many. Input (32 bits each, of this machine): the number of requests, the number of rules, then of each
 * rule, in the order of the text, the two requests that it keeps apart and the reason it gives. Nothing else is asked of
 * the rules: they reject. It prints how many were launched, rejected and reported, or what differed.
 */
#include "mutexes_tables.h"

#include <stdio.h>
#include <stdlib.h>

enum { MOST = 256, RULES = 4096 };

static uint64_t memory[MUTEXES_MEMORY_BYTES / 8 + 1];
static exover checker;
static uint32_t requests, count;
static uint32_t rules[RULES][3];
static unsigned char active[MOST];
static uint64_t lot = 20261121;

static uint32_t draw(uint32_t below)
{
    lot = lot * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(lot >> 33) % below;
}

/* The reason for which a request is rejected, 0 for busy; -1 if it is launched. */
static int due(uint32_t request)
{
    if (active[request])
        return 0;
    for (uint32_t i = 0; i < count; i++)
        if ((rules[i][0] == request && active[rules[i][1]]) || (rules[i][1] == request && active[rules[i][0]]))
            return (int)rules[i][2];
    return -1;
}

static uint32_t number(void)
{
    uint32_t read;
    if (fread(&read, sizeof read, 1, stdin) != 1)
        exit(2);
    return read;
}

int main(int argc, char **argv)
{
    unsigned long long todo = argc > 1 ? strtoull(argv[1], NULL, 10) : 0, launched = 0, rejected = 0, reported = 0;
    requests = number();
    count = number();
    if (requests > MOST || count > RULES)
        return 2;
    for (uint32_t i = 0; i < 3 * count; i++)
        rules[i / 3][i % 3] = number();
    if (exover_load_stopped(&checker, &mutexes_tables, memory, MUTEXES_MEMORY_BYTES) != EXOVER_READY)
        return 3;
    while (launched + rejected < todo) {
        uint32_t request = draw(requests);
        if (active[request] && draw(2)) {
            if (exover_report(&checker, (int32_t)request, 0, EXOVER_OK, -1, NULL, 0) != 0)
                return 4;
            active[request] = 0;
            reported++;
            continue;
        }
        int reason = due(request);
        const exover_action *answer = checker.actions;
        int good = exover_ask(&checker, (int32_t)request, NULL, 0) == 1 && answer->request == (exover_word)request
                   && answer->kind == (reason < 0 ? EXOVER_LAUNCH : EXOVER_REJECT) && answer->reason == reason;
        if (!good) {
            printf("request %u is due %d, got %d for %d\n", (unsigned)request, reason, (int)answer->kind, (int)answer->reason);
            return 1;
        }
        active[request] = reason < 0 ? 1 : active[request];
        launched += reason < 0;
        rejected += reason >= 0;
    }
    printf("%llu %llu %llu\n", launched, rejected, reported);
    return 0;
}
