"""The checker of certificates (docs/certificates.md): small, and sharing no code with what it checks.

It imports nothing else of exover. What it believes is written in docs/runtime.md (the bytes), in docs/certificates.md
(the state and the step) and in Z3.
"""
