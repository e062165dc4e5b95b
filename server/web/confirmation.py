"""Asks before a form is sent whose button has a question.

The script of the pages asks in a dialog. A browser without it, or one that has not loaded it yet,
sends the question with the form, and the answer is a page that asks: nothing has changed then.
"""

from flask import Flask, render_template, request, url_for
from werkzeug.exceptions import RequestEntityTooLarge

QUESTION = "question"  # name of such a button; its value is what is asked
QUESTION_MAX = 500  # [character]
_OWN = (QUESTION, "csrf_token")


def register(app: Flask) -> None:
    """Ask after the CSRF token was checked and before the form has an effect."""

    @app.before_request
    def ask() -> str | None:
        if request.method != "POST" or request.path.startswith("/api/"):
            return None
        question = request.form.get(QUESTION)
        if not question:
            return None
        if len(question) > QUESTION_MAX:
            raise RequestEntityTooLarge
        fields = [each for each in request.form.items(multi=True) if each[0] not in _OWN]
        back = request.referrer or ""
        return render_template(
            "layout/question.html",
            question=question,
            action=request.full_path.rstrip("?"),
            fields=fields,
            back=back if back.startswith(request.host_url) else url_for("home.show"),
        )
