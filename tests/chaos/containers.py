"""Containers without an engine: a service of compose.yaml in Linux namespaces of its own.

Each has its own processes, host name, network address and files: a copy-on-write view of this host,
read-only but for what the Compose file names, with its secrets and without the files of the others.
Two machines are two bridges. All of it ends with the process that made it, which must be root in a
network and a mount namespace of its own (`./run machines`).
"""

import os
import pwd
import re
import signal
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tests.services import compose

CACHE = "/var/cache/seamark-code"
CONTROLLERS = re.compile(r"\b(memory|pids|cpuacct|cpu)\b")
ENTRY = """
set -e
for group in $GROUPS_OF_BOXES; do echo 0 > "$group/cgroup.procs"; done
mount --make-rprivate /
mount -t tmpfs tmpfs "$FOLDER"
cd "$FOLDER"
mkdir up work root code code-work source source-work
mount -t overlay overlay -o "lowerdir=/,upperdir=up,workdir=work" root
cd root
hostname "$NAME"
mount -t proc proc proc
mount --rbind /sys sys
mount --rbind /dev dev
mount -t tmpfs tmpfs dev/shm
place() { # PATH: make a folder inside, and print where it is: /var/run may be a link to /run
    chroot . mkdir -p "$1"
    printf '.%s' "$(chroot . realpath "$1")"
}
for each in $TMPFS; do mount -t tmpfs -o "${each#*:}" tmpfs "$(place "${each%%:*}")"; done
mkdir -p ".$CHECKOUT" ".$CACHE" run/secrets old
copy() { # LOWER NAME TARGET
    mount -t overlay overlay -o "lowerdir=$1,upperdir=$FOLDER/$2,workdir=$FOLDER/$2-work" ".$3"
}
copy "$CHECKOUT" source "$CHECKOUT"
copy "$CODE" code "$CACHE"
find ".$CACHE" -type d -exec chown "0:$GROUP" {} + -exec chmod 0775 {} +
for volume in $VOLUMES; do
    mkdir -p "$FOLDER/volumes$volume"
    mount --bind "$FOLDER/volumes$volume" "$(place "$volume")"
    chown "0:$GROUP" ".$volume" && chmod 0770 ".$volume"
done
for secret in $SECRETS; do cp "$SECRETS_FROM/$secret" run/secrets/; done
chmod 0755 run run/secrets
cat "$HOSTS" > etc/hosts
eval "$PREPARE"
mount -o remount,ro ".$CHECKOUT"
mount -o remount,ro .
pivot_root . old
umount -l old
cd /
exec "$@"
"""


@dataclass(frozen=True, slots=True)
class Machine:
    """A network of its own, from which the other one can be reached."""

    name: str
    subnet: str

    def create(self) -> None:
        """Create its bridge."""
        ip("link", "add", self.name, "type", "bridge")
        ip("addr", "add", f"{self.subnet}.1/24", "dev", self.name)
        ip("link", "set", self.name, "up")


@dataclass(frozen=True, slots=True)
class Host:
    """What the containers of one session have in common."""

    folder: Path  # for what is written
    secrets: Path
    code: Path  # compiled code, read only
    variables: Mapping[str, str] = field(default_factory=dict)  # of the Compose files

    @classmethod
    def create(cls, folder: Path, code: Path, machines: Sequence[Machine]) -> "Host":
        """Draw the secrets, and connect the machines."""
        script = compose.ROOT / "deploy" / "secrets.sh"
        subprocess.run(["sh", str(script)], cwd=folder, check=True)
        Path("/run/netns").mkdir(exist_ok=True)
        subprocess.run(["mount", "-t", "tmpfs", "tmpfs", "/run/netns"], check=True)
        ip("link", "set", "lo", "up")
        Path("/proc/sys/net/ipv4/ip_forward").write_text("1")
        for machine in machines:
            machine.create()
        return cls(folder, folder / "secrets", code)

    def names(self, addresses: Mapping[str, str]) -> None:
        """Let all containers know the names of the stores."""
        lines = ["127.0.0.1 localhost", *(f"{at} {name}" for name, at in addresses.items())]
        (self.folder / "hosts").write_text("\n".join(lines) + "\n")


class Container:
    """One container; it runs until it ends or is ended."""

    def __init__(  # the words of the Compose file, and where they are changed
        self,
        host: Host,
        machine: Machine,
        number: int,
        service: Mapping[str, Any],
        *,
        name: str,
        command: Sequence[str] = (),
        environment: Mapping[str, str] | None = None,
        prepare: str = "",
    ) -> None:
        self.name, self.address = name, f"{machine.subnet}.{number}"
        self.log = host.folder / f"{name}.log"
        self._service, self._host = service, host
        self._given = compose.environment(service.get("environment", {}), host.variables)
        self._given |= dict(environment or {})
        self._groups = _control_groups(name) if "cap_add" in service else []
        _connect(name, machine, self.address)
        words = list(command) or compose.command(service["command"], host.variables)
        enter = ["nsenter", f"--net=/run/netns/{name}", "unshare", "--mount", "--pid", "--fork"]
        enter += ["--uts", "--ipc", "--kill-child", "sh", "-c", ENTRY, "entry"]
        with self.log.open("ab") as log:
            self.process = subprocess.Popen(
                [*enter, *self._as_user(), *words],
                env=os.environ | self._mounts(prepare),
                stdout=log,
                stderr=log,
                stdin=subprocess.DEVNULL,
            )

    def _mounts(self, prepare: str) -> dict[str, str]:
        folder = self._host.folder / "containers" / self.name
        folder.mkdir(parents=True, exist_ok=True)
        tmpfs = [each if ":" in each else f"{each}:mode=1777" for each in self._tmpfs()]
        volumes = [each.partition(":")[2] or each for each in self._service.get("volumes", [])]
        return {
            "GROUPS_OF_BOXES": " ".join(map(str, self._groups)),
            "FOLDER": str(folder),
            "NAME": self.name,
            "TMPFS": " ".join(tmpfs),
            "CHECKOUT": str(compose.ROOT),
            "CACHE": CACHE,
            "CODE": str(self._host.code),
            "GROUP": str(self._user()[1]),
            "VOLUMES": " ".join(volume for volume in volumes if volume != CACHE),
            "SECRETS": " ".join(self._service.get("secrets", [])),
            "SECRETS_FROM": str(self._host.secrets),
            "HOSTS": str(self._host.folder / "hosts"),
            "PREPARE": prepare or ":",
        }

    def _tmpfs(self) -> list[str]:
        return [*self._service.get("tmpfs", []), *({"/tmp"} - self._paths())]

    def _paths(self) -> set[str]:
        return {each.partition(":")[0] for each in self._service.get("tmpfs", [])}

    def _user(self) -> tuple[int, int]:
        """Return the ids of the user; that of a foreign image is one of this host."""
        user, _, group = str(self._service["user"]).partition(":")
        if user.isdigit():
            return int(user), int(group)
        other = pwd.getpwnam("daemon")
        return other.pw_uid, other.pw_gid

    def _as_user(self) -> list[str]:
        """Return the words that give a command its user, rights and environment."""
        uid, gid = self._user()
        added = "".join(f",+{name.lower()}" for name in self._service.get("cap_add", ()))
        words = ["setpriv", f"--bounding-set=-all{added}", "--inh-caps=-all", "--no-new-privs"]
        words += ["--clear-groups", f"--regid={gid}", f"--reuid={uid}"]
        path = f"{Path(sys.executable).parent}:/usr/local/bin:/usr/bin:/bin:/usr/sbin:/sbin"
        image = {
            "PATH": path,
            "HOME": "/nonexistent",
            "SEAMARK_DATA": "/data",
            "NUMBA_CACHE_DIR": CACHE,
        }
        pairs = [f"{name}={text}" for name, text in (image | self._given).items()]
        return [*words, "env", "-i", *pairs]

    @property
    def pid(self) -> int | None:
        """The first process inside, as seen from outside."""
        try:
            children = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children")
            return next(map(int, children.read_text().split()), None)
        except OSError:
            return None

    def execute(self, words: Sequence[str]) -> "subprocess.CompletedProcess[str]":
        """Run a command in the container, as `docker compose exec` does."""
        return subprocess.run(self._inside(words), capture_output=True, text=True, check=False)

    def begin(self, words: Sequence[str]) -> "subprocess.Popen[str]":
        """Start a command in the container whose output is read."""
        return subprocess.Popen(self._inside(words), stdout=subprocess.PIPE, text=True)

    def _inside(self, words: Sequence[str]) -> list[str]:
        inside = ["nsenter", f"--target={self.pid}", "--mount", "--pid", "--net", "--uts", "--ipc"]
        return [*inside, *self._as_user(), *words]

    def connect(self, *, up: bool) -> None:
        """Connect the container to its machine, or cut it off without a word to anybody."""
        ip("link", "set", _outside(self.address), "up" if up else "down")

    def is_healthy(self) -> bool:
        """Carry out the health check of the Compose file."""
        kind, *words = compose.command(self._service["healthcheck"]["test"], self._host.variables)
        command = ["sh", "-c", *words] if kind == "CMD-SHELL" else words
        return self.pid is not None and self.execute(command).returncode == 0

    def stop(self, number: signal.Signals = signal.SIGTERM, within_s: float = 60.0) -> None:
        """Send a signal to the first process, and wait for the end."""
        if (pid := self.pid) is not None:
            os.kill(pid, number)
        try:
            self.process.wait(within_s)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self._leave()

    def wait(self, within_s: float) -> int:
        """Wait until it ends by itself; return the exit code."""
        code = self.process.wait(within_s)
        self._leave()
        return code

    def _leave(self) -> None:
        subprocess.run(["ip", "netns", "delete", self.name], check=False, capture_output=True)
        deadline = time.monotonic() + 10.0
        for group in self._groups:
            while group.exists() and time.monotonic() < deadline:
                for below in sorted(group.rglob("*/"), reverse=True):
                    _remove(below)
                _remove(group)
                time.sleep(0.05)  # its processes end one after the other


def ip(*words: str) -> None:
    """Configure the network."""
    subprocess.run(["ip", *words], check=True)


def _outside(address: str) -> str:
    """Return the name of the interface that leads to a container."""
    return f"v{address.replace('.', '')}"


def _connect(name: str, machine: Machine, address: str) -> None:
    """Make the network of a container: one interface to the bridge of its machine."""
    ip("netns", "add", name)
    outside = _outside(address)
    ip("link", "add", outside, "type", "veth", "peer", "name", "eth0", "netns", name)
    ip("link", "set", outside, "master", machine.name, "up")
    ip("-n", name, "addr", "add", f"{address}/24", "dev", "eth0")
    ip("-n", name, "link", "set", "eth0", "up")
    ip("-n", name, "link", "set", "lo", "up")
    ip("-n", name, "route", "add", "default", "via", f"{machine.subnet}.1")


def _control_groups(name: str) -> list[Path]:
    """Create the groups of a container, which it may divide among boxes; none if not permitted."""
    own = {
        controllers: path
        for _, controllers, path in (
            line.split(":", 2) for line in Path("/proc/self/cgroup").read_text().splitlines()
        )
    }
    groups = []
    for line in Path("/proc/self/mounts").read_text().splitlines():
        _, point, kind, options, *_ = line.split()
        named = next(
            (key for key in own if key and set(key.split(",")) <= set(options.split(","))), ""
        )
        wanted = kind == "cgroup2" or (kind == "cgroup" and CONTROLLERS.search(named))
        if wanted:
            group = Path(point) / own[named if kind == "cgroup" else ""].lstrip("/") / f"sea-{name}"
            group.mkdir(exist_ok=True)
            groups.append(group)
    return groups


def _remove(folder: Path) -> None:
    try:
        folder.rmdir()
    except OSError:
        return
