/* The mutexes alone, as one would write them by hand: a bit mask for each request, no reasons, no faults, no waiting.
 *
 * It reads the events of runner.c, of which it knows asks and reports of requests without arguments, and prints the
 * seconds that N runs of them took. `rows.h` gives REQUESTS, WORDS and the masks.
 */
#include "rows.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef struct event {
    char kind;
    int request;
} event;

static uint64_t active[WORDS];

int hand_ask(int request);
int hand_report(int request);

/* 1: launched, 0: rejected, -1: no such request. */
int hand_ask(int request)
{
    if (request < 0 || request >= REQUESTS)
        return -1;
    for (int word = 0; word < WORDS; word++)
        if (rows[request][word] & active[word])
            return 0;
    active[request / 64] |= UINT64_C(1) << request % 64;
    return 1;
}

int hand_report(int request)
{
    if (request < 0 || request >= REQUESTS || !(active[request / 64] >> request % 64 & 1))
        return -1;
    active[request / 64] &= ~(UINT64_C(1) << request % 64);
    return 1;
}

int main(int argc, char **argv)
{
    static event events[1 << 16];
    size_t length = 0;
    long launched = 0, repeats = argc > 1 ? strtol(argv[1], NULL, 10) : 1;
    char line[80];
    while (length < 1 << 16 && fgets(line, sizeof line, stdin) != NULL) {
        events[length].kind = line[0];
        events[length++].request = atoi(line + 2);
    }
    clock_t begin = clock();
    for (long i = 0; i < repeats; i++)
        for (size_t k = 0; k < length; k++)
            launched += events[k].kind == 'a' ? hand_ask(events[k].request) : hand_report(events[k].request);
    printf("%.9f %ld\n", (double)(clock() - begin) / CLOCKS_PER_SEC, launched);
    return 0;
}
