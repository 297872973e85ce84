/* The mutexes alone, as one would write them by hand: a bit mask for each request, no faults, no second channel.
 *
 * The check says whether a request may be launched, and remembers what is active. With -DWHOLE it is a whole step, as
 * far as masks go: it validates the event, says what is in the way, lets a request wait if it is one of those that may,
 * and a report lets what waits try again. Both believe their memory.
 * It reads the events of runner.c, of which it knows asks and reports of requests without arguments, and prints the
 * seconds that N runs of them took. `rows.h` gives REQUESTS, WORDS and the masks.
 */
#include "rows.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef struct event {
    char kind;
    int request, slot, outcome, status;
} event;

typedef struct answer {
    short kind, request, reason;
} answer;

enum { LAUNCH = 1, WAIT, REJECT };

static uint64_t active[WORDS];

#define ENTRY __attribute__((noinline)) /* so that callgrind sees it */

ENTRY int hand_ask(int request);
ENTRY int hand_report(int request);

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

static uint64_t waiting[WORDS], may_wait[WORDS];
static answer answers[REQUESTS + 1];
static int count;

ENTRY int step_ask(int request, int arguments);
ENTRY int step_report(int request, int slot, int outcome, int status);

static void say(int kind, int request, int reason)
{
    answers[count].kind = (short)kind;
    answers[count].request = (short)request;
    answers[count++].reason = (short)reason;
}

/* The first active request in the way, -1 if there is none. */
static int in_the_way(int request)
{
    for (int word = 0; word < WORDS; word++) {
        uint64_t met = rows[request][word] & active[word];
        if (met)
            return 64 * word + __builtin_ctzll(met);
    }
    return -1;
}

static void decide(int request)
{
    int other = in_the_way(request), word = request / 64;
    uint64_t bit = UINT64_C(1) << request % 64;
    if (other < 0) {
        active[word] |= bit;
        waiting[word] &= ~bit;
        say(LAUNCH, request, -1);
    } else if (!(may_wait[word] & bit)) {
        say(REJECT, request, other);
    } else if (!(waiting[word] & bit)) {
        waiting[word] |= bit;
        say(WAIT, request, other);
    }
}

/* The number of answers, -1 for no event. */
int step_ask(int request, int arguments)
{
    if (request < 0 || request >= REQUESTS || arguments != 0)
        return -1;
    count = 0;
    decide(request);
    return count;
}

int step_report(int request, int slot, int outcome, int status)
{
    if (request < 0 || request >= REQUESTS || slot != 0 || outcome < 1 || outcome > 3 || status != -1
        || !(active[request / 64] >> request % 64 & 1))
        return -1;
    count = 0;
    active[request / 64] &= ~(UINT64_C(1) << request % 64);
    for (int word = 0; word < WORDS; word++)
        for (uint64_t left = waiting[word]; left != 0; left &= left - 1)
            decide(64 * word + __builtin_ctzll(left));
    return count;
}

static int run(const event *e)
{
#ifdef WHOLE
    return e->kind == 'a' ? step_ask(e->request, 0) : step_report(e->request, e->slot, e->outcome, e->status);
#else
    return e->kind == 'a' ? hand_ask(e->request) : hand_report(e->request);
#endif
}

int main(int argc, char **argv)
{
    static event events[1 << 16];
    size_t length = 0;
    long launched = 0, repeats = argc > 1 ? strtol(argv[1], NULL, 10) : 1;
    char line[80];
    while (length < 1 << 16 && fgets(line, sizeof line, stdin) != NULL) {
        event *e = &events[length++];
        if (sscanf(line, "%c %d %d %d %d", &e->kind, &e->request, &e->slot, &e->outcome, &e->status) < 2)
            return 2;
    }
    clock_t begin = clock();
    for (long i = 0; i < repeats; i++)
        for (size_t k = 0; k < length; k++)
            launched += run(&events[k]);
    printf("%.9f %ld\n", (double)(clock() - begin) / CLOCKS_PER_SEC, launched);
    return 0;
}
