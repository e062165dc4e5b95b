"""The Celery application of the worker: `celery -A seamark.worker.service.app worker`."""

from seamark.server.log import configure
from seamark.server.messaging.broker import celery_app
from seamark.server.settings import Settings

configure()
settings = Settings.load()
app = celery_app(settings)
app.conf.update(include=["seamark.worker.service.tasks"])
