"""`./run machines`: the services of compose.yaml on two machines that share no folder.

Their commands, settings, users, rights, secrets and health checks are read from the Compose files.
Nothing runs in an image, so what the images add is done here: PostgreSQL's first start, and an S3
server instead of Garage. Prints a line per check, and ends with 1 if one has failed.
"""

import json
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any
from urllib.parse import urlencode

import httpx
from sqlalchemy import select
from websockets.sync.client import connect

from seamark.client import Client, ServerUnavailable
from seamark.client.sessions import NO_CERTIFICATES
from seamark.client.sync_runs import Run as ClientRun
from seamark.server.database.engine import Database
from seamark.server.database.tables import Run
from seamark.server.messaging import workers
from seamark.sim import registry
from seamark.sim.engine.seeds import hidden_seed
from seamark.worker.evaluation.local import evaluate_locally, evaluate_seeds
from tests.chaos import machine_session
from tests.chaos.campaign import PROGRAM
from tests.chaos.faults import ERRORS_S, HANG_S
from tests.chaos.machine_session import ELSEWHERE, HERE, QUOTAS, START_S, Session
from tests.seamark.bridge.rosbridge.conftest import Client as RosClient
from tests.services import compose
from tests.services.embedded import cancel_baselines
from tests.services.faulty_s3 import Behaviour
from tests.worker.conftest import wait_until

REFUSED_S = 120.0  # until a worker that must not start has ended
STANDSTILL_S, POLL_S = 60.0, 0.25
PAGE_S = 15.0  # slowest answer while a storage hangs
STEPS = ("migrate", "worker-rights", "reference-entries")
SEED = 3
SHORT = {"levels": [0.0, 0.2], "level_duration_s": 60.0, "settle_s": 1.0}
# Long enough to be seen running on a fast machine: progress is published every five seconds.
LONG = SHORT | {"levels": [at / 20 for at in range(10)], "level_duration_s": 600.0}
UPLOADED = {"levels": [0.0, 0.2], "level_duration_s": 8.0, "settle_s": 1.0}
RANKED: Any = {"controller": "pi", "kind": "ranked"}


class Service:
    """The service as a user and an operator see it."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self.tokens = [self._token_of(name) for name in ("ann", "ben")]
        self.clients = [self._client(name, self.tokens[0]) for name in ("web-1", "web-2")]
        self.database = Database(session.url("database_url"))

    def _token_of(self, user: str) -> str:
        words = ["seamark", "user", "add", user, "--password", "correct horse", "--json"]
        self.session.step("migrate", words)
        return self.session.step("migrate", ["seamark", "token", "new", user]).split()[-1]

    def _client(self, name: str, token: str) -> Client:
        return Client(f"http://{self.session.running[name].address}:8000", token=token)

    def submit(self, count: int, config: Mapping[str, object], **options: Any) -> list[ClientRun]:
        """Submit runs by both web servers in turn."""
        arguments: Any = {"controller": "pi", "config": config, "seed": SEED} | options
        clients = [self.clients[number % 2] for number in range(count)]
        return [client.submit("currents-v1", **arguments) for client in clients]

    def both_ready(self) -> bool:
        """Return whether the simulators of both workers are loaded."""
        with self.database.reading() as session:
            alive = [worker for worker in workers.listed(session) if worker.alive]
        return len(alive) >= 2 and not any(worker.preparing for worker in alive)

    def worker_of(self, run: ClientRun) -> str:
        """Return the name of the container that has or had a run."""
        with self.database.reading() as session:
            worker = session.scalar(select(Run.worker).where(Run.id == run.id)) or ""
        return worker.partition("@")[2].partition("/")[0]

    def attempts(self, run: ClientRun) -> int:
        """Return how often a run was started."""
        with self.database.reading() as session:
            return session.get_one(Run, run.id).attempt

    def finished(self, runs: list[ClientRun]) -> set[tuple[str, str]]:
        """Wait for runs; return their states and digests."""
        with ThreadPoolExecutor(len(runs)) as threads:
            ended = threads.map(lambda run: run.wait(timeout_s=START_S, progress=False), runs)
        documents = [run.document for run in ended]
        return {(each["state"], (each["result"] or {}).get("digest", "")) for each in documents}


def equal_results(service: Service) -> None:
    """Runs on both machines have the digest of an evaluation on this one."""
    program = service.session.host.folder / "p.py"
    program.write_bytes(PROGRAM)
    key = (service.session.host.secrets / "seed_key").read_text().encode()
    trials = registry.benchmark("currents-v1").ranked_trials
    hidden = tuple(hidden_seed(key, "currents-v1", trial) for trial in range(trials))
    cases: dict[str, tuple[list[ClientRun], str]] = {
        "a built-in controller": (
            service.submit(8, SHORT),
            evaluate_locally("currents-v1", SHORT, seed=SEED, controller="pi").digest,
        ),
        "an uploaded program": (
            service.submit(6, UPLOADED, controller=None, program=program),
            evaluate_locally("currents-v1", UPLOADED, seed=SEED, controller="p").digest,
        ),
        "a ranked run": (
            [client.submit("currents-v1", **RANKED) for client in service.clients * 2],
            evaluate_seeds("currents-v1", {}, seeds=hidden, controller="pi").digest,
        ),
    }
    for name, (runs, wanted) in cases.items():
        found = service.finished(runs)
        machines = sorted({service.worker_of(run) for run in runs})
        both = machines == ["worker-a", "worker-b"]
        service.session.saw(f"{name}: {len(runs)} runs on {' and '.join(machines)}", both)
        service.session.saw(f"{name}: the digest of a local run", found == {("succeeded", wanted)})
        rows = {len(run.telemetry()) for run in runs}
        service.session.saw(f"{name}: {max(rows)} rows of data by both web servers", len(rows) == 1)


def killed_worker(service: Service) -> None:
    """The run of a worker that dies ends on the other one."""
    [run] = service.submit(1, LONG)
    wait_until(lambda: run.refresh().state == "running" and run.progress > 0.02)
    first = service.worker_of(run)
    service.session.running[first].stop(signal.SIGKILL)
    found = service.finished([run])
    wanted = evaluate_locally("currents-v1", LONG, seed=SEED, controller="pi").digest
    last = service.worker_of(run)
    service.session.saw(f"killed in the middle on {first}, the run ended on {last}", first != last)
    service.session.saw("with the same digest", found == {("succeeded", wanted)})
    _start_worker(service.session, first)


def connected_programs(service: Service) -> None:
    """Two programs, connected by rosbridge to one web server each, run at once on both workers."""
    query = {"benchmark": "currents-v1", "seed": str(SEED), "config": json.dumps(UPLOADED)}

    def connect_program(number: int) -> tuple[ClientRun, str]:
        client, token = service.clients[number], service.tokens[number]
        address = f"{client.server.replace('http', 'ws', 1)}/api/v1/rosbridge?{urlencode(query)}"
        headers = {"Authorization": f"Bearer {token}"}
        with connect(
            address, additional_headers=headers, max_size=None, compression=None
        ) as socket:
            assert socket.response is not None
            run_id = int(socket.response.headers["Location"].rpartition("/")[2])
            program = RosClient(socket)
            program.subscribe("/seamark/error")
            digest = program.answer_all("/seamark/error", lambda _error: 0.0)["digest"]
            own = Client(client.server, token=token).run(run_id)
            return own.wait(timeout_s=START_S, progress=False), str(digest)

    with ThreadPoolExecutor(2) as threads:
        found = list(threads.map(connect_program, (0, 1)))
    wanted = evaluate_locally("currents-v1", UPLOADED, seed=SEED, controller="nothing").digest
    machines = sorted(service.worker_of(each) for each, _ in found)
    both = machines == ["worker-a", "worker-b"]
    service.session.saw(f"connected programs: one on {' and one on '.join(machines)}", both)
    same = {digest for _, digest in found} == {wanted}
    service.session.saw("connected programs: the digest of a local run", same)


def vanished_machine(service: Service) -> None:
    """A machine that vanishes in the middle of a claim stops neither the queue nor an owner."""
    gone = service.session.running["worker-b"]
    runs = service.submit(6, SHORT)
    others = [Client(client.server, token=service.tokens[1]) for client in service.clients]
    arguments: Any = {"controller": "pi", "config": SHORT, "seed": SEED}
    runs += [other.submit("currents-v1", **arguments) for other in others * 3]
    words = ["env", f"PYTHONPATH={compose.ROOT}", sys.executable]
    claim = gone.begin([*words, "-m", "tests.chaos.vanishing_claim"])
    assert claim.stdout is not None
    claimed = int(claim.stdout.readline())
    gone.connect(up=False)
    longest_s, ended_at, live = 0.0, time.monotonic(), set(runs)
    while live and longest_s < REFUSED_S:
        ended = {run for run in live if run.refresh().state not in ("queued", "running")}
        longest_s = max(longest_s, time.monotonic() - ended_at)
        if ended:
            ended_at, live = time.monotonic(), live - ended
        time.sleep(POLL_S)
    claim.kill()
    gone.connect(up=True)
    session, states = service.session, {run.state for run in runs}
    what = f"worker-b vanished while it claimed run {claimed}"
    session.saw(f"{what}: {len(runs)} runs of two owners ended", states == {"succeeded"})
    session.saw(f"{what}: longest standstill {longest_s:.0f} s", longest_s < STANDSTILL_S)
    wait_until(gone.is_healthy, START_S)


def refused_workers(service: Service) -> None:
    """A worker that would compute something else does not start, and says why."""
    other_key = {"SEAMARK_SEED_KEY_FILE": "/run/secrets/storage_secret_key"}
    elsewhere = {"SEAMARK_STORAGE_URL": "s3://seamark/elsewhere"}
    edit = f"echo '# changed' >> .{compose.ROOT}/sim/physics/plant.py"
    cases: dict[str, dict[str, Any]] = {
        "another secret": {"environment": other_key},
        "another storage": {"environment": elsewhere},
        "other code": {"prepare": edit},
    }
    for name, options in cases.items():
        refused = service.session.start("worker", ELSEWHERE, name="refused", **options)
        try:
            code = refused.wait(REFUSED_S)
        except subprocess.TimeoutExpired:
            code = 0
            refused.stop(signal.SIGKILL)
        del service.session.running["refused"]
        lines = refused.log.read_text().splitlines()
        refused.log.unlink()
        sentence = lines[-1] if lines else ""
        service.session.saw(f"a worker with {name} ends with {code}: {sentence}", code and sentence)


def rolling_restart(service: Service) -> None:
    """Web servers and workers are replaced one after the other, while runs and streams go on."""
    runs = service.submit(12, SHORT)
    with ThreadPoolExecutor(1) as thread:
        ended = thread.submit(service.finished, runs)
        unreachable = 0
        for name in ("web-1", "web-2", "worker-a", "worker-b"):
            container = service.session.running[name]
            container.stop()
            others = [
                client for client in service.clients if container.address not in client.server
            ]
            unreachable += sum(not _answers(client) for client in others)
            (_start_web if name.startswith("web") else _start_worker)(service.session, name)
        found = ended.result()
    wanted = evaluate_locally("currents-v1", SHORT, seed=SEED, controller="pi").digest
    session = service.session
    session.saw("during a rolling restart the other web server answers", unreachable == 0)
    session.saw(f"{len(runs)} runs and their streams survive it", found == {("succeeded", wanted)})


def storage_away(service: Service) -> None:
    """Runs go on while the object storage answers errors, or hangs, and end in their attempt."""
    wanted = evaluate_locally("currents-v1", LONG, seed=SEED, controller="pi").digest
    disturbances: Mapping[Behaviour, float] = {"answers errors": ERRORS_S, "hangs": HANG_S}
    for behaviour, seconds in disturbances.items():
        runs, slowest_s = _disturbed(service, behaviour, seconds)
        found = service.finished(runs)
        attempts = [service.attempts(run) for run in runs]
        what = f"a storage that {behaviour} for {seconds:g} s"
        saw = service.session.saw
        saw(f"{what}: attempts at {len(runs)} runs: {attempts}", set(attempts) == {1})
        saw(f"{what}: the same digest", found == {("succeeded", wanted)})
        saw(f"{what}: the slowest answer came after {slowest_s:.1f} s", slowest_s < PAGE_S)


def _disturbed(
    service: Service, behaviour: Behaviour, seconds: float
) -> tuple[list[ClientRun], float]:
    """Disturb the storage of runs that go on; return them, and how long answers took [s]."""
    runs = service.submit(4, LONG)
    wait_until(lambda: sum(run.refresh().progress > 0.02 for run in runs) >= 2)
    service.session.objects.behave(behaviour)
    slowest_s = _slowest_answer(service, runs[0].id, seconds)
    service.session.objects.behave("works")
    return runs, slowest_s


def _slowest_answer(service: Service, run_id: int, seconds: float) -> float:
    """Return how long the slowest page took [s], while pages of a run are read for a while."""
    until, slowest_s = time.monotonic() + seconds, 0.0
    while time.monotonic() < until:
        for client in service.clients:
            for path in (f"/api/v1/runs/{run_id}", f"/api/v1/runs/{run_id}/log", "/readyz"):
                asked_at = time.monotonic()
                headers = {"Authorization": f"Bearer {service.tokens[0]}"}
                httpx.get(
                    client.server + path,
                    headers=headers,
                    timeout=START_S,
                    verify=NO_CERTIFICATES,
                )
                slowest_s = max(slowest_s, time.monotonic() - asked_at)
        time.sleep(0.5)
    return slowest_s


def caretaker(service: Service) -> None:
    """The worker with the role of the owner starts as a plain user without a sandbox."""
    container = service.session.start("caretaker")
    wait_until(container.is_healthy, START_S)
    service.session.saw("the health check of caretaker passes", True)


def _answers(client: Client) -> bool:
    try:
        client.account()
    except ServerUnavailable:
        return False
    return True


def _start_worker(session: Session, name: str) -> None:
    machine = HERE if name == "worker-a" else ELSEWHERE
    environment = QUOTAS | {"SEAMARK_WORKERS": "1"}
    worker = session.start("worker", machine, name=name, environment=environment)
    wait_until(worker.is_healthy, START_S)


def _start_web(session: Session, name: str) -> None:
    number = {"web-1": 5, "web-2": 6}[name]  # a proxy finds a replica again by its name
    web = session.start("web", name=name, number=number, environment=QUOTAS)
    wait_until(lambda: _is_up(web.address), START_S)


def _is_up(address: str) -> bool:
    try:
        return httpx.get(f"http://{address}:8000/healthz", verify=NO_CERTIFICATES).is_success
    except httpx.TransportError:
        return False


def _start_all(session: Session) -> Service:
    for name in ("web-1", "web-2"):
        _start_web(session, name)
    service = Service(session)
    cancel_baselines(service.database)  # they would keep the workers busy for an hour
    for name in ("worker-a", "worker-b"):
        _start_worker(session, name)
        session.saw(f"the health check of {name} passes", True)
    wait_until(service.both_ready, START_S)
    for name in ("web-1", "web-2"):
        wait_until(session.running[name].is_healthy, START_S)
        session.saw(f"the health check of {name} passes", True)
    return service


PARTS = (
    *(equal_results, connected_programs, storage_away, killed_worker, vanished_machine),
    *(refused_workers, rolling_restart, caretaker),
)


def main() -> int:
    """Run the session; return the exit code."""
    with machine_session.started(STEPS) as session:
        service = _start_all(session)
        for part in PARTS:
            part(service)
    return 1 if session.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
