"""What an audit holds of each request: the slots of the tables, and which recorded instance runs in which."""

from exover.audit.trail import AuditAnswer
from exover.dataclass import dataclass
from exover.model.event import Args

REFUSED, UNDECIDED = -2, -3
"""Stand in `slot_of` for an instance whose launch was refused, or is undecided."""


@dataclass(slots=True)
class HeldSlot:
    """An active slot of the tables, launched in event number `since`; `owner`: the recorded instance in it."""

    args: Args
    since: int
    pending: bool
    """Whether the tables have started it in answer to an event of the audit's own."""
    stopping: bool = False
    owner: int | None = None

    def withheld(self, event: int) -> bool:
        """Return whether the robot has not run what the tables launched in this event, or in one of the audit's own."""
        return self.owner is None and (self.pending or self.since == event)


@dataclass(slots=True)
class KnownRequest:
    """The state of the audit for one request.

    `slots`: by slot of the tables, None if idle; `slot_of`: by recorded instance, its slot, `REFUSED`, `UNDECIDED`, or
    None if it does not run. `asked`, `held`, `denied`: the number of the event in which it was last asked, or by the
    tables let wait or rejected; `waited`: that in which the robot last let it wait; `denials`: how often it was
    rejected in the event `denied`, but for those that the robot has also done.
    """

    slots: list[HeldSlot | None]
    slot_of: list[int | None]
    asked: int = 0
    held: int = 0
    waited: int = 0
    denied: int = 0
    denials: int = 0
    answer: AuditAnswer = "none"
    rule: str | None = None
    waits_for: str | None = None
    open: bool = False
    """Whether the last ask was answered `reject` or `invalid`, and no deed has taken that up."""
    wanted: bool = False
    """Whether a launch of it was withheld at the end of the last told event."""

    def deny(self, event: int) -> None:
        """Note that the tables have rejected it in an event."""
        self.denials = 1 + (self.denials if self.denied == event else 0)
        self.denied = event

    def was_denied(self, event: int) -> bool:
        """Return whether the tables have rejected it once more in an event than the robot has, which does it now."""
        if self.denied != event or not self.denials:
            return False
        self.denials -= 1
        return True

    def meant(self, instance: int) -> int | None:
        """Return the slot of an instance, or what stands for it; if it does not run, a slot without owner, or None.

        A slot without owner is that of the same number if it can be, else the first.
        """
        slot = self.slot_of[instance]
        if slot is not None:
            return slot
        free = [number for number, each in enumerate(self.slots) if each and each.owner is None]
        return instance if instance in free else free[0] if free else None

    def claim(self, instance: int, args: Args | None) -> bool:
        """Let an instance own the first slot without owner that has these arguments; return whether there is one."""
        for number, slot in enumerate(self.slots):
            if slot and slot.owner is None and (args is None or slot.args == args):
                slot.owner = instance
                self.slot_of[instance] = number
                return True
        return False
