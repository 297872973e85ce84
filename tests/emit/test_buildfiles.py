"""What build systems read: a host in a CMake project, an installed checker, pkg-config with and without CMake."""

import os
import subprocess
from pathlib import Path
from shutil import which

import pytest

from exover.emit.buildfiles import MARK
from tests.runtime.compiling import COMPILERS, WARNINGS, compile_c
from tests.support.command import Run

HOST = """
#include "NAME_api.h"
#include "NAME_names.h"
int main(void)
{
    static NAME_checker r2c;
    NAME_answer answer;
    return NAME_start(&r2c) != EXOVER_READY || NAME_ask_m_a(&r2c, &answer) != EXOVER_READY
        || answer.actions[0].kind != EXOVER_LAUNCH || NAME_request_names[0] == NULL;
}
"""
ABOVE = """
cmake_minimum_required(VERSION 3.15)
project(robot LANGUAGES C CXX)
set(CMAKE_CXX_STANDARD 17)
add_subdirectory(checkers)
foreach(name left right)
    add_executable(${name} ${name}.c)
    target_link_libraries(${name} PRIVATE exover::${name})
    add_executable(${name}_plus ${name}.cpp)
    target_link_libraries(${name}_plus PRIVATE exover::${name})
endforeach()
install(TARGETS left)
"""
FOUND = """
cmake_minimum_required(VERSION 3.15)
project(robot LANGUAGES C)
find_package(exover_left REQUIRED)
add_executable(left left.c)
target_link_libraries(left PRIVATE exover::left)
"""


def needs(*tools: str) -> pytest.MarkDecorator:
    missing = [tool for tool in tools if which(tool) is None]
    return pytest.mark.skipif(bool(missing), reason=f"no {', '.join(missing)}")


def call(folder: Path, *command: object, **variables: str) -> str:
    """Return what a program prints; the test fails with what it says unless it ends well."""
    words, environment = [str(word) for word in command], os.environ | variables
    done = subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, f"{' '.join(words)}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def emit(run: Run, folder: Path, name: str, out: str) -> None:
    (folder / f"{name}.exo").write_text(f"spec {name}; module m {{ request a(); request b(); }} mutex m.a, m.b;")
    assert run("emit", f"{name}.exo", "--target", "c", "--out", out, "--unchecked", cwd=folder).returncode == 0


@needs("cmake", "g++")
def test_hosts_in_c_and_cplusplus_link_two_checkers_of_one_folder(run: Run, tmp_path: Path) -> None:
    for name in ("right", "left"):
        emit(run, tmp_path, name, "checkers")
        for suffix in ("c", "cpp"):
            (tmp_path / f"{name}.{suffix}").write_text(HOST.replace("NAME", name))
    (tmp_path / "CMakeLists.txt").write_text(ABOVE)
    call(tmp_path, "cmake", "-S", ".", "-B", "build")
    call(tmp_path, "cmake", "--build", "build")
    for name in ("left", "right", "left_plus", "right_plus"):
        call(tmp_path, tmp_path / "build" / name)
    call(tmp_path, "cmake", "--install", "build", "--prefix", "installed")
    assert [path.name for path in (tmp_path / "installed").rglob("*") if path.is_file()] == ["left"]


@needs("cmake")
def test_what_is_installed_is_found_by_cmake_and_by_pkg_config(run: Run, tmp_path: Path) -> None:
    emit(run, tmp_path, "left", "checkers")
    prefix = tmp_path / "installed"
    call(tmp_path, "cmake", "-S", "checkers", "-B", "made", f"-DCMAKE_INSTALL_PREFIX={prefix}")
    call(tmp_path, "cmake", "--build", "made", "--target", "install")
    host = tmp_path / "host"
    host.mkdir()
    (host / "left.c").write_text(HOST.replace("NAME", "left"))
    (host / "CMakeLists.txt").write_text(FOUND)
    call(host, "cmake", "-S", ".", "-B", "build", f"-DCMAKE_PREFIX_PATH={prefix}")
    call(host, "cmake", "--build", "build")
    call(host, host / "build" / "left")
    if which("pkg-config"):
        (modules,) = prefix.rglob("pkgconfig")
        link_by_pkg_config(host, modules, "left")


def link_by_pkg_config(folder: Path, modules: Path, name: str) -> None:
    flags = call(folder, "pkg-config", "--cflags", "--libs", f"exover_{name}", PKG_CONFIG_PATH=str(modules)).split()
    assert len(flags) == 3
    out = folder / "by_pkg_config"
    compile_c(COMPILERS[0], WARNINGS, [folder / f"{name}.c", *map(Path, flags)], out)
    call(folder, out)


@needs("pkg-config", "ar")
def test_pkg_config_finds_what_is_built_by_hand(run: Run, tmp_path: Path) -> None:
    emit(run, tmp_path, "left", "checkers")
    folder = tmp_path / "checkers"
    sources = sorted(folder.glob("*.c"))
    call(folder, COMPILERS[0], "-c", *sources)
    call(folder, "ar", "rcs", "libexover_left.a", *sorted(folder.glob("*.o")))
    (tmp_path / "left.c").write_text(HOST.replace("NAME", "left"))
    link_by_pkg_config(tmp_path, folder, "left")


def test_the_cmake_project_of_the_host_is_left_alone(run: Run, tmp_path: Path) -> None:
    (tmp_path / "CMakeLists.txt").write_text(ABOVE)
    (tmp_path / "left.exo").write_text("spec left; module m { request a(); }")
    ended = run("emit", "left.exo", "--target", "c", "--out", ".", "--unchecked", cwd=tmp_path)
    assert ended.returncode == 0 and "./CMakeLists.txt" not in ended.stdout.splitlines()
    assert (tmp_path / "CMakeLists.txt").read_text() == ABOVE
    assert "CMakeLists.txt is not one of exover's and stays as it is" in ended.stderr


def test_its_own_is_written_anew(run: Run, tmp_path: Path) -> None:
    for name in ("left", "right"):
        emit(run, tmp_path, name, "checkers")
    text = (tmp_path / "checkers" / "CMakeLists.txt").read_text()
    assert text.startswith(MARK) and "foreach(name left right)" in text
