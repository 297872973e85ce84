/* Zephyr as far as docs/integration.md uses it, over POSIX threads: a tick is a millisecond. */
#include <zephyr/kernel.h>

#include "host.h"
#include "queue.inc"

int checker_tell(const cart_event *event, k_timeout_t patience);
extern const struct stub_thread _k_thread_data_checker;

static struct stub_queue only = {.lock = PTHREAD_MUTEX_INITIALIZER, .changed = PTHREAD_COND_INITIALIZER};

static void take(const struct k_msgq *msgq)
{
    pthread_mutex_lock(&only.lock);
    only.places = msgq->buffer;
    only.size = msgq->size;
    only.most = msgq->most;
    pthread_mutex_unlock(&only.lock);
}

int k_msgq_put(struct k_msgq *msgq, const void *data, k_timeout_t timeout)
{
    take(msgq);
    return stub_move(&only, data, NULL, (long)timeout.ticks) ? 0 : -EAGAIN;
}

int k_msgq_get(struct k_msgq *msgq, void *data, k_timeout_t timeout)
{
    take(msgq);
    return stub_move(&only, NULL, data, (long)timeout.ticks) ? 0 : -EAGAIN;
}

static void *thread(void *unused)
{
    const struct stub_thread *made = &_k_thread_data_checker;
    (void)unused;
    made->entry(made->p1, made->p2, made->p3);
    return NULL;
}

bool begin(void)
{
    static pthread_t started;
    return pthread_create(&started, NULL, thread, NULL) == 0;
}

bool tell(cart_event event)
{
    return checker_tell(&event, K_FOREVER) == 0;
}

bool tell_from_interrupt(cart_event event)
{
    return checker_tell(&event, K_NO_WAIT) == 0;
}
