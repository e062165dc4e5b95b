"""Security headers of all responses."""

from urllib.parse import urlsplit, urlunsplit

from flask import Flask, Response, request

from seamark.server.web import redirects

# No inline scripts or styles: malicious file names and logs are never executed, even if escaping
# is forgotten somewhere. JSON data blocks are not scripts and remain allowed.
FRAMES_DENIED = "frame-ancestors 'none'"
CONTENT_SECURITY_POLICY = "; ".join(
    (
        "default-src 'none'",
        "script-src 'self'",
        "style-src 'self'",
        "img-src 'self'",
        "font-src 'self'",
        "connect-src 'self'",
        "manifest-src 'self'",
        "form-action 'self'",
        "base-uri 'none'",
        FRAMES_DENIED,
    )
)
HEADERS = {
    "Content-Security-Policy": CONTENT_SECURITY_POLICY,
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), geolocation=(), microphone=(), payment=(), usb=()",
}
ONE_YEAR_S = 31_536_000


def embeddable(response: Response, origins: str) -> Response:
    """Allow pages of this service, and of these origins, to show the response in a frame."""
    allowed = " ".join(("frame-ancestors 'self'", *origins.split()))
    policy = CONTENT_SECURITY_POLICY.replace(FRAMES_DENIED, allowed)
    response.headers["Content-Security-Policy"] = policy
    # Browsers ignore it beside frame-ancestors; it has no word for other origins.
    response.headers["X-Frame-Options"] = "SAMEORIGIN"
    return response


def register(app: Flask, *, public: bool) -> None:
    """Add the headers to all responses, unless the route has set them."""

    @app.after_request
    def add_headers(response: Response) -> Response:
        for name, value in HEADERS.items():
            response.headers.setdefault(name, value)
        if public and request.is_secure:
            response.headers.setdefault("Strict-Transport-Security", f"max-age={ONE_YEAR_S}")
        if request.endpoint != "static":
            # Pages depend on who views them, so shared caches must not store them.
            response.headers.setdefault("Cache-Control", "private, no-cache")
        return response

    @app.after_request
    def redirect_to_paths(response: Response) -> Response:
        """Name no host in redirects: the router takes it from the request, where it is forged."""
        target = urlsplit(response.headers.get("Location", ""))
        if target.netloc and not redirects.leaves():
            path = "/" + target.path.lstrip("/")
            response.headers["Location"] = urlunsplit(("", "", path, target.query, target.fragment))
            response.set_data(b"")  # the router's page names the host too
        return response
