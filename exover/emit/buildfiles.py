"""Files for build systems beside the emitted C: a CMake target and a pkg-config module for each spec in the folder."""

from collections.abc import Sequence

from exover import __version__

CMAKE = "CMakeLists.txt"
MARK = "# Written by `exover emit`"
"""The first text of a CMakeLists.txt that exover has written and may replace."""

PROJECT = """@MARK@: what a host links is exover::NAME, for each spec in this folder.
cmake_minimum_required(VERSION 3.15)
project(exover_@FIRST@ VERSION @VERSION@ LANGUAGES C)
include(GNUInstallDirs)

foreach(name @NAMES@)
    set(target exover_${name})
    set(headers ${CMAKE_INSTALL_INCLUDEDIR}/${target})
    add_library(${target} STATIC exover.c exover_box.c ${name}_tables.c ${name}_api.c ${name}_names.c)
    add_library(exover::${name} ALIAS ${target})
    set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
    target_compile_features(${target} PUBLIC c_std_99)
    target_include_directories(${target} PUBLIC
        $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}> $<INSTALL_INTERFACE:${headers}>)

    # Installed, it is found by find_package(exover_NAME) and by pkg-config. A host that has this folder in its own
    # project decides for itself what it installs.
    if(CMAKE_SOURCE_DIR STREQUAL CMAKE_CURRENT_SOURCE_DIR)
        install(TARGETS ${target} EXPORT ${target} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
        install(FILES exover.h exover_box.h exover_config.h ${name}_api.h ${name}_names.h ${name}_tables.h
            DESTINATION ${headers})
        install(EXPORT ${target} NAMESPACE exover:: FILE ${target}-config.cmake
            DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/${target})
        file(READ ${target}.pc module)
        string(REPLACE "includedir=\\${pcfiledir}" "includedir=${CMAKE_INSTALL_PREFIX}/${headers}" module "${module}")
        string(REPLACE "libdir=\\${pcfiledir}" "libdir=${CMAKE_INSTALL_FULL_LIBDIR}" module "${module}")
        file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/${target}.pc "${module}")
        install(FILES ${CMAKE_CURRENT_BINARY_DIR}/${target}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
    endif()
endforeach()
"""
MODULE = """@MARK@: the headers beside this file, and libexover_@NAME@.a, made of the sources beside it.
includedir=${pcfiledir}
libdir=${pcfiledir}

Name: exover_@NAME@
Description: The checker of the spec @NAME@
Version: @VERSION@
Cflags: -I${includedir}
Libs: -L${libdir} -lexover_@NAME@
"""


def cmake(names: Sequence[str]) -> str:
    """Return CMakeLists.txt, with a target `exover::NAME` for each spec, to be included by a host or installed."""
    return _common(PROJECT).replace("@FIRST@", names[0]).replace("@NAMES@", " ".join(names))


def pkgconfig(name: str) -> str:
    """Return the pkg-config module of a spec for the folder in which it is; CMake replaces the folders on install."""
    return _common(MODULE).replace("@NAME@", name)


def _common(text: str) -> str:
    return text.replace("@MARK@", MARK).replace("@VERSION@", __version__)
