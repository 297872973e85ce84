"""Audits missions in several processes, or on a cluster; results come in the order of the missions."""

import threading
from collections.abc import Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace
from multiprocessing import active_children, get_all_start_methods, get_context

from exover.audit.auditor import Job, MissionAuditor
from exover.audit.native import compile_library
from exover.audit.result import MissionResult
from exover.engines.compiler import NativeUnavailable
from exover.loop.claim import Progress
from exover.run.native import NativeFault

DIED = "the process that audited it died, and again when it was tried alone"
RETRIES = 2
Paths = Sequence[tuple[str, str]]
"""Missions: path and name of each."""


class ClusterUnavailable(Exception):
    """The cluster cannot be used, or `distributed` is not installed; the text says why."""


def audit_all(job: Job, missions: Paths, jobs: int, progress: Progress) -> list[MissionResult]:
    """Return the audits of missions, in their order, by at most `jobs` processes."""
    if jobs == 1 or len(missions) == 1:
        auditor = MissionAuditor(job)
        try:
            return [_told(auditor.audit(path, name, k), progress) for k, (path, name) in enumerate(missions)]
        finally:
            auditor.close()
    found: dict[int, MissionResult] = {}
    left = _pooled(job, missions, range(len(missions)), min(jobs, len(missions)), found, progress)
    for number in left:  # one by one, to find the missions whose process dies
        if _pooled(job, missions, [number], 1, found, progress):
            found[number] = MissionResult(missions[number][1], error=DIED, died=True)
    return [found[number] for number in range(len(missions))]


def _pooled(
    job: Job, missions: Paths, wanted: Sequence[int], jobs: int, found: dict[int, MissionResult], progress: Progress
) -> list[int]:
    """Audit the wanted missions in a pool into `found`; return the numbers of those left since a process died."""
    context = get_context("fork" if "fork" in get_all_start_methods() else "spawn")
    others = set(active_children())
    with ProcessPoolExecutor(jobs, context, _begin, (job,)) as pool:
        futures: dict[Future[MissionResult], int] = {}
        try:
            futures = {pool.submit(_audit, *missions[number], number): number for number in wanted}
            waiting = set(futures)
            while waiting:
                done, waiting = wait(waiting, return_when=FIRST_COMPLETED)
                for future in done:
                    found[futures[future]] = _told(future.result(), progress)
        except BrokenProcessPool:
            pass
        except BaseException:
            for process in set(active_children()) - others:
                process.kill()  # it would go on to the end of its mission, and a second signal would leave it behind
            raise
    for future, number in futures.items():
        if number not in found and future.done() and not future.cancelled() and future.exception() is None:
            found[number] = future.result()
    return [number for number in wanted if number not in found]


def _told(result: MissionResult, progress: Progress) -> MissionResult:
    progress(result.name)
    return result


_auditor: MissionAuditor | None = None


def _begin(job: Job) -> None:
    global _auditor  # noqa: PLW0603 - a process of the pool has one
    _auditor = MissionAuditor(job)


def _audit(path: str, name: str, number: int) -> MissionResult:
    assert _auditor is not None
    return _auditor.audit(path, name, number)


# ---- a cluster ----


def audit_on_cluster(
    job: Job, missions: Paths, address: str, progress: Progress, patience: float = 10
) -> list[MissionResult]:
    """Return the audits of missions on a cluster of dask.distributed, one mission a task; rows come with the results.

    Raises `ClusterUnavailable`, also if the cluster cannot be reached within `patience` seconds.
    """
    try:
        from distributed import Client, KilledWorker
        from distributed.comm.core import CommClosedError
    except ModuleNotFoundError as error:
        raise ClusterUnavailable("--cluster needs dask.distributed: pip install 'exover[cluster]'") from error
    try:
        client = Client(address, timeout=patience)
    except (OSError, ValueError, TimeoutError, CommClosedError) as error:
        raise ClusterUnavailable(f"cannot reach the cluster at {address}: {error}") from error
    sent = replace(job, library=None, folder="" if job.folder is not None else None)
    with client:
        (scattered,) = client.scatter([sent], broadcast=True)
        futures = [
            client.submit(_on_worker, scattered, job.library is not None, path, name, pure=False, retries=RETRIES)
            for path, name in missions
        ]
        found = []
        for future, (_, name) in zip(futures, missions, strict=True):
            try:
                found.append(_told(future.result(), progress))
            except NativeFault:
                raise
            except (ImportError, RuntimeError) as error:  # as with other packages there than here
                raise ClusterUnavailable(f"a worker of {address} cannot audit: {error}") from error
            except KilledWorker:
                found.append(MissionResult(name, error=DIED, died=True))
        return found


_LOCK = threading.Lock()
_LIBRARIES: dict[bytes, bytes | None] = {}
"""What a worker has compiled, by the digest of the model; None where it could not."""


def _on_worker(job: Job, native: bool, path: str, name: str) -> MissionResult:
    """Audit a mission in a thread of a worker, whose process compiles each checker once."""
    auditor = MissionAuditor(replace(job, library=_library(job) if native else None))
    try:
        return auditor.audit(path, name)
    finally:
        auditor.close()


def _library(job: Job) -> bytes | None:
    from exover.model.canonical import digest

    key = digest(job.model)
    with _LOCK:
        if key not in _LIBRARIES:
            try:
                _LIBRARIES[key] = compile_library(job.model, job.tables)
            except NativeUnavailable:
                _LIBRARIES[key] = None
        return _LIBRARIES[key]
