"""The pages for admins. Adding one is a module here and a line in `ADMIN_PAGES`."""

from seamark.server.pages.administration import (
    audit_log,
    overview,
    people,
    queue,
    rejudgements,
    storage,
    workers,
)

ADMIN_PAGES = [  # in the order of the navigation
    overview.ADMIN_PAGE,
    workers.ADMIN_PAGE,
    queue.ADMIN_PAGE,
    storage.ADMIN_PAGE,
    people.ADMIN_PAGE,
    rejudgements.ADMIN_PAGE,
    audit_log.ADMIN_PAGE,
]
