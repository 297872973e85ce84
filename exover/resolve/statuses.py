"""The conditions of rules about activity; their parts are shared objects, since a large mutex has many pairs."""

from functools import lru_cache

from exover.model.expression import And, Status


@lru_cache(maxsize=4096)
def active(request: str) -> Status:
    """Return `active(request)`."""
    return Status("active", request)


def together(first: str, second: str) -> And:
    """Return `active(first) and active(second)`."""
    return And((active(first), active(second)))
