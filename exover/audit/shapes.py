"""What messages of a bag need to have to be read, whatever their types are called or said to be."""

from collections.abc import Mapping
from typing import Any

Shape = Mapping[str, Any] | list[Any] | type
"""Fields by name, the elements of a list, or a type."""
GOAL = {"uuid": [int]}
STATUS_SHAPE = {"status_list": [{"goal_info": {"goal_id": GOAL}, "status": int}]}
CALL_SHAPE = {
    "info": {"event_type": int, "client_gid": [int], "sequence_number": int},
    "request": [object],
    "response": [object],
}
GOAL_SHAPE = CALL_SHAPE | {"request": [{"goal_id": GOAL, "goal": object}], "response": [{"accepted": bool}]}
RESULT_SHAPE = CALL_SHAPE | {"request": [{"goal_id": GOAL}], "response": [{"status": int, "result": object}]}
"""What is read of action_msgs/msg/GoalStatusArray and of the events of services; goal, result and so on as bound."""


def lacking(found: Any, shape: Shape, place: str = "") -> str | None:
    """Return what a part of a message, at `place`, lacks of a shape; None if it has all of it."""
    match shape:
        case Mapping():
            if not isinstance(found, Mapping):
                return f"`{place}` is no message"
            for name, each in shape.items():
                inside = f"{place}.{name}" if place else name
                if name not in found:
                    return f"there is no field `{inside}`"
                if lack := lacking(found[name], each, inside):
                    return lack
            return None
        case list():
            if not isinstance(found, list):
                return f"`{place}` is no list"
            return next(filter(None, (lacking(each, shape[0], place) for each in found)), None)
        case _:
            return None if isinstance(found, shape) else f"`{place}` is no {shape.__name__}"
