#ifndef TASK_H
#define TASK_H

#ifndef FREERTOS_H
#error "FreeRTOS.h comes first"
#endif

#define tskIDLE_PRIORITY ((UBaseType_t)0U)
typedef struct tskTaskControlBlock *TaskHandle_t;
typedef void (*TaskFunction_t)(void *arg);
TaskHandle_t xTaskCreateStatic(TaskFunction_t pxTaskCode, const char *const pcName,
                               const configSTACK_DEPTH_TYPE uxStackDepth, void *const pvParameters,
                               UBaseType_t uxPriority, StackType_t *const puxStackBuffer,
                               StaticTask_t *const pxTaskBuffer);

#endif
