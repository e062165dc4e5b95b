"""The Celery application of worker and beat: `celery -A worker.app worker`."""

from server.broker import celery_app
from server.log import configure
from server.settings import Settings

configure()
settings = Settings.load()
app = celery_app(settings)
app.conf.update(include=["worker.tasks"])
