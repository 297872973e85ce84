/* FreeRTOS as far as docs/integration.md uses it, over POSIX threads: a tick is a millisecond. */
#include "FreeRTOS.h"
#include "queue.h"
#include "task.h"

#include "host.h"
#include "queue.inc"

BaseType_t checker_tell(const cart_event *event, TickType_t patience);
BaseType_t checker_tell_from_isr(const cart_event *event);
BaseType_t checker_start(void);

static struct stub_queue only = {.lock = PTHREAD_MUTEX_INITIALIZER, .changed = PTHREAD_COND_INITIALIZER};

static long patience_of(TickType_t ticks)
{
    return ticks == portMAX_DELAY ? -1 : (long)ticks;
}

QueueHandle_t xQueueCreateStatic(UBaseType_t length, UBaseType_t size, uint8_t *storage, StaticQueue_t *buffer)
{
    (void)buffer;
    only.places = (char *)storage;
    only.size = size;
    only.most = length;
    return (QueueHandle_t)&only;
}

BaseType_t xQueueSend(QueueHandle_t queue, const void *item, TickType_t ticks)
{
    return stub_move((struct stub_queue *)queue, item, NULL, patience_of(ticks)) ? pdPASS : pdFAIL;
}

BaseType_t xQueueSendFromISR(QueueHandle_t queue, const void *item, BaseType_t *woken)
{
    *woken = pdTRUE;
    return xQueueSend(queue, item, 0);
}

BaseType_t xQueueReceive(QueueHandle_t queue, void *buffer, TickType_t ticks)
{
    return stub_move((struct stub_queue *)queue, NULL, buffer, patience_of(ticks)) ? pdPASS : pdFAIL;
}

static TaskFunction_t entry;

static void *task(void *parameters)
{
    entry(parameters);
    return NULL;
}

TaskHandle_t xTaskCreateStatic(TaskFunction_t code, const char *const name, const configSTACK_DEPTH_TYPE depth,
                               void *const parameters, UBaseType_t priority, StackType_t *const stack,
                               StaticTask_t *const buffer)
{
    static pthread_t thread;
    (void)name, (void)depth, (void)priority, (void)stack;
    entry = code;
    return pthread_create(&thread, NULL, task, parameters) == 0 ? (TaskHandle_t)(void *)buffer : NULL;
}

bool begin(void)
{
    return checker_start() == pdPASS;
}

bool tell(cart_event event)
{
    return checker_tell(&event, portMAX_DELAY) == pdPASS;
}

bool tell_from_interrupt(cart_event event)
{
    return checker_tell_from_isr(&event) == pdPASS;
}
