"""Wiring: the one place where store, pool, dispatcher and application meet."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

from fastapi import FastAPI

from service.api.access_token import webhook_secret
from service.api.app import create_app
from service.data_dir import owned
from service.queue.checkpoint_removal import CheckpointRemoval
from service.queue.dispatch import Dispatcher
from service.queue.disposal import Disposal
from service.queue.question_rounds import QuestionRounds
from service.queue.webhooks import Webhooks
from service.queue.worker_memory import runs_at_once
from service.settings import Settings
from service.store.store import Store
from workers.pool.process import PoolProcess, PoolSettings


@contextmanager
def wired(settings: Settings) -> Iterator[FastAPI]:
    """Open everything, yield the application, and close everything in order.

    Raises RefusalError.
    """
    with owned(settings.data_dir):
        store = Store.open(settings.store_url)
        try:
            pool = PoolProcess(
                PoolSettings(
                    settings.workers,
                    settings.ray_address,
                    settings.data_dir,
                    settings.checkpoint_place,
                    settings.min_workers,
                    settings.max_workers,
                    settings.promised_memory,
                )
            )
            dispatcher = Dispatcher(
                store,
                pool,
                limit_of=partial(runs_at_once, worker_memory=settings.run_memory),
            )
            app = create_app(settings, store, dispatcher)
            chores = (
                CheckpointRemoval(store, settings.checkpoint_place, settings.keep_checkpoints),
                Webhooks(
                    store,
                    partial(webhook_secret, settings),
                    settings.webhook_hosts,
                    settings.url,
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
