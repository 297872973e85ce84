"""Berkeley ABC as a process: what it is asked, and which of its claims are confirmed."""
