"""What programs find in their boxes, by the API and on the page."""

from seamark.server.database.tables import Worker
from seamark.server.messaging import workers
from tests.server.api.conftest import Site


def _register(site: Site, name: str, numpy: str) -> None:
    contents = {
        "python": [
            {"kind": "interpreter", "name": "Python", "version": "3.11.2"},
            {"kind": "library", "name": "NumPy", "version": numpy},
        ]
    }
    row = Worker(name=name, slots=1, level="strong", languages=["python"], findings=[])
    row.contents = contents
    with site.database.writing() as session:
        workers.register(session, row)


def test_the_api_and_the_page_show_what_workers_report_and_where_they_differ(site: Site) -> None:
    _register(site, "a", "2.4.1")
    _register(site, "b", "2.4.0")

    answer = site.client().get("/api/v1/environment").get_json()
    page = site.client().get("/docs/box").get_data(as_text=True)

    (python,) = answer["languages"]
    assert (python["language"], python["label"], python["workers"]) == ("python", "Python", 2)
    assert python["components"] == [
        {
            "kind": "interpreter",
            "name": "Python",
            "versions": [{"version": "3.11.2", "workers": 2}],
            "everywhere": True,
        },
        {
            "kind": "library",
            "name": "NumPy",
            "versions": [{"version": "2.4.1", "workers": 1}, {"version": "2.4.0", "workers": 1}],
            "everywhere": False,
        },
    ]
    assert "3.11.2" in page
    assert page.count("on 1 of 2 workers") == 2


def test_the_page_says_that_no_worker_is_online(site: Site) -> None:
    assert site.client().get("/api/v1/environment").get_json() == {"languages": []}
    page = site.client().get("/docs/box").get_data(as_text=True)

    assert "No worker that runs uploaded programs is online" in page
