/* What the hosts on stubs of an RTOS have in common: the modules of the cart, and what the test of them does. */
#ifndef HOST_H
#define HOST_H

#include "cart_api.h"
#include <stdbool.h>

/* Of each RTOS: start the owner of the checker, and tell it of an event, from a task and from an interrupt. */
bool begin(void);
bool tell(cart_event event);
bool tell_from_interrupt(cart_event event);

void obey(cart_checker *checker, const exover_action *action);
void stop_everything(void);
void watchdog_feed(void);

#endif
