"""The command line as tests run it, inside this process or as one of its own, and a room to run it on."""

from __future__ import annotations

import io
import signal
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path

from lelight.cli.main import main

#: A name that is an attack on paths, shells, XML and quoting at once.
NASTY = 'a/b: "üλ" <x>'

#: A 2 m cube: glossy floor, grey walls and ceiling, a panel that shines down, a point lamp.
ROOM_OBJ = """mtllib room.mtl
v 0 0 0
v 2 0 0
v 2 2 0
v 0 2 0
v 0 0 2
v 2 0 2
v 2 2 2
v 0 2 2
v 0.7 0.7 1.9
v 1.3 0.7 1.9
v 1.3 1.3 1.9
v 0.7 1.3 1.9
usemtl floor
f 1 2 3 4
usemtl wall
f 8 7 6 5
f 1 5 6 2
f 2 6 7 3
f 3 7 8 4
f 4 8 5 1
usemtl panel
f 12 11 10 9
"""
ROOM_MTL = """newmtl floor
Kd 0.3 0.3 0.3
Ks 0.2 0.2 0.2
Ns 12
newmtl wall
Kd 0.6 0.6 0.6
newmtl panel
Kd 0.5 0.5 0.5
Ke 4000 4000 4000
"""
ROOM_TOML = """[[luminaires]]
name = "lamp"
position = [0.5, 0.5, 1.5]
intensity = 100

[[observers]]
name = 'a/b: "üλ" <x>'
position = [0.3, 1.0, 1.2]
direction = [1, 0, 0]

[[planes]]
name = "work plane"
origin = [0.5, 0.5, 0.75]
u = [1, 0, 0]
v = [0, 1, 0]
target = { mean_illuminance = 100, uniformity = 0.6, ugr = 19 }
"""

#: What makes a run on the room short.
QUICK = ("--preset", "draft", "--edge", "0.5")


def write_room(
    folder: Path, *, obj: str = ROOM_OBJ, mtl: str | None = ROOM_MTL, toml: str | None = ROOM_TOML
) -> Path:
    """Write the room, or something like it; returns the OBJ."""
    folder.mkdir(parents=True, exist_ok=True)
    for suffix, text in ((".obj", obj), (".mtl", mtl), (".toml", toml)):
        if text is not None:
            (folder / f"room{suffix}").write_text(text, encoding="utf-8")
    return folder / "room.obj"


@dataclass(frozen=True)
class Outcome:
    """What a command left behind: exit status and both streams."""

    status: int
    stdout: str
    stderr: str


def lelight(*arguments: str | Path) -> Outcome:
    """Run the command in this process, as the console script does."""
    stdout, stderr = io.StringIO(), io.StringIO()
    handler = signal.getsignal(signal.SIGINT)
    try:
        with redirect_stdout(stdout), redirect_stderr(stderr):
            main([str(argument) for argument in arguments])
    except SystemExit as leaving:
        return Outcome(int(leaving.code or 0), stdout.getvalue(), stderr.getvalue())
    finally:
        signal.signal(signal.SIGINT, handler)
    raise AssertionError("main() ends by leaving")


def process(*arguments: str | Path) -> subprocess.Popen[str]:
    """Start the command as a process of its own."""
    return subprocess.Popen(
        [sys.executable, "-c", "from lelight.cli.main import main; main()", *map(str, arguments)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        encoding="utf-8",
        cwd=Path(__file__).parents[1],
    )
