/* What a checker tells of arguments that have changed, and what it answers after each single flip of its state. For tests.
 *
 * Request 0 has arguments; 1 waits for 0; 2 is for itself. Argument: what is looked at. Prints what was seen.
 */
#include "faulty_api.h"

#include <stdio.h>
#include <string.h>

static faulty_checker r2c;

static bool has(size_t count, int kind, int request, int reason)
{
    for (size_t i = 0; i < count; i++) {
        const exover_action *action = &r2c.generic.actions[i];
        if (action->kind == kind && action->request == request && action->reason == reason)
            return true;
    }
    return false;
}

/* Request 0 runs, 1 waits for it. */
static void start(void)
{
    if (faulty_start_stopped(&r2c) != EXOVER_READY || faulty_ask_m_a(&r2c, 3, 0.5, NULL) != EXOVER_READY
        || faulty_ask_m_b(&r2c, NULL) != EXOVER_READY)
        printf("no start ");
}

/* Every bit of both arguments, kept and complement: handed out flipped; not a fault from then on. */
static void arguments(void)
{
    int handed = 0, silent = 0;
    const size_t values = (size_t)((unsigned char *)r2c.generic.cells - (unsigned char *)r2c.generic.values) / 16;
    for (size_t half = 0; half < 2; half++)
        for (size_t bit = 0; bit < 128; bit++) {
            faulty_m_a_args args;
            start();
            r2c.generic.values[half * values + bit / 64].bits ^= UINT64_C(1) << bit % 64;
            handed += faulty_args_m_a(&r2c, &args);
            silent += exover_fault(&r2c.generic) != EXOVER_FAULT_STATE
                      || exover_ask(&r2c.generic, 2, NULL, 0) == 0 || exover_fault(&r2c.generic) == EXOVER_READY;
        }
    printf("%d %d\n", handed, silent);
}

/* Every bit of all cells: after the fault, aborts without a kill, and waiting requests that nobody was told of. */
static void answers(void)
{
    const size_t size = (size_t)((unsigned char *)r2c.generic.actions - (unsigned char *)r2c.generic.cells);
    int faults = 0, unkilled = 0, untold = 0, launched = 0;
    for (size_t bit = 0; bit < 8 * size; bit++) {
        start();
        ((unsigned char *)r2c.generic.cells)[bit / 8] ^= (unsigned char)(1u << bit % 8);
        size_t count = exover_report(&r2c.generic, FAULTY_M_A, 0, EXOVER_OK, -1, NULL, 0);
        bool b = has(count, EXOVER_LAUNCH, FAULTY_M_B, -1), told = has(count, EXOVER_REJECT, FAULTY_M_B, EXOVER_FAULTY);
        for (int i = 0; i < FAULTY_SCRUB_STEPS && exover_fault(&r2c.generic) == EXOVER_READY; i++)
            (void)exover_abort(&r2c.generic, FAULTY_M_C, 0);
        faults += exover_fault(&r2c.generic) != EXOVER_READY;
        count = exover_ask(&r2c.generic, FAULTY_M_B, NULL, 0);
        launched += has(count, EXOVER_LAUNCH, FAULTY_M_B, -1);
        untold += !b && !told && !has(count, EXOVER_REJECT, FAULTY_M_B, EXOVER_FAULTY);
        for (int request = 0; request < 3; request++) {
            count = exover_abort(&r2c.generic, request, 0);
            unkilled += !has(count, EXOVER_KILL, request, EXOVER_ABORTED);
        }
    }
    printf("%d %d %d %d\n", faults == (int)(8 * size), unkilled, untold, launched);
}

/* What waits is told in the first answer after the fault, whichever call has it; and once. */
static void told(void)
{
    static const char *const CALLS[] = {"ask", "report", "observe", "abort", "abort waiting"};
    for (size_t call = 0; call < sizeof CALLS / sizeof *CALLS; call++)
        for (int twice = 0; twice < 2; twice++) {
            exover *c = &r2c.generic;
            size_t count = 0;
            if (!twice)
                start();
            c->cells[0].inverse ^= twice ? 0u : 1u;
            c->compared = 0;
            switch (call) {
            case 0: count = exover_ask(c, FAULTY_M_C, NULL, 0); break;
            case 1: count = exover_report(c, FAULTY_M_A, 0, EXOVER_FAILED, -1, NULL, 0); break;
            case 2: count = exover_observe(c, FAULTY_POSTER_P, (exover_value){.integer = 1}); break;
            case 3: count = exover_abort(c, FAULTY_M_A, 0); break;
            default: count = exover_abort_waiting(c, FAULTY_M_C);
            }
            printf("%d", has(count, EXOVER_REJECT, FAULTY_M_B, EXOVER_FAULTY));
        }
    printf("\n");
}

static int launches(const exover_action *actions, size_t count)
{
    int found = 0;
    for (size_t i = 0; i < count; i++)
        found += exover_holds(&actions[i]) && actions[i].kind == EXOVER_LAUNCH;
    return found;
}

/* Every bit of every place of the answers to a denial, and of their number, as told and as remembered: launches; answers
 * that were not found to have changed; and launches that stand behind the answers to a report. */
static void words(void)
{
    const size_t bytes = sizeof(exover_action) * FAULTY_ROOM;
    int launched = 0, missed = 0;
    for (size_t bit = 0; bit < 8 * bytes; bit++) {
        start();
        size_t count = exover_ask(&r2c.generic, FAULTY_M_B, NULL, 0);
        ((unsigned char *)r2c.generic.actions)[bit / 8] ^= (unsigned char)(1u << bit % 8);
        missed += bit < 8 * sizeof(exover_action) && exover_holds(&r2c.generic.actions[0]);
        launched += launches(r2c.generic.actions, FAULTY_ROOM);
        count = exover_verify(&r2c.generic, count);
        launched += launches(r2c.generic.actions, count);
        missed += bit < 8 * sizeof(exover_action) && exover_fault(&r2c.generic) != EXOVER_FAULT_ANSWERS;
        missed += count == 0;
    }
    for (int bit = 0; bit < 31; bit++)
        for (int remembered = 0; remembered < 2; remembered++) {
            start();
            size_t count = exover_ask(&r2c.generic, FAULTY_M_B, NULL, 0);
            r2c.generic.count ^= remembered ? (exover_int)1 << bit : 0;
            count = exover_verify(&r2c.generic, remembered ? count : count ^ (size_t)1 << bit);
            launched += launches(r2c.generic.actions, count);
            missed += exover_fault(&r2c.generic) != EXOVER_FAULT_ANSWERS || count == 0 || count > FAULTY_ROOM;
        }
    start();
    (void)exover_abort_waiting(&r2c.generic, FAULTY_M_B);
    (void)exover_ask(&r2c.generic, FAULTY_M_C, NULL, 0);
    size_t count = exover_report(&r2c.generic, FAULTY_M_A, 0, EXOVER_OK, -1, NULL, 0);
    printf("%d %d %d\n", launched, missed, (int)count + launches(r2c.generic.actions, FAULTY_ROOM));
}

static bool is(exover_view view, exover_phase phase, uint32_t since)
{
    return view.phase == phase && view.since == since;
}

/* What slots and places hold, since which step; and of a cell that has changed nothing, which is a fault. */
static void views(void)
{
    exover *c = &r2c.generic;
    (void)faulty_start_stopped(&r2c);
    printf("%d", is(faulty_slot_m_a(&r2c), EXOVER_IDLE, 0) && is(faulty_place_m_a(&r2c), EXOVER_IDLE, 0));
    (void)faulty_ask_m_a(&r2c, 3, 0.5, NULL);
    (void)exover_ask(c, 77, NULL, 0);
    (void)faulty_ask_m_b(&r2c, NULL);
    printf("%d", is(faulty_slot_m_a(&r2c), EXOVER_RUNNING, 1) && exover_step(c) == 3);
    printf("%d", is(faulty_place_m_b(&r2c), EXOVER_WAITING, 3) && is(faulty_slot_m_b(&r2c), EXOVER_IDLE, 0));
    (void)faulty_abort_m_a(&r2c, NULL);
    (void)faulty_ask_m_c(&r2c, NULL);
    printf("%d", is(faulty_slot_m_a(&r2c), EXOVER_STOPPING, 4) && is(faulty_slot_m_c(&r2c), EXOVER_RUNNING, 5));
    (void)faulty_report_m_a_interrupted(&r2c, NULL);
    printf("%d", is(faulty_slot_m_a(&r2c), EXOVER_IDLE, 6) && is(faulty_slot_m_b(&r2c), EXOVER_RUNNING, 6)
                     && is(faulty_place_m_b(&r2c), EXOVER_IDLE, 6));
    printf("%d", exover_slot(c, 0, 1).phase == EXOVER_UNKNOWN && exover_slot(c, 77, 0).phase == EXOVER_UNKNOWN
                     && exover_place(c, -1).phase == EXOVER_UNKNOWN && exover_fault(c) == EXOVER_READY);
    const size_t cells = (size_t)((unsigned char *)c->actions - (unsigned char *)c->cells) / sizeof(exover_cell);
    for (size_t i = 0; i < cells; i++)
        c->cells[i].now ^= 1;
    printf("%d\n", faulty_slot_m_a(&r2c).phase == EXOVER_UNKNOWN && exover_fault(c) == EXOVER_FAULT_STATE);
}

/* Scrubbed in idle time: every bit of tables and cells is found within the steps that are promised, without any event;
 * what waits is told by the next answer; nothing else has happened. */
static void scrub(void)
{
    static exover_word words[1 << 14];
    static exover_tables tables;
    exover *c = &r2c.generic;
    const size_t cells = (size_t)((unsigned char *)c->actions - (unsigned char *)c->cells);
    const size_t size = faulty_tables.word_count * sizeof(exover_word);
    int missed = 0, untold = 0, wrong = 0;
    for (size_t bit = 0; bit < 8 * (size + cells); bit += 3) {
        memcpy(&tables, &faulty_tables, sizeof tables);
        memcpy(words, faulty_tables.words, size);
        tables.words = words;
        wrong += exover_load_stopped(c, &tables, r2c.memory, sizeof r2c.memory) != EXOVER_READY;
        (void)faulty_ask_m_a(&r2c, 3, 0.5, NULL);
        (void)faulty_ask_m_b(&r2c, NULL);
        wrong += exover_scrub(c, 4 * FAULTY_SCRUB_STEPS) != EXOVER_READY || exover_scrub(c, 1) != EXOVER_READY;
        unsigned char *bytes = bit < 8 * size ? (unsigned char *)words : (unsigned char *)c->cells;
        const size_t at = bit < 8 * size ? bit : bit - 8 * size;
        bytes[at / 8] ^= (unsigned char)(1u << at % 8);
        missed += exover_scrub(c, 4 * FAULTY_SCRUB_STEPS) == EXOVER_READY;
        untold += !has(exover_ask(c, FAULTY_M_C, NULL, 0), EXOVER_REJECT, FAULTY_M_B, EXOVER_FAULTY);
    }
    printf("%d %d %d\n", wrong, missed, untold);
}

/* The places behind the answers of a cycle hold no launch, whatever stood there. */
static void cycle(void)
{
    exover_action said[3 * FAULTY_ROOM];
    const faulty_event both[] = {{.kind = FAULTY_EVENT_ASK_M_C}, {.kind = FAULTY_EVENT_REPORT_M_C_OK}};
    size_t count;
    (void)faulty_start_stopped(&r2c);
    (void)faulty_cycle(&r2c, both, 2, said, 3 * FAULTY_ROOM, &count);
    int first = launches(said, 3 * FAULTY_ROOM);
    (void)faulty_cycle(&r2c, both, 0, said, 3 * FAULTY_ROOM, &count);
    printf("%d %d\n", first, launches(said, 3 * FAULTY_ROOM));
}

int main(int argc, char **argv)
{
    const char *mode = argc > 1 ? argv[1] : "";
    start();
    if (strcmp(mode, "arguments") == 0)
        arguments();
    else if (strcmp(mode, "answers") == 0)
        answers();
    else if (strcmp(mode, "words") == 0)
        words();
    else if (strcmp(mode, "views") == 0)
        views();
    else if (strcmp(mode, "scrub") == 0)
        scrub();
    else if (strcmp(mode, "cycle") == 0)
        cycle();
    else
        told();
    return 0;
}
