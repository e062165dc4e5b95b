"""`python -m tests.chaos.vanishing_claim`: claims a run, says so, and never commits."""

import time

from sqlalchemy.orm import Session

from seamark.server.database.engine import Database
from seamark.server.runs.queue import queue
from seamark.server.settings import Settings

POLL_S = 0.002


def main() -> None:
    """Hold the locks of a claim until somebody ends this process or its transaction."""
    settings = Settings.load()
    database = Database(settings.database_url)
    while True:
        with Session(database.engine) as session:
            claim = queue.try_claim(session, "gone/0", languages=(), settings=settings)
            if claim is not None:
                print(claim.run_id, flush=True)
                time.sleep(3600.0)
        time.sleep(POLL_S)


if __name__ == "__main__":
    main()
