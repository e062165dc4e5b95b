"""The web application: created once per process from the settings."""

import atexit
import gc
import threading
import time
from datetime import timedelta
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

from flask import g, request, session
from flask_openapi3.models.info import Info
from flask_openapi3.openapi import OpenAPI
from flask_wtf.csrf import CSRFProtect
from werkzeug.middleware.proxy_fix import ProxyFix

from seamark import templates
from seamark.server import api, pages
from seamark.server.accounts.browser_sessions import SESSION_DAYS
from seamark.server.accounts.permissions import Action, can
from seamark.server.runs.showing import camera_view
from seamark.server.settings import Settings
from seamark.server.web import (
    authentication,
    body_limits,
    compression,
    confirmation,
    identity_provider,
    problems,
    rate_limits,
    request_log,
    security_headers,
    static_files,
)
from seamark.server.web.asgi import AsgiApplication
from seamark.server.web.services import Services, services

_VERSION = version("seamark")  # reads a file
_SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS", "TRACE"})
_FOLDER = Path(templates.__file__).parent


def create_app(settings: Settings) -> OpenAPI:
    """Return the application with all pages and the API; its services are in `extensions`."""
    app = OpenAPI(
        "seamark",
        info=Info(title="Seamark", version=_VERSION),
        template_folder=str(_FOLDER),
        static_folder=None,  # `static_files` serves it
        doc_ui=False,  # /api/docs is the API's own page
        validation_error_callback=lambda error: problems.from_validation_error(error).response(),
    )
    _configure(app, settings)
    _trust_proxies(app, settings.proxies)
    app_services = Services.start(settings)
    app.extensions["seamark"] = app_services
    atexit.register(app_services.close)
    request_log.register(app)
    authentication.register(app)
    body_limits.register(app, settings)
    _protect(app)
    rate_limits.register(app, settings)
    confirmation.register(app)
    identity_provider.register(app, settings)
    security_headers.register(app, public=settings.public)
    compression.register(app)
    static_files.register(app, _FOLDER / "static")
    pages.register(app)
    api.register(app)
    app.context_processor(_common)
    return app


SHARE_EVERY_S = 5.0
# When a service starts, its first pages and its worker need the cores more than the camera's code.
# Whoever asks for an image before that waits while it is loaded.
CAMERA_AFTER_S = 20.0


def prepare() -> None:
    """Load and compile what requests need, and keep it from the garbage collector."""
    camera_view.warm_up()
    _keep_what_is_loaded()


def _prepare_later() -> None:
    _keep_what_is_loaded()
    time.sleep(CAMERA_AFTER_S)
    prepare()


def _keep_what_is_loaded() -> None:
    """Hide it from the collector: looking at 300,000 objects stopped all requests for 0.14 s."""
    gc.collect()
    gc.freeze()


class WebApplication(AsgiApplication):
    """The application as the web server runs it."""

    def __init__(self, settings: Settings) -> None:
        app = create_app(settings)
        super().__init__(app, partial(body_limits.body_max, settings), request_log.write)
        self.proxies = settings.proxies
        self._services: Services = app.extensions["seamark"]
        threading.Thread(target=_prepare_later, name="prepare", daemon=True).start()
        threading.Thread(target=self._share_meters, name="meters", daemon=True).start()

    def _share_meters(self) -> None:
        """Report this process as long as it is there: another one may be asked for the metrics."""
        while True:
            self._services.share_meters()
            time.sleep(SHARE_EVERY_S)

    def end_streams(self) -> None:
        """End all live streams; their clients connect again."""
        self._services.streams.end_all()


def _configure(app: OpenAPI, settings: Settings) -> None:
    app.config.update(
        SECRET_KEY=settings.secret_key,
        SESSION_COOKIE_NAME="seamark",
        SESSION_COOKIE_HTTPONLY=True,
        SESSION_COOKIE_SAMESITE="Lax",
        SESSION_COOKIE_SECURE=settings.public,
        PERMANENT_SESSION_LIFETIME=timedelta(days=SESSION_DAYS),
        WTF_CSRF_CHECK_DEFAULT=False,  # `_protect` decides: requests with an API token need none
        WTF_CSRF_TIME_LIMIT=None,  # a form may be filled in for hours
        WTF_CSRF_SSL_STRICT=False,  # the token suffices; proxies change the Referer
    )


def _trust_proxies(app: OpenAPI, count: int) -> None:
    """Take the client's address from the proxies in front, so that rate limits count clients.

    Not the host: a proxy that does not set it would pass on whatever the client sent.
    """
    if count:
        app.wsgi_app = ProxyFix(app.wsgi_app, x_for=count, x_proto=count, x_host=0)  # type: ignore[method-assign]


def _protect(app: OpenAPI) -> None:
    """Require the CSRF token where a cookie could change something."""
    csrf = CSRFProtect(app)

    @app.before_request
    def check_csrf_token() -> None:
        if request.method in _SAFE_METHODS or authentication.by_token():
            return
        # An API client without a cookie acts for nobody, so there is nobody to trick.
        if request.path.startswith("/api/") and not session:
            return
        csrf.protect()


def _name_of_provider(settings: Settings) -> str:
    """Return what pages call the identity provider; empty if there is none."""
    return settings.oidc_name if settings.oidc_issuer else ""


def _common() -> dict[str, Any]:
    """Return the variables of all templates."""
    return {
        "viewer": g.viewer,
        "version": _VERSION,
        "sign_up": services().settings.sign_up,
        "identity_provider": _name_of_provider(services().settings),
        "sends_mail": bool(services().settings.mail_url),
        "administers": can(g.viewer, Action.ADMINISTER),
    }
