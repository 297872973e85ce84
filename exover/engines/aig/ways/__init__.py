"""What is possible from every reachable state: words of events that lead there, and states without one."""
