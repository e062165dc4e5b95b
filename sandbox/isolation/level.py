"""How well this host isolates a program: levels, found by trying and not by version numbers."""

from dataclasses import dataclass
from enum import IntEnum


class Level(IntEnum):
    """What stands between a program and the host. WEAK (Landlock alone) is never given out yet."""

    NONE = 0  # nothing: uploads are refused
    WEAK = 1  # no namespaces
    MEDIUM = 2  # namespaces, seccomp, limits per process
    STRONG = 3  # also limits for the whole box (cgroups) and a uid that owns nothing else


@dataclass(frozen=True, slots=True)
class Finding:
    """One probe: what was tried, whether it was stopped, why not, and how to mend it."""

    name: str
    ok: bool
    why: str = ""
    remedy: str = ""


@dataclass(frozen=True, slots=True)
class Isolation:
    """The level that this host reaches, with the findings that decided it."""

    level: Level
    findings: tuple[Finding, ...] = ()

    def sentence(self) -> str:
        """Return one line for a status page: the level and what is missing for the next one."""
        missing = "; ".join(f"{f.name}: {f.why}" for f in self.findings if not f.ok)
        return f"isolation {self.level.name.lower()}" + (f" ({missing})" if missing else "")
