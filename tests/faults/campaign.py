#!/usr/bin/env python3
"""The fault campaign: a small simulated session is killed, starved and damaged, and goes on.

    tests/faults/campaign.py --program build/release/bin/colmap_ext [--kills 100] [--seed 1]

After each fault the files of finished iterations must be what they were ("lost" counts those that
are not), the program must have ended with exit code 1 and one line that says why, and after the
fault is taken away the same command must come to the same result as an undisturbed session: every
file equal, the database row by row; only times differ (small_session.py, NOT_COMPARED). Prints a
Markdown table; exit code 1 when anything was lost, differs, or was not said clearly.
"""

import argparse
import collections
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import faults
from small_session import Session, differences, fingerprint, fresh_copy, lost_files

KILLS_A_SESSION = 4
SHORT_KILLS = 2


class Result:
    """One row of the table."""

    def __init__(self, name):
        self.name = name
        self.struck = self.lost = self.sessions = self.same = 0
        self.said = collections.Counter()

    def row(self):
        said = "; ".join(f"{text} ({count})" if count > 1 else text
                         for text, count in self.said.most_common())
        same = f"{self.same} of {self.sessions}"
        return f"| {self.name} | {self.struck} | {said or '–'} | {self.lost} | {same} |"


class Campaign:
    def __init__(self, program, work, seed):
        self.work = Path(work)
        self.session = Session(program, work)
        self.random = random.Random(seed)
        self.problems = []
        self.results = {}
        self.ended = None
        self.may_mount = self.can_mount()

    def can_mount(self):
        probe = self.work / "probe"
        probe.mkdir()
        tried = subprocess.run(["mount", "-t", "tmpfs", "tmpfs", probe], stderr=subprocess.DEVNULL)
        if tried.returncode == 0:
            subprocess.run(["umount", probe], check=True)
        return tried.returncode == 0

    def problem(self, text):
        print(f"PROBLEM: {text}", file=sys.stderr, flush=True)
        self.problems.append(text)

    def result(self, name):
        return self.results.setdefault(name, Result(name))

    def run_undisturbed(self):
        """The truth: a whole session, and a copy of it after its first iteration."""
        whole, self.half = self.work / "whole", self.work / "half"
        hook = f'[ "$COLMAP_EXT_ITERATION" != 0 ] || cp -a "{whole}" "{self.half}"'
        ended = self.session.run(whole, more=["--on_iteration", hook])
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        self.cpu_s = used.ru_utime + used.ru_stime
        self.half_cpu_s = 0.4 * self.cpu_s  # the second iteration has fewer new photos
        if ended.exit_code != 0:
            sys.exit(f"the undisturbed session failed: {ended.stderr}")
        # Hooks are no part of the comparison.
        for workspace in (whole, self.half):
            ini = workspace / "session.ini"
            ini.write_text(re.sub(r"(?m)^on_iteration = .*$", "on_iteration = ", ini.read_text()))
        self.expected = fingerprint(whole)
        self.check_comparison(whole)
        print(f"undisturbed: {self.cpu_s:.1f} CPU s, {len(self.expected)} files compared",
              file=sys.stderr, flush=True)

    def check_comparison(self, whole):
        """A comparison that cannot fail proves nothing."""
        name = "iterations/001/surface.ply"
        content = bytearray((whole / name).read_bytes())
        content[-1] ^= 1
        (whole / name).write_bytes(content)
        if differences(self.expected, whole) != [name]:
            sys.exit("the comparison does not see a changed bit")

    def note_strike(self, result, ended, exit_codes, workspace):
        self.ended = ended
        result.struck += 1
        said = ended.said if ended.exit_code == 1 else f"exit code {ended.exit_code}"
        result.said[self.shortened(said, workspace)] += 1
        if ended.exit_code not in exit_codes or (
                ended.exit_code == 1 and not ended.said.startswith("colmap_ext active_capture: ")):
            self.problem(f"{result.name}: exit code {ended.exit_code}: {ended.stderr[-2000:]}")
        lost = lost_files(self.expected, workspace)
        result.lost += len(lost)
        return lost

    @staticmethod
    def shortened(said, workspace):
        text = said.removeprefix("colmap_ext active_capture: ").replace(str(workspace), "W")
        text = re.sub(r"process \d+", "process N", text)
        text = re.sub(r"view_\d+", "view_N", text)
        return text.replace("|", "/")

    def go_on(self, result, workspace):
        """The same command without the fault, to the end."""
        ended = self.session.run(workspace)
        result.sessions += 1
        different = differences(self.expected, workspace)
        if ended.exit_code != 0:
            self.problem(f"{result.name}: cannot be gone on with: {ended.stderr[-2000:]}")
        elif different:
            self.problem(f"{result.name}: other result after resume: {different}")
        else:
            result.same += 1
        if ended.exit_code != 0 or different:
            shutil.copytree(workspace, self.work / f"kept_{len(self.problems)}", dirs_exist_ok=True)

    def kill_sessions(self, kills):
        result = self.result("kill -9 at a random moment")
        while result.struck < kills:
            workspace = fresh_copy(None, self.work / "killed")
            for _ in range(min(KILLS_A_SESSION, kills - result.struck)):
                # Each kill comes before the rest of its session is done, as far as one can tell.
                seconds = self.random.uniform(0, 0.6 * self.cpu_s)
                ended = self.session.run_and_signal(workspace, seconds, signal.SIGKILL)
                if ended is None:  # finished before: that session is done
                    break
                lost = self.note_strike(result, ended, (-signal.SIGKILL,), workspace)
                if lost:
                    self.problem(f"{result.name}: lost {lost}")
                self.expect_no_children(workspace)
            self.go_on(result, workspace)
            print(f"{result.struck} of {kills} kills", file=sys.stderr, flush=True)

    def expect_no_children(self, workspace):
        """`colmap` must die with the program that started it."""
        stop = time.monotonic() + 10
        while time.monotonic() < stop:
            found = [process for process in Path("/proc").glob("[0-9]*/cmdline")
                     if str(workspace).encode() in self.content_of_process(process)]
            if not found:
                return
            time.sleep(0.02)
        self.problem(f"still running after kill -9: {found}")

    @staticmethod
    def content_of_process(path):
        try:
            return path.read_bytes()
        except OSError:
            return b""

    def strike(self, fault, workspace, variant):
        """Whether the fault struck; what it broke is healed."""
        result = self.result(fault.name)
        ended = fault.strike(self, str(workspace), variant)
        if ended is not None:
            lost = self.note_strike(result, ended, fault.exit_codes, workspace)
            lost = [name for name in lost if name != getattr(fault, "damaged", None)]
            if lost:
                self.problem(f"{fault.name} {variant}: lost {lost}")
        fault.heal(self, str(workspace))
        return ended is not None

    def run_each(self, count):
        """Every variant of every fault in a session of its own."""
        for fault in self.possible_faults():
            for variant in fault.variants(self.random, count):
                workspace = fresh_copy(self.half, self.work / "struck")
                if self.strike(fault, workspace, variant):
                    self.go_on(self.result(fault.name), workspace)
            print(self.result(fault.name).row(), file=sys.stderr, flush=True)

    def run_together(self):
        """Every fault once, one after the other in one session, which then goes on."""
        workspace = fresh_copy(self.half, self.work / "struck")
        for fault in self.possible_faults():
            struck = self.strike(fault, workspace, fault.variants(self.random, 1)[0])
            print(self.result(fault.name).row(), file=sys.stderr, flush=True)
            if not struck or self.ended.exit_code == 0:  # the session is finished
                self.go_on(self.result(fault.name), workspace)
                workspace = fresh_copy(self.half, self.work / "struck")
        self.go_on(self.result("all of these in one session"), workspace)

    def possible_faults(self):
        for fault in faults.ALL:
            reason = fault.why_not(self)
            if reason:
                self.result(fault.name).said[f"not tried: {reason}"] += 1
            else:
                yield fault

    def table(self):
        head = ["| fault | tried | what the program said (times) | files lost | same result |",
                "|---|---|---|---|---|"]
        return "\n".join(head + [result.row() for result in self.results.values()])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--program", required=True, help="the built colmap_ext")
    parser.add_argument("--kills", type=int, default=20, help="kills at random moments")
    parser.add_argument("--times", type=int, default=6, help="variants of each other fault")
    parser.add_argument("--short", action="store_true",
                        help="two kills, each other fault once, in one session")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--work_path", help="keep everything here (default: a temporary folder)")
    o = parser.parse_args()
    work = o.work_path or tempfile.mkdtemp(prefix="colmap_ext_faults_")
    os.makedirs(work, exist_ok=True)
    campaign = Campaign(o.program, work, o.seed)
    campaign.run_undisturbed()
    campaign.kill_sessions(SHORT_KILLS if o.short else o.kills)
    if o.short:
        campaign.run_together()
    else:
        campaign.run_each(o.times)
    print(campaign.table())
    if campaign.problems:
        print(f"\n{len(campaign.problems)} problems; workspaces kept in {work}:")
        print("\n".join(campaign.problems))
        sys.exit(1)
    if not o.work_path:
        shutil.rmtree(work)


if __name__ == "__main__":
    main()
