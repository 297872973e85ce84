"""The typed API in C: its types, its functions, and the call of the generic API by which each function is defined."""

from typing import assert_never

from exover.dataclass import dataclass
from exover.emit.events import EventCall, Field, FieldType, Statuses, function_of
from exover.emit.identifiers import Call, SpecIdentifiers
from exover.model.types import Enum

CHECKER = "CHECKER"
"""The macro for the first arguments of a generic call: the checker, after its black box if there is one."""
SCALARS = {"bool": "bool", "int32": "int32_t", "int64": "int64_t", "double": "double"}


@dataclass(frozen=True, slots=True)
class CApi:
    """Writes types and functions of a spec in C; `start`: their prefix."""

    known: SpecIdentifiers
    start: str

    def type(self, kind: FieldType) -> str:
        """Return the type of a field."""
        match kind:
            case Enum():
                return self.known.enums[kind].type
            case Statuses(request):
                return self.known.typed[request].statuses.type
            case _:
                return SCALARS[kind]

    def call(self, event: EventCall) -> Call:
        """Return the function that raises an event, and the enumerator of the event in a buffer."""
        return function_of(event, self.known)

    def signature(self, event: EventCall) -> str:
        """Return the head of the function that raises an event."""
        parameters = [f"{self.start}_checker *r2c", *(["int32_t slot"] if event.has_slot else [])]
        parameters += [f"{self.type(field.type)} {field.name}" for field in event.fields]
        return f"exover_status {self.call(event).function}({', '.join([*parameters, f'{self.start}_answer *answer'])})"

    def member(self, event: EventCall) -> str:
        """Return the member of the union that holds the values of an event: its function without the prefix."""
        return self.call(event).function.removeprefix(f"{self.start}_")

    def member_type(self, event: EventCall) -> str:
        """Return the type of that member: a struct for an ask or a report `ok`, else the type of the only field."""
        match event.does:
            case "ask":
                return self.known.typed[event.number].args
            case "ok":
                return self.known.typed[event.number].results
            case _:
                return self.type(event.fields[0].type)

    def members(self, event: EventCall, given: str) -> list[str]:
        """Return an expression for each value of an event; `given`: its member of the union."""
        whole = event.does in ("ask", "ok")
        return [f"{given}.{field.name}" if whole else given for field in event.fields]

    def generic(self, event: EventCall) -> str:
        """Return the call of the generic API; the array `values` holds those of an ask or a report `ok`."""
        slot, number = "slot" if event.has_slot else "0", event.number
        values = f"values, {len(event.fields)}" if event.fields else "NULL, 0"
        match event.does:
            case "ask":
                return f"exover_ask({CHECKER}, {self._request(number)}, {values})"
            case "ok":
                return f"exover_report({CHECKER}, {self._request(number)}, {slot}, EXOVER_OK, -1, {values})"
            case "failed":
                status = "(int32_t)status" if event.fields else "-1"
                return f"exover_report({CHECKER}, {self._request(number)}, {slot}, EXOVER_FAILED, {status}, NULL, 0)"
            case "interrupted":
                return f"exover_report({CHECKER}, {self._request(number)}, {slot}, EXOVER_INTERRUPTED, -1, NULL, 0)"
            case "abort":
                return f"exover_abort({CHECKER}, {self._request(number)}, {slot})"
            case "abort_waiting":
                return f"exover_abort_waiting({CHECKER}, {self._request(number)})"
            case "observe":
                value = f"(exover_value){initializer(event.fields[0])}"
                return f"exover_observe({CHECKER}, {self.known.posters[number][0]}, {value})"
            case "level":
                return f"exover_level({CHECKER}, {self.known.stocks[number][0]}, {event.fields[0].name})"
            case _:
                assert_never(event.does)

    def _request(self, number: int) -> str:
        return self.known.requests[number][0]


def initializer(field: Field) -> str:
    """Return the initializer of an `exover_value` from a parameter."""
    return f"{{{'.real' if field.type == 'double' else '.integer'} = {field.name}}}"
