"""Both clients against a service: what they send, follow, read and change."""

import asyncio
import io
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_type_hints

import httpx
import numpy as np
import pytest

import seamark
from seamark.client import (
    NotFound,
    NotPermitted,
    PackageMissing,
    ServerUnavailable,
    StillRunning,
    documents,
    tables,
)
from seamark.client.async_client import AsyncClient
from seamark.client.async_runs import AsyncRun, AsyncSweep
from seamark.client.sync_client import Client
from seamark.client.sync_runs import Run, Sweep
from seamark.server.app import create_app
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.publication import publications
from seamark.sim.recording.telemetry import INDEX, WIDTH
from tests.cast import PROGRAM, Backend


@pytest.fixture
def client(address: str, token: str) -> Iterator[Client]:
    with Client(address, token, patience_s=5.0) as connected:
        yield connected


def _with_rows(backend: Backend, *, who: str = "ann") -> int:
    """Return a finished run with ten rows of telemetry and a log."""
    claim = backend.running(who)
    files = RunFiles(backend.settings.data, claim.run_id, 1)
    rows = np.zeros((10, WIDTH))
    rows[:, INDEX["t"]] = np.arange(10) / 20
    rows[:, INDEX["distance"]] = np.linspace(0.0, 0.9, 10)
    files.append_rows(rows)
    files.append_log("Grüße\n".encode())
    assert backend.finish(claim)
    return claim.run_id


def test_importing_seamark_loads_neither_the_client_nor_the_server() -> None:
    heavy = "{'httpx', 'numpy', 'seamark.client'}"
    servers = "{'flask', 'sqlalchemy', 'celery', 'redis', 'numba', 'cv2', 'pydantic'}"
    code = (
        f"import sys, seamark; assert not {heavy} & set(sys.modules)\n"
        f"seamark.Client(); assert not {servers} & set(sys.modules), {servers} & set(sys.modules)\n"
    )

    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)

    assert seamark.Client is Client
    with pytest.raises(AttributeError, match="has no attribute 'Clint'"):
        _ = seamark.Clint


@pytest.mark.slow
def test_address_and_token_come_from_the_environment_and_are_never_shown(
    address: str, token: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SEAMARK_SERVER", f"{address}/")
    monkeypatch.setenv("SEAMARK_TOKEN", token)

    with Client() as client:
        assert client.account()["name"] == "ann"
        assert client.server == address
        assert repr(client) == f"<client of {address}>"


@pytest.mark.slow
def test_a_program_is_submitted_and_read_back(client: Client, tmp_path: Path) -> None:
    program = tmp_path / "mine.py"
    program.write_bytes(PROGRAM)

    run = client.submit("currents-v1", program=program, config={"kp": 0.7}, seed=3, title="Näxt")

    assert (run.state, run.ended, run.score, run.score_interval) == ("queued", False, None, None)
    assert run.document["config"]["kp"] == 0.7
    assert (run.document["title"], run.document["seed"]) == ("Näxt", 3)
    assert run.program() == PROGRAM
    assert [found.id for found in client.runs(state=["queued"])] == [run.id]
    assert run.cancel().state == "cancelled"
    assert client.run(run.id).ended


def test_a_list_of_runs_goes_on_over_its_pages(backend: Backend, client: Client) -> None:
    wanted = [backend.succeeded() for _ in range(3)][::-1]
    first = [run.id for run in client.runs(limit=2)]

    assert first == wanted[:2]
    assert [run.id for run in client.runs()] == wanted
    assert list(client.runs(which="public")) == []


@pytest.mark.slow
def test_a_run_is_followed_to_its_end(
    backend: Backend, client: Client, capsys: pytest.CaptureFixture[str]
) -> None:
    run, seen = client.submit("currents-v1", controller="pi"), list[str]()
    ending = threading.Timer(0.5, lambda: backend.finish(backend.claim_next()))
    ending.start()

    assert run.wait(on_change=lambda now: seen.append(now.state)) is run
    ending.join()

    assert (seen[0], seen[-1], run.state) == ("queued", "succeeded", "succeeded")
    assert (run.score, run.score_interval, run.digest) == (50.0, (45.0, 55.0), "0" * 64)
    assert f"run {run.id}:   0 % after" in capsys.readouterr().err
    assert run.metrics()["score"] == 50.0
    assert run.page == f"{client.server}/runs/{run.id}"


def test_waiting_for_a_run_can_be_limited(client: Client) -> None:
    run = client.submit("currents-v1", controller="pi")

    with pytest.raises(StillRunning, match=rf"The run {run.id} has not ended within 0\.1 s"):
        run.wait(timeout_s=0.1, progress=False)


@pytest.mark.slow
def test_a_run_is_published_and_withdrawn(backend: Backend, client: Client) -> None:
    run = client.run(_with_rows(backend))

    assert run.publish().public
    assert not run.withdraw().public
    with pytest.raises(NotFound):
        client.run(_with_rows(backend, who="ben"))
    with pytest.raises(NotPermitted):
        client.run(backend.published("ben")).withdraw()


@pytest.mark.slow
def test_both_clients_download_a_run_into_a_file_and_not_what_is_refused(
    backend: Backend, client: Client, address: str, token: str, tmp_path: Path
) -> None:
    run_id, withdrawn = _with_rows(backend), client.run(backend.published("ben"))
    kept = io.BytesIO(b"of an attempt before, and longer than all of this" * 100_000)

    async def download() -> None:
        async with AsyncClient(address, token) as connected:
            await (await connected.run(run_id)).download("npz", kept)

    asyncio.run(download())
    run = client.run(run_id)
    run.download("npz", tmp_path / "run.npz")
    with pytest.raises(ValueError, match="formats are csv, parquet, "):
        run.download("hdf5", tmp_path / "run.hdf5")
    with backend.database.writing() as session:
        assert publications.withdraw(session, withdrawn.id)
    with pytest.raises(NotFound):
        withdrawn.download("csv", tmp_path / "run.csv")

    assert (tmp_path / "run.npz").read_bytes() == kept.getvalue()
    assert np.array_equal(np.load(tmp_path / "run.npz")["telemetry"], run.telemetry())
    assert not (tmp_path / "run.csv").exists()


@pytest.mark.slow
def test_a_download_that_fails_leaves_the_file_that_was_there(
    backend: Backend, client: Client, tmp_path: Path
) -> None:
    run, file = client.run(_with_rows(backend)), tmp_path / "download" / "run.csv"
    file.parent.mkdir()
    file.write_bytes(b"old")

    def broken(request: httpx.Request) -> httpx.Response:
        if request.url.path.endswith("telemetry.csv"):
            return httpx.Response(200, stream=_Broken())
        return httpx.Response(200, json=run.document)

    def page(request: httpx.Request) -> httpx.Response:
        if request.url.path.endswith("telemetry.csv"):
            return httpx.Response(200, html="<p>Sign in to the network.</p>")
        return httpx.Response(200, json=run.document)

    with pytest.raises(ValueError, match="formats are csv, parquet, "):
        run.download("hdf5", file)
    for answer in (broken, page):
        transport = httpx.MockTransport(answer)
        with (
            Client("http://there", patience_s=0.0, transport=transport) as there,
            pytest.raises(ServerUnavailable),
        ):
            there.run(run.id).download("csv", file)

    assert file.read_bytes() == b"old"
    assert list(file.parent.iterdir()) == [file]


class _Broken(httpx.SyncByteStream):
    def __iter__(self) -> Iterator[bytes]:
        yield b"# half of the"
        raise httpx.ReadError("Connection reset by peer")


@pytest.mark.slow
def test_telemetry_log_and_plot_of_a_run(backend: Backend, client: Client) -> None:
    run = client.run(_with_rows(backend))

    rows = run.telemetry()
    picture = io.BytesIO()
    drawn = run.plot()
    drawn.savefig(picture, format="png")

    assert rows.dtype.names is not None
    assert len(rows.dtype.names) == WIDTH
    assert rows["t"].tolist() == [at / 20 for at in range(10)]
    assert run.log() == "Grüße\n"
    assert picture.getvalue().startswith(b"\x89PNG")
    assert np.array_equal(drawn.axes[0].lines[0].get_ydata(), rows["distance"])
    with pytest.raises(ValueError, match="has 1 trial, counted from 1"):
        run.plot(trial=2)


def test_a_package_that_is_missing_is_named_with_how_to_install_it() -> None:
    with pytest.raises(PackageMissing, match=r"^nowhere is not installed\. `pip install nowhere`"):
        tables.package("nowhere.inner")
    with pytest.raises(ValueError, match="as numpy, pandas, polars, arrow, not as 'excel'"):
        tables.table("excel", ["t"], b"")  # type: ignore[arg-type]


@pytest.mark.slow
def test_a_sweep_is_started_followed_and_compared(backend: Backend, client: Client) -> None:
    sweep = client.sweep("currents-v1", {"kp": [0.3, 0.5]}, controller="pi", seed=5)
    first, second = sweep.runs
    for score in (40.0, 60.0):
        backend.finish(backend.claim_next(), score)

    assert not sweep.ended
    assert sweep.wait(progress=False).ended
    assert sweep.best is not None
    assert (sweep.best.id, sweep.best.score) == (second.id, 60.0)
    assert sweep.document["cells"][1]["values"] == {"kp": 0.5}
    assert client.find_sweep(sweep.id).ended
    found = client.compare([first.id, second.id])
    assert found["scores"][0]["difference"] == pytest.approx(20.0)


def test_leaderboard_and_benchmarks(backend: Backend, client: Client) -> None:
    backend.published("eva", kind="ranked")

    board = client.leaderboard("currents-v1", program="built-in", limit=5)

    assert [row["user"] for row in board["ranks"]] == ["eva"]
    assert "currents-v1" in [benchmark["name"] for benchmark in client.benchmarks()]
    assert "kp" in client.benchmark("currents-v1")["schema"]["properties"]


@pytest.mark.slow
def test_the_asynchronous_client_does_the_same(
    backend: Backend, address: str, token: str, capsys: pytest.CaptureFixture[str]
) -> None:
    run_id = _with_rows(backend)

    async def session() -> tuple[Any, ...]:
        async with AsyncClient(address, token) as client:
            done = await client.run(run_id)
            queued = await client.submit("currents-v1", controller="pi")
            states = [run.state async for run in done.follow()]
            sweep = await client.sweep("currents-v1", {"kp": "0.1:0.2:2"}, controller="pi")
            listed = [run.id async for run in client.runs(limit=1)]
            await asyncio.gather(queued.cancel(), sweep.cancel())
            await asyncio.gather(queued.wait(), sweep.wait())
            await done.publish()
            return done, await done.telemetry(), await done.log(), states, sweep, listed, queued

    done, rows, log, states, sweep, listed, queued = asyncio.run(session())

    assert (done.public, rows["t"][9], log, states) == (True, 0.45, "Grüße\n", ["succeeded"])
    assert (queued.state, sweep.ended) == ("cancelled", True)
    assert listed == [sweep.runs[-1].id]
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(("sync", "other"), [(Client, AsyncClient), (Run, AsyncRun)])
def test_both_clients_have_the_same_methods(sync: type, other: type) -> None:
    def methods(kind: type) -> set[str]:
        return {name for name in dir(kind) if not name.startswith("_")}

    assert methods(sync) == methods(other)
    assert methods(Sweep) == methods(AsyncSweep)


@pytest.mark.parametrize(
    ("model", "document"),
    [
        ("RunResponse", documents.RunDocument),
        ("SweepResponse", documents.SweepDocument),
        ("CellResponse", documents.CellDocument),
        ("RankResponse", documents.RankDocument),
        ("RanksResponse", documents.LeaderboardDocument),
        ("CompareResponse", documents.ComparisonDocument),
        ("BenchmarkResponse", documents.BenchmarkDocument),
    ],
)
def test_the_types_of_documents_are_those_of_the_openapi_document(
    backend: Backend, model: str, document: type
) -> None:
    app = create_app(backend.settings)
    schemas = app.test_client().get("/api/v1/openapi.json").get_json()["components"]["schemas"]
    app.extensions["seamark"].close()

    assert set(get_type_hints(document)) == set(schemas[model]["properties"])
