"""`./run release`: check that a version can be released, then build everything that is published.

`./run release --check` only says what is missing, `./run release --sbom FILE` only writes the
software bill of materials: every package of uv.lock that a service installs, with its hashes.
"""

import argparse
import hashlib
import os
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
OF_SERVICE = (
    *("--frozen", "--no-dev", "--extra", "server", "--extra", "pybullet"),
    "--no-emit-workspace",
)


def version() -> str:
    """Return the version, which stands in pyproject.toml alone."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    return str(project["version"])


def missing(release: str) -> Iterator[str]:
    """Yield what has to be done before a release, in sentences."""
    changes = (ROOT / "CHANGELOG.md").read_text("utf-8")
    if not re.search(rf"^## {re.escape(release)}( |$)", changes, re.MULTILINE):
        yield f"CHANGELOG.md has no section {release}: rename Unreleased and add the date."
    cited = (ROOT / "CITATION.cff").read_text("utf-8")
    if f"\nversion: {release}\n" not in cited:
        yield f"CITATION.cff has another version than {release}."
    if not os.environ.get("SEAMARK_SOURCE_URL"):
        yield (
            "SEAMARK_SOURCE_URL is not set: the address of the source, to which the links and "
            "pictures of the README lead on the page of a registry."
        )
    if _git("status", "--porcelain"):
        yield "The tree has changes that are not committed."
    if _git("tag", "--list", f"v{release}"):
        yield f"The tag v{release} exists: choose the next version in pyproject.toml."


def _git(*words: str) -> str:
    answer = subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=True)
    return answer.stdout.strip()


def write_sbom(path: Path) -> None:
    """Write the software bill of materials in CycloneDX 1.5."""
    words = [_uv(), "export", *OF_SERVICE, "--format", "cyclonedx1.5", "--output-file", str(path)]
    subprocess.run(
        [*words, "--preview-features", "sbom-export", "--quiet"],
        cwd=ROOT,
        stdout=subprocess.DEVNULL,
        check=True,
    )


def _uv() -> str:
    """Return the uv that `./run` has found or installed."""
    uv = shutil.which("uv", path=f"{ROOT / '.boot' / 'bin'}:{os.environ.get('PATH', '')}")
    if uv is None:
        sys.exit("uv is missing: ./run release installs it.")
    return uv


def build(release: str) -> None:
    """Write wheels, source archive, bill of materials and checksums into dist/."""
    # Here: it builds 39 parsers, for which --check and --sbom would wait a second.
    from cyclonedx.schema import SchemaVersion  # noqa: PLC0415
    from cyclonedx.validation.json import JsonStrictValidator  # noqa: PLC0415

    dist = ROOT / "dist"
    shutil.rmtree(dist, ignore_errors=True)
    subprocess.run([_uv(), "build", "--quiet", "--out-dir", str(dist)], cwd=ROOT, check=True)
    client = ("--package", "seamark-client", "--wheel")  # its sources are in the archive of seamark
    command = [_uv(), "build", "--quiet", *client, "--out-dir", str(dist)]
    subprocess.run(command, cwd=ROOT, check=True)
    bill = dist / f"seamark-{release}.cdx.json"
    write_sbom(bill)
    error = JsonStrictValidator(SchemaVersion.V1_5).validate_str(bill.read_text("utf-8"))
    if error is not None:  # after most of a minute
        raise ValueError(f"{bill} is no bill of materials: {error}")
    files = sorted(path for path in dist.iterdir() if path.name.startswith("seamark"))
    sums = [f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n" for path in files]
    (dist / "SHA256SUMS").write_text("".join(sums))
    for path in files:
        print(f"{path.relative_to(ROOT)}  {path.stat().st_size / 2**20:.1f} MiB")
    print("Then, where an engine is:")
    for target in ("web", "worker"):
        label = f"--build-arg VERSION={release} --tag seamark-{target}:{release}"
        print(f"  docker build --target {target} {label} .")
    print(f"  git tag -a v{release} -m v{release}")


def main() -> int:
    """Run the command; return the exit code."""
    parser = argparse.ArgumentParser(prog="./run release", description=__doc__)
    parser.add_argument("--check", action="store_true", help="say what is missing, and end")
    parser.add_argument("--sbom", type=Path, metavar="FILE", help="write only this, and end")
    options = parser.parse_args()
    if options.sbom:
        write_sbom(options.sbom)
        return 0
    lacking = list(missing(version()))
    for sentence in lacking:
        print(sentence, file=sys.stderr)
    if lacking or options.check:
        return 1 if lacking else 0
    build(version())
    return 0


if __name__ == "__main__":
    sys.exit(main())
