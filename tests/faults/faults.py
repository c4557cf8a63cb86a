"""The faults of the campaign. Each strikes a session in a workspace once and heals what it broke."""

import abc
import os
import random
import re
import resource
import shutil
import signal
import subprocess
from pathlib import Path

from small_session import cpu_seconds_of, wait_for

MIB = 1 << 20


def awaits(pid, number):
    """Whether the program itself takes the signal: it is blocked, and asked for by a thread."""
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("SigBlk:"):
            return bool(int(line.split()[1], 16) >> (number - 1) & 1)
    return False


def wait_until_used(process, cpu_seconds):
    wait_for(lambda: cpu_seconds_of(process.pid) >= cpu_seconds, process)


class Fault(abc.ABC):
    name = ""
    exit_codes = (1,)  # that the program may end with
    damaged = None     # file that the fault itself changed

    def why_not(self, campaign):
        """Why it cannot be tried on this machine; empty when it can."""
        return ""

    def variants(self, random_source, count):
        """What to try, `count` of them or as many as there are."""
        return [random_source.random() for _ in range(count)]

    @abc.abstractmethod
    def strike(self, campaign, workspace, variant):
        """How the struck run ended, or None when it ended before it could be struck."""

    def heal(self, campaign, workspace):
        pass


class CtrlC(Fault):
    name = "Ctrl-C"

    def strike(self, campaign, workspace, variant):
        process = campaign.session.start(workspace)
        # Until its libraries are loaded, the system ends it; there is nothing to lose then.
        wait_for(lambda: awaits(process.pid, signal.SIGINT), process)
        wait_until_used(process, variant * campaign.half_cpu_s)
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
        ended = campaign.session.end(process)
        return None if ended.exit_code == 0 else ended


class BusyWorkspace(Fault):
    name = "second session in one workspace"

    def strike(self, campaign, workspace, variant):
        first = campaign.session.start(workspace)
        held = wait_for((Path(workspace) / ".session.lock").exists, first)
        wait_until_used(first, variant * 0.4 * campaign.half_cpu_s)
        ended = campaign.session.run(workspace) if held else None
        if campaign.session.end(first).exit_code != 0:
            campaign.problem(f"{self.name}: the first session failed")
        return ended


class FileLimit(Fault):
    name = "files may not grow (RLIMIT_FSIZE)"

    def variants(self, random_source, count):
        return [10_000, 100, 1_000, 40_000, 200_000, 400_000][:count]

    def strike(self, campaign, workspace, variant):
        def limit():
            # Ignored, so that a write fails as on a full disk instead of ending the program.
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (variant, variant))
        return campaign.session.run(workspace, limit=limit)


class FullDisk(Fault):
    name = "disk gets full while it runs"

    def why_not(self, campaign):
        return "" if campaign.may_mount else "needs root, to mount a small disk"

    @staticmethod
    def mount(workspace, kept):
        shutil.move(workspace, kept)
        os.makedirs(workspace)
        subprocess.run(["mount", "-t", "tmpfs", "-o", "size=256m", "tmpfs", workspace], check=True)
        shutil.copytree(kept, workspace, dirs_exist_ok=True)
        shutil.rmtree(kept)

    def heal(self, campaign, workspace):
        kept = Path(str(workspace) + ".kept")
        (Path(workspace) / "ballast").unlink(missing_ok=True)
        shutil.copytree(workspace, kept)
        subprocess.run(["umount", workspace], check=True)
        shutil.rmtree(workspace)
        kept.rename(workspace)

    def strike(self, campaign, workspace, variant):
        self.mount(workspace, Path(str(workspace) + ".kept"))
        process = campaign.session.start(workspace)
        wait_until_used(process, variant * campaign.half_cpu_s)
        room = random.Random(variant).choice([0, 4096, 65536, MIB])
        with open(Path(workspace) / "ballast", "wb", buffering=0) as ballast:
            try:
                while True:
                    ballast.write(bytes(65536))
            except OSError:
                ballast.truncate(max(0, ballast.tell() - room))
        ended = campaign.session.end(process)
        return None if ended.exit_code == 0 else ended


class ReadOnlyWorkspace(Fault):
    name = "read-only workspace"

    def why_not(self, campaign):
        return "" if os.geteuid() != 0 or campaign.may_mount else "root writes everywhere"

    def variants(self, random_source, count):
        return [0]

    def strike(self, campaign, workspace, variant):
        if os.geteuid() == 0:
            subprocess.run(["mount", "--bind", workspace, workspace], check=True)
            subprocess.run(["mount", "-o", "remount,bind,ro", workspace], check=True)
        else:
            self.set_mode(workspace, 0o500)
        return campaign.session.run(workspace)

    def heal(self, campaign, workspace):
        if os.geteuid() == 0:
            subprocess.run(["umount", workspace], check=True)
        else:
            self.set_mode(workspace, 0o700)

    @staticmethod
    def set_mode(workspace, mode):
        for folder in [Path(workspace), *Path(workspace).rglob("*")]:
            if folder.is_dir():
                folder.chmod(mode)


class OutOfMemory(Fault):
    name = "memory limit (RLIMIT_AS)"

    def variants(self, random_source, count):
        return [500, 600, 400, 700, 300, 800, 900, 1000, 200, 100][:count]

    def strike(self, campaign, workspace, variant):
        def limit():
            resource.setrlimit(resource.RLIMIT_AS, (variant * MIB, variant * MIB))
        ended = campaign.session.run(workspace, limit=limit)
        return None if ended.exit_code == 0 else ended


class WrongClock(Fault):
    name = "clock jumps back, or is years off"
    exit_codes = (0, 1)

    def library(self):
        found = sorted(Path("/usr/lib").glob("*/faketime/libfaketimeMT.so.1"))
        return found[0] if found else None

    def why_not(self, campaign):
        return "" if self.library() else "needs Debian's package faketime"

    def variants(self, random_source, count):
        return [("+0", "-3d"), ("-20y", "-20y"), ("+20y", "+20y"), ("+2d", "-400d"),
                ("-3600", "+3600")][:count]

    def strike(self, campaign, workspace, variant):
        clock = campaign.work / "clock"
        clock.write_text(variant[0])
        process = campaign.session.start(workspace, environment={
            "LD_PRELOAD": str(self.library()), "FAKETIME_TIMESTAMP_FILE": str(clock),
            "FAKETIME_NO_CACHE": "1", "FAKETIME_DONT_FAKE_MONOTONIC": "1"})
        wait_until_used(process, 0.4 * campaign.half_cpu_s)
        clock.write_text(variant[1])
        return campaign.session.end(process)


class LostPhoto(Fault):
    name = "a photo disappears"
    exit_codes = (0, 1)

    def strike(self, campaign, workspace, variant):
        photos = sorted((Path(workspace) / "images").glob("*.jpg"))
        self.photo = photos[int(variant * len(photos))]
        self.content = self.photo.read_bytes()
        self.photo.unlink()
        return campaign.session.run(workspace)

    def heal(self, campaign, workspace):
        self.photo.write_bytes(self.content)


class DamagedFile(Fault):
    name = "a truncated file at resume"
    exit_codes = (0, 1)
    FILES = ["database.db", "iterations/000/sparse/images.bin", "iterations/000/stereo.bin", "state.json",
             "summary.json",
             "seen.json", "iterations/000/path.json", "iterations/000/sparse/points3D.bin",
             "iterations/000/sparse/cameras.bin", "iterations/000/frame.json", "session.ini",
             "iterations/000/sparse_state.json", "iterations/000/surface.ply",
             "iterations/000/views.json", "truth/poses.txt", "iterations/000/timing.json"]

    def variants(self, random_source, count):
        return [(name, share) for share in (0.5, 0) for name in self.FILES][:count]

    def strike(self, campaign, workspace, variant):
        name, share = variant
        self.damaged = name
        self.path = Path(workspace) / name
        self.content = self.path.read_bytes()
        self.path.write_bytes(self.content[:int(share * len(self.content))])
        ended = campaign.session.run(workspace)
        # What is not needed to go on may be damaged, but what is needed has to be named.
        if ended.exit_code != 0 and self.path.name not in ended.said:
            campaign.problem(f"{name}: not named by: {ended.said}")
        return ended

    def heal(self, campaign, workspace):
        if not re.fullmatch(r"(state|summary|seen)\.json|session\.ini|database\.db",
                            self.path.name) or campaign.ended.exit_code != 0:
            self.path.write_bytes(self.content)


ALL = [CtrlC(), FullDisk(), FileLimit(), ReadOnlyWorkspace(), OutOfMemory(), DamagedFile(),
       LostPhoto(), WrongClock(), BusyWorkspace()]
