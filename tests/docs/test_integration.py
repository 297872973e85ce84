"""The hosts of docs/integration.md, run as they stand; those for an RTOS on stubs of its headers over POSIX threads."""

import subprocess
from pathlib import Path
from shutil import which

import pytest

from tests.docs.pages import ROOT, Block, blocks, play, run
from tests.runtime.compiling import COMPILERS, WARNINGS, compile_c

PAGE = ROOT / "docs" / "integration.md"
STUBS = Path(__file__).parent / "stubs"


def write(name: str, folder: Path) -> Path:
    """Write a named block of the page, and the checker that it is for."""
    for block in blocks(PAGE):
        if block.info in (name, "cart.exo"):
            (folder / block.info).write_text(block.text, encoding="utf-8")
    run(Block("sh", "", "exover emit cart.exo --target c --out cart"), folder)
    return folder / name


def test_the_hosts_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CARGO_INCREMENTAL", "0")
    monkeypatch.setenv("CARGO_PROFILE_DEV_DEBUG", "0")
    for _ in play(PAGE, tmp_path):
        pass


@pytest.mark.parametrize("rtos", ["freertos", "zephyr"])
def test_the_sketches_compile(rtos: str, tmp_path: Path) -> None:
    source = write(f"{rtos}.c", tmp_path)
    for compiler in COMPILERS:
        flags = [*WARNINGS, "-c", f"-I{tmp_path / 'cart'}", f"-I{STUBS / rtos}"]
        compile_c(compiler, flags, [source], tmp_path / "out.o")


@pytest.mark.parametrize("rtos", ["freertos", "zephyr"])
def test_the_sketches_run(rtos: str, tmp_path: Path) -> None:
    """A task and an interrupt tell events; the owner obeys, feeds its watchdog, scrubs in between, on POSIX threads."""
    sources = [write(f"{rtos}.c", tmp_path), STUBS / rtos / "rtos.c", STUBS / "host.c"]
    sources += [tmp_path / "cart" / file for file in ("cart_api.c", "cart_tables.c", "exover.c")]
    flags = ["-std=c11", "-D_DEFAULT_SOURCE", "-Wall", "-Wextra", "-Werror", "-pthread", "-g", "-fsanitize=thread"]
    includes = [f"-I{tmp_path / 'cart'}", f"-I{STUBS / rtos}", f"-I{STUBS}"]
    compile_c(COMPILERS[0], [*flags, *includes], sources, tmp_path / "host")
    done = subprocess.run([tmp_path / "host"], capture_output=True, text=True, check=False, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines() == ["launch 0 at 0.5", "fed while idle", "kill 0", "denied, fed no more"]


@pytest.mark.skipif(which("cmake") is None, reason="no cmake")
def test_the_cmake_project_builds_the_host_with_threads(tmp_path: Path) -> None:
    write("threads.c", tmp_path)
    write("CMakeLists.txt", tmp_path)
    commands = "cmake -S . -B build > log\ncmake --build build >> log\nbuild/robot"
    assert run(Block("sh", "", commands), tmp_path).splitlines()[0] == "drive at 0.5"


@pytest.mark.parametrize("name", ["threads.c", "sources.c"])
def test_the_hosts_are_free_of_races_and_undefined_behaviour(name: str, tmp_path: Path) -> None:
    source = write(name, tmp_path)
    sources = [source, *(tmp_path / "cart" / file for file in ("cart_api.c", "cart_tables.c", "exover.c"))]
    flags = ["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-pthread", "-g", f"-I{tmp_path / 'cart'}"]
    for sanitizer in ("thread", "address,undefined"):
        compile_c(COMPILERS[0], [*flags, f"-fsanitize={sanitizer}"], sources, tmp_path / "host")
        done = subprocess.run([tmp_path / "host"], capture_output=True, text=True, check=False, timeout=60)
        assert (done.returncode, done.stderr) == (0, "")
