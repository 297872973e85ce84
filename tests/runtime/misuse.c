/* Does to a running checker what a host must not, or what radiation does between two instructions. For tests: hosted.
 *
 * The spec has requests 0 and 1, which must not be active together. Argument: what is done. `reenter` and `count` need an
 * x86-64 under Linux: its trap flag interrupts an ask after every single instruction. Prints what was seen.
 */
#define _GNU_SOURCE
#include "misuse_tables.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#if defined(__x86_64__) && defined(__linux__)
#include <ucontext.h>
#endif

enum { ROOM = MISUSE_MEMORY_BYTES / 8, BEHIND = 64 };

static uint64_t memory[ROOM + BEHIND];
static exover checker;
static const exover_value *no_values = NULL;

static void start(const exover_tables *tables)
{
    memset(memory, 0xa5, sizeof memory);
    if (exover_load_stopped(&checker, tables, memory, MISUSE_MEMORY_BYTES) != EXOVER_READY)
        exit(3);
}

static int launches(const exover *of, size_t count)
{
    int found = 0;
    for (size_t i = 0; i < count; i++)
        found += of->actions[i].kind == EXOVER_LAUNCH;
    return found;
}

#if defined(__x86_64__) && defined(__linux__)

static volatile long now, at;
static int bit;
static volatile int launched_within, met;
static const char *what;

static void trap(int number, siginfo_t *info, void *context)
{
    (void)number;
    (void)info;
    if (now++ != at)
        return;
    met = 1;
    ((ucontext_t *)context)->uc_mcontext.gregs[REG_EFL] &= ~0x100; /* the rest runs through */
    if (strcmp(what, "count") == 0)
        checker.count ^= (exover_int)1 << bit;
    else
        launched_within = launches(&checker, exover_ask(&checker, 1, no_values, 0));
}

/* Ask for request 0 with an interruption after its instruction `at`, whose own handler is not interrupted. */
static size_t interrupted(void)
{
    now = 0;
    met = 0;
    launched_within = 0;
    __asm__ volatile("pushfq\n\torq $0x100, (%%rsp)\n\tpopfq" ::: "memory", "cc");
    size_t count = exover_ask(&checker, 0, no_values, 0);
    __asm__ volatile("pushfq\n\tandq $~0x100, (%%rsp)\n\tpopfq" ::: "memory", "cc");
    return count;
}

/* After every instruction: launches of both of a pair, interruptions without a fault that were no step of their own. */
static void reenter(void)
{
    long both = 0, faults = 0, kept = 0;
    for (at = 0;; at++) {
        start(&misuse_tables);
        size_t count = interrupted();
        if (!met)
            break;
        int outer = launches(&checker, count > ROOM ? 0 : count), inner = launched_within;
        both += outer + inner > 1;
        faults += exover_fault(&checker) == EXOVER_FAULT_REENTRY;
        kept += launches(&checker, exover_ask(&checker, 1, no_values, 0)) + outer + inner > 1;
    }
    printf("%ld %ld %d\n", both, kept, faults > at / 2);
}

/* The number of answers changes after every instruction: nothing is written behind the memory, nothing else launched. */
static void count_flips(void)
{
    long wild = 0, wrong = 0;
    for (bit = 1; bit < 31; bit += 27) /* some places further, and far behind the memory */
        for (at = 0;; at++) {
            start(&misuse_tables);
            size_t count = interrupted();
            if (!met)
                break;
            for (int i = ROOM; i < ROOM + BEHIND; i++)
                wild += memory[i] != UINT64_C(0xa5a5a5a5a5a5a5a5);
            if (count > MISUSE_ROOM)
                wrong++;
        }
    printf("%ld %ld\n", wild, wrong);
}

static void stepped(void)
{
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_sigaction = trap;
    action.sa_flags = SA_SIGINFO;
    sigaction(SIGTRAP, &action, NULL);
    (strcmp(what, "count") == 0 ? count_flips : reenter)();
}

#endif

/* A checker that was copied: both would go on from here. */
static void copy(void)
{
    exover other;
    start(&misuse_tables);
    memcpy(&other, &checker, sizeof other);
    int launched = launches(&other, exover_ask(&other, 0, no_values, 0));
    launched += launches(&checker, exover_ask(&checker, 1, no_values, 0));
    printf("%d %d %d\n", launched, (int)exover_fault(&other), (int)exover_fault(&checker));
}

/* The same bit of every two pointers: they are not followed before the seal is compared. */
static void pointers(void)
{
    enum { COUNT = 6 };
    const size_t places[COUNT] = {offsetof(exover, actions), offsetof(exover, head),   offsetof(exover, reals),
                                  offsetof(exover, words),   offsetof(exover, values), offsetof(exover, cells)};
    long missed = 0;
    for (int i = 0; i < COUNT; i++)
        for (int k = i + 1; k < COUNT; k++)
            for (size_t flipped = 0; flipped < 8 * sizeof(void *); flipped++) {
                start(&misuse_tables);
                unsigned char *bytes = (unsigned char *)&checker + flipped / 8;
                bytes[places[i]] ^= (unsigned char)(1u << flipped % 8);
                bytes[places[k]] ^= (unsigned char)(1u << flipped % 8);
                (void)exover_ask(&checker, 0, no_values, 0);
                missed += exover_fault(&checker) != EXOVER_FAULT_CHECKER;
            }
    printf("%ld\n", missed);
}

/* What exover_fault tells when a bit of it has changed. */
static void numbers(void)
{
    long strange = 0;
    for (int damaged = 0; damaged < 2; damaged++)
        for (int flipped = 0; flipped < 32; flipped++) {
            start(&misuse_tables);
            if (damaged)
                checker.fault = EXOVER_FAULT_REENTRY;
            uint32_t found = (uint32_t)checker.fault ^ (uint32_t)1 << flipped;
            checker.fault = (exover_status)found;
            found = (uint32_t)exover_fault(&checker);
            strange += found > EXOVER_STILL_ACTIVE;
        }
    printf("%ld\n", strange);
}

/* Tables that begin between two numbers. */
static void alignment(void)
{
    static unsigned char room[sizeof(exover_word) * 4000];
    exover_tables moved;
    memcpy(&moved, &misuse_tables, sizeof moved);
    memcpy(room + 1, misuse_tables.words, sizeof(exover_word) * misuse_tables.word_count);
    moved.words = (const exover_word *)(const void *)(room + 1);
    printf("%d\n", (int)exover_load_stopped(&checker, &moved, memory, MISUSE_MEMORY_BYTES));
}

int main(int argc, char **argv)
{
    const char *mode = argc > 1 ? argv[1] : "";
    if (strcmp(mode, "copy") == 0)
        copy();
    else if (strcmp(mode, "pointers") == 0)
        pointers();
    else if (strcmp(mode, "numbers") == 0)
        numbers();
    else if (strcmp(mode, "alignment") == 0)
        alignment();
#if defined(__x86_64__) && defined(__linux__)
    else {
        what = mode;
        stepped();
    }
#endif
    return 0;
}
