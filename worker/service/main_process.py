"""The main process of a worker: that of Celery, without garbage collection until all is loaded.

    python -s -P -m seamark.worker.service.main_process -A seamark.worker.service.app worker

Of modules hardly anything is garbage. To look for it took a sixth of the time that they take to
load; `seamark.worker.service.tasks` begins with it afterwards.
"""

import gc


def main() -> None:
    """Be Celery."""
    gc.disable()
    from celery.__main__ import main as celery  # noqa: PLC0415 - loads hundreds of modules

    celery()


if __name__ == "__main__":
    main()
