"""Headers that every answer carries: what a page may load, and what other sites may do with it."""

from flask import Flask, Response, request

# No inline script or style anywhere: hostile file names and logs cannot become code, even where
# escaping were forgotten. JSON data blocks are not scripts and stay allowed.
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
        "frame-ancestors 'none'",
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


def register(app: Flask, *, public: bool) -> None:
    """Add the headers to all answers; a route that sets one of them itself keeps its own."""

    @app.after_request
    def add_headers(response: Response) -> Response:
        for name, value in HEADERS.items():
            response.headers.setdefault(name, value)
        if public and request.is_secure:
            response.headers.setdefault("Strict-Transport-Security", f"max-age={ONE_YEAR_S}")
        if request.endpoint != "static":
            # Pages show what one person may see; no shared cache may keep them.
            response.headers.setdefault("Cache-Control", "private, no-cache")
        return response
