"""What probing a host found out, with the isolation level that follows from it."""

from dataclasses import dataclass

from seamark.sandbox.isolation.level import IsolationLevel


@dataclass(frozen=True, slots=True)
class Finding:
    """One probe: what was tried, whether the sandbox held, why not, and how to fix it."""

    name: str
    ok: bool
    why: str = ""
    remedy: str = ""


@dataclass(frozen=True, slots=True)
class Component:
    """An interpreter, a compiler or a library that programs find in a box."""

    kind: str  # "interpreter", "compiler" or "library"
    name: str
    version: str


@dataclass(frozen=True, slots=True)
class IsolationReport:
    """The isolation level that this host reaches, with the findings that decided it."""

    level: IsolationLevel
    findings: tuple[Finding, ...] = ()

    def sentence(self) -> str:
        """Return one line for a status page: the level and what is missing for the next one."""
        missing = "; ".join(f"{f.name}: {f.why}" for f in self.findings if not f.ok)
        return f"isolation {self.level.name.lower()}" + (f" ({missing})" if missing else "")
