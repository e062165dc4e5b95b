"""Has files of others change hands: a later `chown` followed a link (Judge0)."""

import os


def given(path, mode):
    """A set-uid bit is of no use where the mount ignores it: look whether it stays."""
    os.chmod(path, mode)
    if os.statvfs(path).f_flag & os.ST_NOSUID:
        raise PermissionError("the mount takes no set-uid bit")


class Controller:
    def __init__(self, config):
        open("/tmp/mine", "w").close()
        attempts = {
            "a file given away": lambda: os.chown("/tmp/mine", 0, 0),
            "a file of root": lambda: os.chown("/usr/lib/x86_64-linux-gnu", 1000, 1000),
            "the root": lambda: os.chown("/", os.getuid(), os.getgid()),
            "a set-uid file": lambda: given("/tmp/mine", 0o4777),
            "a hard link": lambda: os.link(os.__file__, "/tmp/link"),
            "a link": lambda: os.symlink("/etc/passwd", "/tmp/link"),
            "another place": lambda: os.rename("/lib", "/tmp/lib"),
        }
        for name, attempt in attempts.items():
            try:
                attempt()
            except OSError as error:
                print("held:", name, error)
            else:
                print("GOT", name)

    def step(self, observation):
        return [0.0, 0.0, 0.0, 0.0]
