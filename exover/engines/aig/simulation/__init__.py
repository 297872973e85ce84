"""Many runs of a circuit side by side: what they reach, guided by coverage; runs made shorter."""
