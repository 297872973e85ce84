"""The checks of the closed loop: what they ask, who answers when, and why what does not hold does not."""
