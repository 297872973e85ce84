"""Launch rules of which each, but the first, needs a pass of its own in one step."""


def chain(length: int) -> str:
    """Return requests `m.r0` to that of this number, and rules by which each launches the next, the last rule first."""
    requests = " ".join(f"request r{n}();" for n in range(length + 1))
    launches = " ".join(f"launch l{n}: m.r{n}() when active(m.r{n - 1});" for n in range(length, 0, -1))
    return f"module m {{ {requests} }} {launches}"


LINKED = " ".join(
    f"assume always (active(m.r{n}) implies active(m.r{other}));"
    for n, other in [(0, 4), (1, 4), (2, 4), (3, 4), (4, 0)]
)
"""What is true of the end of a step that asks the first of a chain of four, and of no moment within it."""
