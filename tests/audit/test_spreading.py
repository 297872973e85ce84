"""Missions over processes and over a cluster: the same results whoever audits what, also if a process dies."""

import os
import signal
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from multiprocessing import active_children
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from exover.audit import spread
from exover.audit.auditor import Job, MissionAuditor
from exover.audit.result import MissionResult
from exover.audit.spread import DIED, ClusterUnavailable, audit_all, audit_on_cluster
from tests.audit.missions import CRANE, FREE, LOOSE, built, told, write
from tests.support.command import Run

if TYPE_CHECKING:
    from exover.audit.spread import Paths

JOB = Job(*built(CRANE))
"""The tables are walked: nothing is to be compiled."""


def silent(name: str) -> None:
    """Hear of a mission that is done."""


def missions(folder: Path, count: int = 5) -> "Paths":
    found = [write(folder, f"m{k}.jsonl", told((LOOSE, FREE)[k % 2], k, 30 + 20 * k)) for k in range(count)]
    return [(str(path), path.name) for path in found]


def shown(found: list[MissionResult]) -> list[str]:
    return [str(each) for each in found]


def test_any_number_of_jobs_says_the_same(tmp_path: Path) -> None:
    paths = [*missions(tmp_path), (str(tmp_path / "missing.jsonl"), "missing.jsonl")]
    heard: list[str] = []
    alone = audit_all(JOB, paths, 1, heard.append)
    assert heard == [name for _, name in paths]
    assert [bool(each.divergences) for each in alone] == [True] * 5 + [False]
    assert shown(alone) == shown(audit_all(JOB, paths, 3, silent))


def test_a_process_that_dies_once_is_made_up_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    paths = missions(tmp_path)
    expected = shown(audit_all(JOB, paths, 1, silent))
    _dying(monkeypatch, "m2.jsonl", tmp_path / "once")
    assert shown(audit_all(JOB, paths, 2, silent)) == expected
    assert (tmp_path / "once").exists()


def test_a_process_that_dies_for_good_costs_its_mission_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    paths = missions(tmp_path)
    expected = audit_all(JOB, paths, 1, silent)
    _dying(monkeypatch, "m2.jsonl", None)
    found = audit_all(JOB, paths, 2, silent)
    assert found[2] == MissionResult("m2.jsonl", error=DIED, died=True)
    assert shown([*found[:2], *found[3:]]) == shown([*expected[:2], *expected[3:]])


def _dying(monkeypatch: pytest.MonkeyPatch, name: str, once: Path | None) -> None:
    """Let the process die that audits this mission, only once if a file can be left; it is forked after that."""
    audit = MissionAuditor.audit

    def dies(self: MissionAuditor, path: str, called: str, number: int = 0) -> MissionResult:
        if called == name and (once is None or not once.exists()):
            if once is not None:
                once.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return audit(self, path, called, number)

    monkeypatch.setattr(MissionAuditor, "audit", dies)


def test_what_ends_the_command_ends_its_processes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    audit, ended = MissionAuditor.audit, tmp_path / "ended"

    def takes_long(self: MissionAuditor, path: str, called: str, number: int = 0) -> MissionResult:
        if called == "m1.jsonl":
            time.sleep(3)
            ended.touch()
        return audit(self, path, called, number)

    def end(_: str) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(MissionAuditor, "audit", takes_long)
    with pytest.raises(KeyboardInterrupt):
        audit_all(JOB, missions(tmp_path, 2), 2, end)
    assert not ended.exists()
    assert not active_children()


# ---- a cluster ----


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    distributed = pytest.importorskip("distributed", reason="dask.distributed is not installed (extra exover[cluster])")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0", silence_logs="CRITICAL"
    ) as made:
        yield made


def test_a_worker_that_is_killed_in_the_middle(tmp_path: Path, cluster: Any) -> None:
    """The last mission is a pipe: who opens it reads until the test has written, so its worker is killed at work."""
    import psutil  # it comes with distributed

    paths = missions(tmp_path, 3)
    expected = shown(audit_all(JOB, paths, 1, silent))
    pipe = tmp_path / "pipe.jsonl"
    os.mkfifo(pipe)
    others = threading.Event()

    def heard(name: str) -> None:
        if name == "m1.jsonl":
            others.set()

    with ThreadPoolExecutor(1) as pool:
        spread_out = [*paths[:2], (str(pipe), "m2.jsonl")]
        found = pool.submit(audit_on_cluster, JOB, spread_out, cluster.scheduler_address, heard)
        first = os.open(pipe, os.O_WRONLY)  # once it is open, a worker has begun to read
        assert others.wait(60)
        (busy,) = [each for each in cluster.scheduler.workers.values() if each.processing]
        (nanny,) = [each for each in cluster.workers.values() if each.worker_address == busy.address]
        process = psutil.Process(nanny.pid)
        process.kill()
        process.wait(60)
        second = os.open(pipe, os.O_WRONLY)  # once it is open, another worker has begun to read
        os.close(first)
        with os.fdopen(second, "wb") as file:
            file.write(Path(paths[2][0]).read_bytes())
        assert shown(found.result(60)) == expected


def test_rows_come_with_the_results(tmp_path: Path, cluster: Any) -> None:
    pytest.importorskip("pyarrow")
    from dataclasses import replace

    (mission,) = missions(tmp_path, 1)
    (found,) = audit_on_cluster(replace(JOB, folder=str(tmp_path)), [mission], cluster.scheduler_address, silent)
    assert isinstance(found.table, bytes) and found.table[:4] == b"PAR1"


def test_the_command_says_the_same_over_a_cluster(tmp_path: Path, cluster: Any) -> None:
    run = Run(tmp_path)
    (tmp_path / "crane.exo").write_text(CRANE, encoding="utf-8")
    words = [
        "audit",
        "crane.exo",
        *(path for path, _ in missions(tmp_path, 3)),
        "--engine",
        "tables",
        "--format",
        "json",
    ]
    alone, spread_out = run(*words, "--jobs", 1), run(*words, "--cluster", cluster.scheduler_address)
    assert alone.stdout and (alone.returncode, alone.stdout) == (spread_out.returncode, spread_out.stdout)


def test_a_cluster_that_is_not_there() -> None:
    pytest.importorskip("distributed")
    with pytest.raises(ClusterUnavailable, match=r"cannot reach the cluster at tcp://127\.0\.0\.1:9"):
        audit_on_cluster(JOB, [("m", "m")], "tcp://127.0.0.1:9", silent, patience=0.2)


def test_a_cluster_without_the_package(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ClusterUnavailable, match=r"pip install 'exover\[cluster\]'"):
        spread.audit_on_cluster(JOB, [("m", "m")], "tcp://127.0.0.1:9", silent)
