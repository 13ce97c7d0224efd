"""Kill runs at random moments, resume them, compare bytes: ``python tests/kill_and_resume.py [KILLS] [SEED]``.

Three scenes are computed undisturbed once. Then runs of them, with 1, 2 or 4 threads, are killed by SIGKILL at random
moments from their first to their last, some of them again after they were resumed, and resumed to the end. Of every
one all point arrays of ``field.vtp`` have to be those of the undisturbed run. What a kill has cost is how long it
had run less what it goes on after.
"""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lelight.writing.vtpreading import read_polydata

SCENES = Path(__file__).parents[1] / "scenes"
#: Scenes and what makes a run of each take half a minute or so.
RUNS = {
    "office": ("--target", "4%"),
    "corridor": ("--target", "4%"),
    "cornell": ("--target", "2%"),
}
#: Share of resumed runs that are killed once more.
AGAIN = 0.3


@dataclass(frozen=True)
class Ended:
    """How one part of a run ended: exit status, seconds, and the seconds of earlier work that it went on after."""

    status: int
    seconds: float
    taken_over: float


def run(scene: str, out: Path, threads: int, *, kill_after: float | None = None) -> Ended:
    """Compute a scene, or go on with it, until it ends or is killed."""
    command = [
        sys.executable, "-c", "from lelight.cli.main import main; main()", "calc", str(SCENES / f"{scene}.toml"),
        "-o", str(out), "--threads", str(threads), "--resume", *RUNS[scene],
    ]  # fmt: skip
    begun = time.perf_counter()
    running = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, cwd=Path(__file__).parents[1])
    try:
        stderr = running.communicate(timeout=kill_after)[1]
    except subprocess.TimeoutExpired:
        os.kill(running.pid, signal.SIGKILL)
        stderr = running.communicate()[1]
    told = re.search(r"going on after (\d+) s of work", stderr)
    return Ended(running.returncode, time.perf_counter() - begun, float(told[1]) if told else 0.0)


def arrays(out: Path) -> dict[str, bytes]:
    """Every point array of a field, and the points."""
    field = read_polydata(out / "field.vtp")
    return {
        "points": field.points.tobytes(),
        **{name: array.tobytes() for name, array in field.point_arrays.items()},
    }


def main(kills: int, seed: int) -> int:
    """Kill and resume; returns how many runs came out otherwise."""
    rng = np.random.default_rng(seed)
    misses = 0
    with tempfile.TemporaryDirectory() as folder:
        expected, length = {}, {}
        for scene in RUNS:
            length[scene] = run(scene, Path(folder) / scene, 2).seconds
            expected[scene] = arrays(Path(folder) / scene)
            print(f"{scene}: undisturbed {length[scene]:.1f} s, {len(expected[scene])} arrays", flush=True)
        done = tries = 0
        while done < kills:
            scene = list(RUNS)[tries % len(RUNS)]
            out = Path(folder) / f"{scene} {tries}"
            tries += 1
            moments, worked = [], 0.0
            while done < kills and (not moments or rng.random() < AGAIN):
                moments.append(rng.uniform(0.0, length[scene]))
                part = run(scene, out, int(rng.choice([1, 2, 4])), kill_after=moments[-1])
                if part.status != -signal.SIGKILL:
                    moments.pop()
                    break
                done += 1
                worked = max(worked, part.taken_over + part.seconds)
            if part.status == 0:
                # It had ended by itself, as runs do that are a little faster than the undisturbed one.
                end, lost = part, "was done by then"
            else:
                end = run(scene, out, int(rng.choice([1, 2, 4])))
                lost = f"lost {worked - end.taken_over:.1f} s"
            found = arrays(out) if end.status == 0 else {}
            wrong = [name for name in expected[scene] if found.get(name) != expected[scene][name]]
            left = (out / "checkpoint").exists()
            misses += bool(wrong or left)
            print(
                f"{scene}: killed after {', '.join(f'{moment:.1f}' for moment in moments)} s, "
                f"{lost}, {'differs: ' + str(wrong) if wrong else 'same'}"
                f"{', checkpoint left' if left else ''}",
                flush=True,
            )
    print(f"{done} kills, {misses} runs that came out otherwise")
    return misses


if __name__ == "__main__":
    given = [int(argument) for argument in sys.argv[1:]]
    sys.exit(main(*given, *(20, 0)[len(given) :]) > 0)
