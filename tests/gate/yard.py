"""A robot of ROS 2 in a yard, its binding, and its interfaces."""

from pathlib import Path

SPEC = """spec yard;
module base {
    poster battery: real in 0 .. 1 = 1 else 0;
    request drive(x: real in -10 .. 10) returns (distance: real in 0 .. 100) fails (blocked) {
        interrupts self;
        check charged: battery > 0.1 because "the battery is empty";
    }
    request halt() { interrupts base.drive; }
}
module arm {
    request reach(side: {left, right}) {
        wait until not active(base.drive) because "reaching needs a base that stands";
    }
}
"""
BIND = """[gate]
spec = "yard"
wait = 30
stop = 2

[watch.battery]
topic = "/battery"
type = "yard_msgs/msg/Battery"
stale = 60

[poster."base.battery"]
watch = "battery"
field = "level"
scale = 0.01

[request."base.drive"]
action = "/drive"
inner = "/gated/drive"
type = "yard_msgs/action/Drive"

[request."base.drive".report]
status = "error_code"
ok = [0]
fails = { blocked = [7] }
results = { distance = "metres" }

[request."base.halt"]
service = "/halt"
inner = "/gated/halt"
type = "yard_msgs/srv/Halt"
start = "idle"
refused = { success = false, message = "{reason}" }

[request."base.halt".report]
status = "success"
ok = [true]
failed = [false]

[request."arm.reach"]
action = "/reach"
inner = "/gated/reach"
type = "yard_msgs/action/Reach"
arguments = { side = { field = "side", values = { l = "left", r = "right" } } }
"""
INTERFACES = Path(__file__).parent / "interfaces"
