/* What docs/integration.md uses of FreeRTOS 10 and 11, with their types; with rtos.c. */
#ifndef FREERTOS_H
#define FREERTOS_H

#include <stddef.h>
#include <stdint.h>

typedef long BaseType_t;
typedef unsigned long UBaseType_t;
typedef uint32_t TickType_t;
typedef uint32_t StackType_t;
typedef struct xSTATIC_QUEUE { void *unused[9]; } StaticQueue_t;
typedef struct xSTATIC_TCB { void *unused[20]; } StaticTask_t;

#define configSTACK_DEPTH_TYPE uint32_t
#define pdFALSE ((BaseType_t)0)
#define pdTRUE ((BaseType_t)1)
#define pdPASS pdTRUE
#define pdFAIL pdFALSE
#define pdMS_TO_TICKS(ms) ((TickType_t)(ms))
#define portMAX_DELAY ((TickType_t)0xffffffffUL)
#define portYIELD_FROM_ISR(woken) ((void)(woken))

#endif
