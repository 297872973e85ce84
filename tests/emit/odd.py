"""A spec whose names and texts are odd in C and in Rust."""

ODD = r"""
spec _x;
enum kind { int, void }
enum answer { a }
module a_b {
    request c(k: kind, int_: int in 0 .. 5, r2c: bool, _y: real, EOF: int in 0 .. 99999999999, linux: answer)
            fails (EOF, errno) {
        check k == int because "??/ ??= */ /* \"quoted\" \\ %s é 漢";
    }
    request C() instances 3;
    request D(x: bool) returns (y: {p, q}) instances 2;
}
module a { request b_c(); poster tables: bool = false; }
poster LONG_MAX: kind = int;
poster state: real = 0 else 1;
resource fuel: 10 consumable;
"""
