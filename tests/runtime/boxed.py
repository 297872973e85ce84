"""A small spec with requests, results, statuses, posters and a resource, of a checker that is recorded and proved."""

SPEC = """
spec boxed;
poster battery: int in 0 .. 100 = 100 else 0;
poster height: real = 0;
module nd { request goto(x: real in 0 .. 9, slow: bool) returns (left: int in 0 .. 5) fails (stuck) instances 2;
            request stop(); }
resource fuel: 10 consumable;
enum mode { calm, wild }
module arm { request move(mode: mode) { fail low: when battery < 15; } }
mutex drive: nd.stop over nd.goto;
"""
