/* The test of a host on stubs of an RTOS: it drives, an interrupt says that the battery is low, then the checker is broken. */
#include "host.h"

#include <pthread.h>
#include <semaphore.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static sem_t obeyed, stopped;
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static unsigned fed;
static cart_checker *known;

static unsigned meals(void)
{
    pthread_mutex_lock(&lock);
    const unsigned found = fed;
    pthread_mutex_unlock(&lock);
    return found;
}

void watchdog_feed(void)
{
    pthread_mutex_lock(&lock);
    fed++;
    pthread_mutex_unlock(&lock);
}

void obey(cart_checker *checker, const exover_action *action)
{
    cart_base_drive_args args;
    known = checker;
    if (!exover_holds(action))
        exit(2);
    if (action->kind == EXOVER_LAUNCH && cart_args_base_drive(checker, &args))
        printf("launch %d at %g\n", (int)action->request, args.speed);
    else if (action->kind == EXOVER_KILL)
        printf("kill %d\n", (int)action->request);
    if (action->kind == EXOVER_KILL)
        checker->generic.cells[0].now ^= 1u; /* a bit changes: scrubbing will find it */
    sem_post(&obeyed);
}

void stop_everything(void)
{
    if (known != NULL)
        sem_post(&stopped);
    usleep(1000);
}

int main(void)
{
    sem_init(&obeyed, 0, 0);
    sem_init(&stopped, 0, 0);
    if (!begin() || !tell((cart_event){.kind = CART_EVENT_ASK_BASE_DRIVE, .of.ask_base_drive = {.speed = 0.5}}))
        return 1;
    sem_wait(&obeyed);
    const unsigned before = meals();
    while (meals() < before + 3)
        usleep(1000);
    printf("fed while idle\n");
    if (!tell_from_interrupt((cart_event){.kind = CART_EVENT_OBSERVE_BATTERY, .of.observe_battery = 12}))
        return 1;
    sem_wait(&obeyed);
    sem_wait(&stopped);
    const unsigned last = meals();
    usleep(50000);
    printf(meals() == last ? "denied, fed no more\n" : "still fed\n");
    fflush(stdout);
    _exit(0);
}
