"""Tasks with results in files: interrupted work goes on where it ended."""

from __future__ import annotations

import concurrent.futures
import hashlib
import os
import sys
import time
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    wait,
)
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple, cast

from . import _core
from ._errors import InputError, argument
from ._main_guard import require_main_guard

# Tasks under way for each worker: enough that none waits for the driver, few enough that 100,000 machines are not in memory at once.
_AHEAD = 4
# Workers that a task must lose while it runs alone before it counts as what ends them.
_LOSSES = 2


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
    """Does a task in a worker. The result is written under another name and renamed, so that a file is always whole.

    Raises
    ------
    InputError
        The result cannot be written, such as on a full disk.
    """
    target = result_file(Path(folder), task.key)
    try:
        text = task.function(*task.arguments)
    except Exception as fault:  # one machine must not end a fleet
        at = (fault.file, fault.line, fault.key) if isinstance(fault, InputError) else (None, None, None)
        return Failure(task.name, type(fault).__name__, str(fault), *at)
    part = target.with_name(f"{task.key}.{os.getpid()}.part")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        part.write_text(text, encoding="utf-8")
        os.replace(part, target)
    except OSError as fault:
        part.unlink(missing_ok=True)
        raise unwritable(folder, fault) from None
    return None


def unwritable(folder: str | os.PathLike[str], fault: OSError) -> InputError:
    """The exception of a folder of results that cannot be written."""
    target = os.fspath(folder)
    return InputError(
        f"{target}: cannot be written ({fault.strerror or fault}); make room, or name a folder that can, and run again: what is done stays",
        file=target,
        key="folder",
    )


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
        raise unwritable(target, fault) from None
    return target


class _Run:
    """Tasks on an executor. A lost worker takes what was sent to it along, but only a task that is alone when its worker is lost can be at fault: those that
    were lost with others are done again one by one, after all others."""

    def __init__(
        self,
        folder: Path,
        tasks: Iterable[Task],
        then: Callable[[Task], Iterable[Task]],
        executor: Executor,
        count: int,
    ) -> None:
        self.folder, self.waiting, self.then = folder, iter(tasks), then
        self.executor, self.count = executor, count
        self.done, self.kept, self.failures = 0, 0, list[Failure]()
        self.following: list[Task] = []
        # Tasks that were lost with others, each with the number of workers that it lost alone.
        self.suspects: list[tuple[Task, int]] = []
        self.running: dict[Future[Failure | None], tuple[Task, int]] = {}
        self.replaced: list[Executor] = []

    def submit(self, task: Task, losses: int) -> None:
        try:
            future = self.executor.submit(_do, str(self.folder), task)
        except BrokenExecutor:
            self.replace()
            future = self.executor.submit(_do, str(self.folder), task)
        except RuntimeError as fault:
            raise argument(
                "client", f"takes no work: it is closed ({fault}); give an open one, and run again"
            ) from None
        self.running[future] = (task, losses)

    def replace(self) -> None:
        """Takes a new pool in place of one that has lost a process; a cluster recovers on its own."""
        self.executor.shutdown(wait=False, cancel_futures=True)
        self.executor = _pool(self.count)
        self.replaced.append(self.executor)

    def next_task(self) -> Task | None:
        """The next task whose result is not there."""
        while True:
            task = self.following.pop() if self.following else next(self.waiting, None)
            if task is None or not result_file(self.folder, task.key).exists():
                return task
            self.kept += 1
            self.following.extend(self.then(task))

    def start(self) -> None:
        """Sends tasks to the workers: enough to keep them busy, or a single one that was lost with others."""
        while len(self.running) < _AHEAD * self.count and (task := self.next_task()) is not None:
            self.submit(task, 0)
        if not self.running and self.suspects:
            task, losses = self.suspects.pop(0)
            self.submit(task, losses)

    def lose(self, task: Task, losses: int, alone: bool, fault: BaseException) -> None:
        """Notes a task whose worker was lost."""
        # Dask gives a task up after some workers that it allows to be lost.
        losses += alone * (1 + getattr(fault, "allowed_failures", 0))
        if losses < _LOSSES:
            self.suspects.append((task, losses))
            return
        message = "its worker was lost each time that it ran alone; look for what ends its process, such as too little memory, and run again"
        self.failures.append(Failure(task.name, type(fault).__name__, message, None, None, None))

    def settle(self) -> Iterator[Task]:
        """Waits for tasks that are under way; yields those that ended, done or not."""
        finished, _ = wait(self.running, return_when=FIRST_COMPLETED)
        alone = len(self.running) == 1
        for future in finished:
            task, losses = self.running.pop(future)
            try:
                failure = future.result()
            except _losses() as fault:
                self.lose(task, losses, alone, fault)
                continue
            if failure is None:
                self.done += 1
                self.following.extend(self.then(task))
            else:
                self.failures.append(failure)
            yield task


def _losses() -> tuple[type[BaseException], ...]:
    """Exceptions of a task whose worker was lost; the task itself returns its failures."""
    distributed = sys.modules.get("distributed")
    of_dask = () if distributed is None else (distributed.KilledWorker,)
    return (BrokenExecutor, CancelledError, OSError, *of_dask)


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
    with _executor(client, workers, security) as (executor, count):
        run = _Run(folder, tasks, then, executor, count)
        try:
            run.start()
            while run.running:
                for task in run.settle():
                    if progress is not None:
                        progress(task.name, run.done + run.kept + len(run.failures), of)
                run.start()
        finally:
            for future in run.running:
                future.cancel()
            for pool in run.replaced:
                pool.shutdown(wait=False, cancel_futures=True)
    return Done(run.done, run.kept, run.failures, time.monotonic() - begun)


def _pool(workers: int) -> concurrent.futures.ProcessPoolExecutor:
    # Processes are imported where they are started: the import of the package stays short.
    from multiprocessing import get_context

    # A fork after the threads of a computation have started would hang.
    return concurrent.futures.ProcessPoolExecutor(workers, mp_context=get_context("spawn"))


def _is_pool(client: Any) -> bool:
    """Whether a client is a pool of processes."""
    return isinstance(client, Executor) and isinstance(client, concurrent.futures.ProcessPoolExecutor)


@contextmanager
def _executor(client: Any, workers: int | None, security: Any) -> Generator[tuple[Executor, int]]:
    """Yields the executor of a client, and its number of workers."""
    if client is None or _is_pool(client):
        require_main_guard()
    if client is None:
        count = workers or os.cpu_count() or 1
        try:
            from dask import config as dask_config
            from distributed import Client, LocalCluster
        except ImportError:
            pool = _pool(count)
            try:
                yield pool, count
            finally:
                pool.shutdown(wait=False, cancel_futures=True)
            return
        # Without TLS nobody but this machine may send work.
        common: dict[str, Any] = {
            "n_workers": count,
            "threads_per_worker": 1,
            "processes": True,
            "dashboard_address": None,
        }
        common |= {"host": "127.0.0.1"} if security is None else {"protocol": "tls", "security": security}
        cluster_of, client_of = cast(Any, LocalCluster), cast(Any, Client)
        # A lost worker is counted here, not by the scheduler.
        counted_here = {"distributed.scheduler.allowed-failures": 0}
        with (
            dask_config.set(counted_here),
            cluster_of(**common) as cluster,
            client_of(cluster, security=security) as own,
        ):
            yield own.get_executor(pure=False), count
        return
    context: Any = getattr(client, "_mp_context", None)
    if _is_pool(client) and context.get_start_method() == "fork":
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
    yield client.get_executor(pure=False), count
