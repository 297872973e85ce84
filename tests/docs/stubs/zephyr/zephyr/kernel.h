/* What docs/integration.md uses of Zephyr 3 and 4, with their types; with rtos.c. */
#ifndef ZEPHYR_KERNEL_H
#define ZEPHYR_KERNEL_H

#include <stddef.h>
#include <stdint.h>

typedef struct { int64_t ticks; } k_timeout_t;
#define K_NO_WAIT ((k_timeout_t){0})
#define K_MSEC(ms) ((k_timeout_t){ms})
#define K_FOREVER ((k_timeout_t){-1})
#define ARG_UNUSED(x) (void)(x)

struct k_msgq { char *buffer; size_t size; uint32_t most; };
#define K_MSGQ_DEFINE(q_name, q_msg_size, q_max_msgs, q_align) \
    static char __attribute__((aligned(q_align))) _k_fifo_buf_##q_name[(q_max_msgs) * (q_msg_size)]; \
    struct k_msgq q_name = {_k_fifo_buf_##q_name, q_msg_size, q_max_msgs}
int k_msgq_put(struct k_msgq *msgq, const void *data, k_timeout_t timeout);
int k_msgq_get(struct k_msgq *msgq, void *data, k_timeout_t timeout);

typedef void (*k_thread_entry_t)(void *p1, void *p2, void *p3);
struct stub_thread { k_thread_entry_t entry; void *p1, *p2, *p3; size_t stack; int prio; uint32_t options; int32_t delay; };
#define K_THREAD_DEFINE(name, stack_size, entry, p1, p2, p3, prio, options, delay) \
    const struct stub_thread _k_thread_data_##name = {entry, p1, p2, p3, stack_size, prio, options, delay}

#endif
