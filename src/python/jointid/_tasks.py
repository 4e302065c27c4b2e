"""Tasks with results in files: interrupted work goes on where it ended."""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from functools import cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

from . import _core
from ._errors import InputError, argument

# Tasks under way for each worker: enough that none waits for the driver, few enough that 100,000 machines are not in memory at once.
_AHEAD = 4
# Times that a task whose worker was lost is done again.
_RETRIES = 3


class Task(NamedTuple):
    """A piece of work: a function that returns the text of its result, and its arguments, which must pickle. `key` names what the result depends on."""

    name: str
    key: str
    function: Callable[..., str]
    arguments: tuple[Any, ...]


class Failure(NamedTuple):
    """A task that could not be done: the type and text of its exception, and file, line and key where they are known."""

    name: str
    error: str
    message: str
    file: str | None
    line: int | None
    key: str | None


@cache
def build() -> str:
    """Digest of the extension: another build may compute other bits."""
    return hashlib.sha256(Path(_core.__file__).read_bytes()).hexdigest()


def key_of(*parts: Any) -> str:
    """Digest (SHA-256) of parts: bytes, or anything with a faithful repr; the build of the program is one of them."""
    digest = hashlib.sha256(build().encode())
    for part in parts:
        content = part if isinstance(part, bytes) else repr(part).encode()
        digest.update(len(content).to_bytes(8, "little"))
        digest.update(content)
    return digest.hexdigest()


def result_file(folder: Path, key: str) -> Path:
    """File of a result; folders of two digits keep listings short."""
    return folder / "results" / key[:2] / f"{key}.json"


def _do(folder: str, task: Task) -> Failure | None:
    """Does a task in a worker. The result is written under another name and renamed, so that a file is always whole."""
    target = result_file(Path(folder), task.key)
    try:
        text = task.function(*task.arguments)
    except Exception as fault:  # one machine must not end a fleet
        at = (fault.file, fault.line, fault.key) if isinstance(fault, InputError) else (None, None, None)
        return Failure(task.name, type(fault).__name__, str(fault), *at)
    target.parent.mkdir(parents=True, exist_ok=True)
    part = target.with_name(f"{task.key}.{os.getpid()}.part")
    part.write_text(text, encoding="utf-8")
    os.replace(part, target)
    return None


class Done(NamedTuple):
    """What a run did: tasks done now, tasks whose results were there already, failures, and the time it took (s)."""

    done: int
    kept: int
    failures: list[Failure]
    seconds: float


def prepare(folder: str | os.PathLike[str]) -> Path:
    """Makes the folder of results; refuses one that cannot be written before anything is computed."""
    target = Path(folder)
    try:
        (target / "results").mkdir(parents=True, exist_ok=True)
        probe = target / "results" / f".{os.getpid()}.part"
        probe.touch()
        probe.unlink()
    except OSError as fault:
        message = f"{target}: cannot be written ({fault.strerror or fault}); name a folder that can"
        raise InputError(message, file=str(target), key="folder") from None
    return target


def do(
    folder: Path,
    tasks: Iterable[Task],
    client: Any = None,
    *,
    workers: int | None = None,
    security: Any = None,
    then: Callable[[Task], Iterable[Task]] = lambda _: (),
    progress: Callable[[str, int | None, int | None], Any] | None = None,
    of: int | None = None,
) -> Done:
    """Does tasks on a Dask client, on an executor of `concurrent.futures`, or on processes of this machine.

    `then` gives the tasks that follow a done one. Results that are there already are kept.
    """
    begun = time.monotonic()
    done, kept, failures = 0, 0, []
    waiting = iter(tasks)
    following: list[Task] = []
    running: dict[Future[Failure | None], tuple[Task, int, Executor]] = {}
    with _executor(client, workers, security) as (executor, count):

        def submit(task: Task, tries: int) -> None:
            try:
                running[executor.submit(_do, str(folder), task)] = (task, tries, executor)
            except RuntimeError as fault:
                raise argument(
                    "client",
                    f"takes no work: it is closed or broken ({fault}); give an open one, and run again",
                ) from None

        def start() -> Iterator[Task]:
            nonlocal kept
            while True:
                task = following.pop() if following else next(waiting, None)
                if task is None:
                    return
                if result_file(folder, task.key).exists():
                    kept += 1
                    following.extend(then(task))
                else:
                    yield task

        try:
            while True:
                started = start()
                while len(running) < _AHEAD * count and (task := next(started, None)) is not None:
                    submit(task, 0)
                if not running:
                    break
                finished, _ = wait(running, return_when=FIRST_COMPLETED)
                for future in finished:
                    task, tries, of_future = running.pop(future)
                    try:
                        failure = future.result()
                    except (CancelledError, OSError, RuntimeError) as lost:
                        # The worker was lost, not the task at fault.
                        if tries >= _RETRIES:
                            message = f"its worker was lost {tries + 1} times ({lost}); run again, with fewer workers if memory is short"
                            failures.append(
                                Failure(task.name, type(lost).__name__, message, None, None, None)
                            )
                            continue
                        if of_future is executor:
                            executor = _again(executor, client, workers)
                        submit(task, tries + 1)
                        continue
                    if failure is None:
                        done += 1
                        following.extend(then(task))
                    else:
                        failures.append(failure)
                    if progress is not None:
                        progress(task.name, done + kept + len(failures), of)
        finally:
            for future in running:
                future.cancel()
            if client is None and isinstance(executor, ProcessPoolExecutor):
                executor.shutdown(wait=False, cancel_futures=True)
    return Done(done, kept, failures, time.monotonic() - begun)


def _pool(workers: int) -> ProcessPoolExecutor:
    # A fork after the threads of a computation have started would hang.
    return ProcessPoolExecutor(workers, mp_context=get_context("spawn"))


def _again(executor: Executor, client: Any, workers: int | None) -> Executor:
    """A new pool in place of one that has lost a process; others recover on their own."""
    if client is not None or not isinstance(executor, ProcessPoolExecutor):
        return executor
    executor.shutdown(wait=False, cancel_futures=True)
    return _pool(workers or os.cpu_count() or 1)


@contextmanager
def _executor(client: Any, workers: int | None, security: Any) -> Iterator[tuple[Executor, int]]:
    """Yields the executor of a client, and its number of workers."""
    if client is None:
        count = workers or os.cpu_count() or 1
        try:
            from distributed import Client, LocalCluster
        except ImportError:
            pool = _pool(count)
            yield pool, count
            return
        # Without TLS nobody but this machine may send work.
        common: dict[str, Any] = {
            "n_workers": count,
            "threads_per_worker": 1,
            "processes": True,
            "dashboard_address": None,
        }
        common |= {"host": "127.0.0.1"} if security is None else {"protocol": "tls", "security": security}
        with LocalCluster(**common) as cluster, Client(cluster, security=security) as own:
            yield own.get_executor(pure=False, retries=_RETRIES), count
        return
    if isinstance(client, ProcessPoolExecutor) and client._mp_context.get_start_method() == "fork":
        raise argument(
            "client",
            "forks its processes, which hang once threads have computed here; give ProcessPoolExecutor(mp_context=get_context('spawn'))",
        )
    if isinstance(client, Executor):
        yield client, getattr(client, "_max_workers", None) or os.cpu_count() or 1
        return
    if not hasattr(client, "get_executor"):
        raise argument(
            "client", f"is a {type(client).__name__}; give a Dask client or an executor of concurrent.futures"
        )
    if getattr(client, "status", "running") != "running":
        raise argument("client", f"is {client.status}; give an open client")
    count = max(1, len(client.scheduler_info(n_workers=-1)["workers"]))
    yield client.get_executor(pure=False, retries=_RETRIES), count
