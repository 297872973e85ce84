/* What each event costs: reads what runner.c reads, prints tests, answers and passes. For tests: hosted, EXOVER_DEBUG. */
#define main runner_main
#include "runner.c"
#undef main

int main(void)
{
    event e = {0, {0}, 0, NULL};
    start();
    while (read_event(&e)) {
        (void)run(&e);
        exover_spent spent = exover_cost(&checker);
        printf("%u %u %u\n", (unsigned)spent.tests, (unsigned)spent.actions, (unsigned)spent.passes);
    }
    free(e.values);
    return exover_fault(&checker) != EXOVER_READY;
}
