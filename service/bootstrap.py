"""Wiring: the one place where store, pool, dispatcher and application meet."""

from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path

from fastapi import FastAPI

from service.api.access.access_token import webhook_secret
from service.api.app import create_app
from service.api.load.side_process import SideProcess, TooSlowError
from service.data_dir import owned
from service.model.environment import (
    EnvironmentFacts,
    know_tasks_of_packages,
    tasks_of_packages,
)
from service.queue.checkpoint_removal import CheckpointRemoval
from service.queue.dispatch import Dispatcher
from service.queue.disposal import Disposal
from service.queue.question_rounds import QuestionRounds
from service.queue.webhooks import Webhooks
from service.queue.worker_memory import runs_at_once
from service.settings import Settings
from service.store.store import Store
from service.task_shelf import TaskFileError, TaskShelf
from workers.pool.pool import Pool
from workers.pool.process import PoolProcess, PoolSettings
from workers.pool.standing_pool import StandingPool


@contextmanager
def wired(settings: Settings) -> Iterator[FastAPI]:
    """Open everything, yield the application, and close everything in order.

    Raises RefusalError.
    """
    with owned(settings.data_dir):
        shelf = filled_shelf(settings)
        store = Store.open(settings.store_url)
        try:
            dispatcher = Dispatcher(
                store,
                pool_of(settings),
                limit_of=partial(runs_at_once, worker_memory=settings.run_memory),
                file_of=shelf.file_of,
            )
            app = create_app(settings, store, dispatcher, shelf)
            chores = (
                CheckpointRemoval(store, settings.checkpoint_place, settings.keep_last),
                Webhooks(
                    store,
                    partial(webhook_secret, settings),
                    settings.webhook_hosts,
                    settings.public.url,
                ),
                Disposal(store, settings.checkpoint_place, settings.retention),
                QuestionRounds(store),
            )
            dispatcher.start()
            for each in chores:
                each.start()
            try:
                yield app
            finally:
                for each in chores:
                    each.stop()
                dispatcher.stop()
        finally:
            store.close()


def pool_of(settings: Settings) -> Pool:
    """Return the pool of workers, of a process of our own or of one that stands apart."""
    pool = PoolSettings(
        settings.workers,
        settings.ray_address,
        settings.data_dir,
        settings.checkpoint_place,
        settings.min_workers,
        settings.max_workers,
        settings.promised_memory,
    )
    return (
        PoolProcess(pool) if settings.driver is None else StandingPool(settings.driver, pool.terms)
    )


def filled_shelf(settings: Settings) -> TaskShelf:
    """Return the shelf with the tasks to be served.

    Another process runs each file, and the code of installed tasks that are not part of d3pg.

    Raises TaskFileError.
    """
    shelf = TaskShelf(settings.data_dir)
    with closing(SideProcess()) as side:
        shelf.serve(settings.tasks, partial(_described, side))
        know_tasks_of_packages({name: _installed(side, name) for name in tasks_of_packages()})
    return shelf


def _installed(side: SideProcess, name: str) -> EnvironmentFacts | str:
    """Return the facts of an installed task, or why it cannot be used."""
    try:
        facts: EnvironmentFacts = side.call("service.model.environment:facts_of_package", name)
    except ValueError as error:
        return str(error)
    except TooSlowError as error:
        return f"{name} cannot be loaded: {error}"
    except EOFError:
        return f"{name} cannot be loaded: the process that ran it died"
    return facts


def _described(side: SideProcess, path: Path) -> Sequence[EnvironmentFacts]:
    """Return the facts of a file's tasks. Raises ValueError and TaskFileError."""
    try:
        facts: Sequence[EnvironmentFacts] = side.call(
            "service.model.environment:facts_of_file", path
        )
    except TooSlowError as error:
        raise TaskFileError(f"{path} cannot be loaded: {error}") from error
    except EOFError as error:
        raise TaskFileError(f"{path} cannot be loaded: the process that ran it died") from error
    return facts
