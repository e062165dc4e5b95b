"""The Celery application of the worker: `celery -A seamark.worker.service.app worker`."""

from celery.signals import setup_logging

from seamark.server.messaging.broker import celery_app
from seamark.server.monitoring import log
from seamark.server.settings import Settings

settings = Settings.load()
log.configure(settings.log_level)
setup_logging.connect(lambda **_: None, weak=False)  # without a receiver, Celery sets up its own
app = celery_app(settings)
app.conf.update(include=["seamark.worker.service.tasks"])
