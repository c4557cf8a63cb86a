"""A small simulated session that can be run, hit and compared: what the fault campaign works on."""

import collections
import contextlib
import hashlib
import json
import os
import shutil
import sqlite3
import subprocess
import time
from pathlib import Path

ITERATIONS = 2
# 14 photos, then 4 more, of 400 x 230 px: the whole loop in about 15 CPU seconds.
OPTIONS = """
    --scene boxes --Session.vehicle embedded --Session.pictures 0
    --InitialFlight.num_views 14 --NextBestView.num_views 4
    --Simulation.width 400 --Simulation.height 230 --Simulation.focal_px 260
    --SparseUpdate.max_num_features 1000 --Renderer.samples_per_pixel 1
    --SurfaceReconstructor.depth 5
    --ModelEvaluator.sample_spacing_m 0.3 --ModelEvaluator.icp_samples 500
    --ModelEvaluator.icp_iterations 5
""".split() + ["--Session.max_iterations", str(ITERATIONS)]

# Differ from run to run by design: they hold times, or are made anew from the rest.
# The database's log is compared as a part of its rows.
NOT_COMPARED = ("timing.json", ".session.lock", "database.db-wal", "database.db-shm")
FOLDERS_NOT_COMPARED = ("logs", "report")
KEYS_NOT_COMPARED = ("wall_s", "stage_wall_s")

Ended = collections.namedtuple("Ended", "exit_code said stderr")


class Session:
    """Starts the program in a workspace, and hits it."""

    def __init__(self, program, work):
        self.program = str(Path(program).resolve())
        self.work = Path(work)

    def start(self, workspace, more=(), environment=None, limit=None, wrapper=()):
        """`limit`: called in the child before the program starts."""
        command = [*wrapper, self.program, "active_capture", "--workspace_path", str(workspace),
                   *OPTIONS, *more]
        return subprocess.Popen(
            command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
            env={**os.environ, **(environment or {})}, preexec_fn=limit)

    @staticmethod
    def end(process, timeout=600):
        """Waits; a program that hangs is an error of its own."""
        try:
            stderr = process.communicate(timeout=timeout)[1]
        except subprocess.TimeoutExpired:
            process.kill()
            stderr = process.communicate()[1] + "\nhangs"
        lines = [line for line in stderr.splitlines() if line.strip()]
        return Ended(process.returncode, lines[-1] if lines else "", stderr)

    def run(self, workspace, **how):
        return self.end(self.start(workspace, **how))

    def run_and_signal(self, workspace, cpu_seconds, number):
        """None when the session had ended before it had used so many."""
        process = self.start(workspace)
        if wait_for(lambda: cpu_seconds_of(process.pid) >= cpu_seconds, process):
            process.send_signal(number)
        ended = self.end(process)
        return None if ended.exit_code == 0 else ended


def cpu_seconds_of(pid):
    """Used by a process, its children that ended, and those that run: moments by this clock do not
    depend on what else the machine does."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
        children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    except (OSError, IndexError):
        return 0.0
    own = sum(int(field) for field in fields[11:15]) / os.sysconf("SC_CLK_TCK")
    return own + sum(cpu_seconds_of(child) for child in children)


def rows_of(database):
    """All rows of an SQLite database, whatever the order of its pages."""
    with contextlib.closing(sqlite3.connect(f"file:{database}?mode=ro", uri=True)) as connection:
        names = [row[0] for row in connection.execute(
            "SELECT name FROM sqlite_master WHERE type = 'table' ORDER BY name")]
        return [(name, sorted(map(repr, connection.execute(f'SELECT * FROM "{name}"'))))
                for name in names]


def without_times(value):
    if isinstance(value, dict):
        return {key: without_times(item) for key, item in value.items()
                if key not in KEYS_NOT_COMPARED}
    return [without_times(item) for item in value] if isinstance(value, list) else value


def content_of(path):
    """What has to be the same in two runs."""
    if path.name == "database.db":
        return repr(rows_of(path)).encode()
    if path.name == "seen.json":  # sizes and times of files
        seen = json.loads(path.read_text())
        return repr((sorted(seen["photos"]), sorted(seen["options"].items()))).encode()
    if path.name == "summary.json":
        return repr(without_times(json.loads(path.read_text()))).encode()
    return path.read_bytes()


def fingerprint(workspace):
    """{relative path: hash} of everything that a session keeps."""
    hashes = {}
    for path in sorted(Path(workspace).rglob("*")):
        name = path.relative_to(workspace)
        if not path.is_file() or path.name in NOT_COMPARED or name.parts[0] in FOLDERS_NOT_COMPARED:
            continue
        try:
            hashes[str(name)] = hashlib.sha256(content_of(path)).hexdigest()
        except (sqlite3.Error, ValueError, KeyError):
            hashes[str(name)] = "damaged"
    return hashes


def differences(expected, workspace):
    """Files that are not as expected, leftovers among them."""
    found = fingerprint(workspace)
    return sorted(name for name in expected.keys() | found.keys()
                  if expected.get(name) != found.get(name))


def lost_files(expected, workspace):
    """Files of finished iterations that are gone or changed: read before anything is mended."""
    state = Path(workspace) / "state.json"
    if not state.exists():
        return []
    try:
        done = json.loads(state.read_text())["iterations_done"]
    except ValueError:
        return ["state.json"]
    folders = tuple(f"iterations/{i:03d}/" for i in range(done))
    found = fingerprint(workspace)
    return sorted(name for name, value in expected.items()
                  if name.startswith(folders) and found.get(name) != value)


def fresh_copy(source, target):
    shutil.rmtree(target, ignore_errors=True)
    if source is not None:
        shutil.copytree(source, target)
    return target


def wait_for(condition, process, seconds=600):
    """Until `condition()`; False when the process ended or it took too long."""
    stop = time.monotonic() + seconds
    while time.monotonic() < stop and process.poll() is None:
        if condition():
            return True
        time.sleep(0.005)
    return False
