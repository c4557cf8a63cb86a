#!/usr/bin/env python3
"""Flies a simulated drone through the flight daemon's HTTP API (docs/flight_api.md), with the standard
library alone: six photos around the gate, watched event by event, then home.

  examples/04_fly_over_http.py [folder to work in]
"""
import http.client
import json
import math
import pathlib
import socket
import subprocess
import sys
import tempfile
import time

SPEED = 20  # simulated seconds a second
VIEWS = 6


def free_udp_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Daemon:
    """What a program needs of the API: a port, a token, JSON."""

    def __init__(self, workspace):
        address = json.loads((workspace / "flightd.json").read_text())
        self.port, self.token = address["port"], address["token"]

    def call(self, method, path, body=None):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=30)
        headers = {"Authorization": "Bearer " + self.token}
        connection.request(method, "/v1/" + path, json.dumps(body or {}) if method == "POST" else None, headers)
        answer = connection.getresponse()
        content = json.loads(answer.read())
        if answer.status != 200:
            raise SystemExit(f"{path}: {answer.status}: {content['error']}")
        return content

    def events(self):
        """The journal's records, as they are written (server-sent events)."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        connection.request("GET", "/v1/events?since=0", headers={"Authorization": "Bearer " + self.token})
        for line in connection.getresponse():
            if line.startswith(b"data: "):
                yield json.loads(line[6:])


def wait_until(what, is_true, timeout_s=90):
    end = time.monotonic() + timeout_s
    while time.monotonic() < end:
        value = is_true()
        if value:
            return value
        time.sleep(0.2)
    raise SystemExit("waited too long for " + what)


def ring_of_views(home_z_m):
    """Places on a circle around the gate, 24 m from its middle, looking at it."""
    stops = []
    for i in range(VIEWS):
        angle = 2 * math.pi * i / VIEWS
        stops.append({
            "position_enu_m": [24 * math.sin(angle), 24 * math.cos(angle), home_z_m + 20],
            "yaw_deg": (math.degrees(angle) + 180) % 360,
            "pitch_deg": -30,
            "view_id": i,
            "photo": f"view_{i:05d}.jpg",
        })
    return stops


def mission_for(drone):
    home_z_m = drone["home"]["enu_m"][2]
    return {
        "revision": 1,
        "origin": drone["origin"],
        "undulation_m": 0,
        "home_z_m": home_z_m,
        "speed_m_s": 4,
        "safe_distance_m": 5,
        "vouched": True,  # no surface yet: a person says that the straight lines are free
        "transit_z_m": home_z_m + 24,
        "at_end": "return",
        "full_resolution": False,
        "limits": {"min_relative_height_m": 2, "max_relative_height_m": 60, "max_distance_m": 120,
                   "fence_enu_m": [[-70, -70], [70, -70], [70, 70], [-70, 70]]},
        "stops": ring_of_views(home_z_m),
    }


def is_ready(status):
    vehicle = status["vehicle"]
    known = status["state"] not in ("DISCONNECTED", "CONNECTED")
    return known and "home" in vehicle and vehicle.get("estimate_good", False)


def all_stored(status):
    return status if all(view["status"] == "stored" for view in status["views"]) else None


def fly(work, programs):
    port = free_udp_port()
    drone_process = subprocess.Popen(
        ["colmap_ext_dronesim", "--scene", "gate", "--texel_scale", "4", "--speed", str(SPEED),
         "--connection", f"udpout://127.0.0.1:{port}", "--output_path", str(work / "drone"),
         "--Drone.failsafes", "safe", "--Drone.parameters", "RTL_RETURN_ALT=35"],
        stdout=subprocess.PIPE, text=True)
    programs.append(drone_process)
    drone = json.loads(drone_process.stdout.readline())
    print(f"drone: {drone['personality']}, home at {drone['home']['enu_m']}")

    workspace = work / "site"
    workspace.mkdir(parents=True, exist_ok=True)
    programs.append(subprocess.Popen(
        ["colmap_ext_flightd", "--workspace_path", str(workspace), "--log_level", "warning",
         "--connection", f"udpin://127.0.0.1:{port}", "--simulated_speed", str(SPEED), "--picture_url",
         f"http://127.0.0.1:{drone['http_port']}/pictures/{{resolution}}/img_{{index5}}.jpg"]))
    wait_until("the daemon", (workspace / "flightd.json").exists)
    daemon = Daemon(workspace)
    wait_until("the vehicle", lambda: is_ready(daemon.call("GET", "status")))

    daemon.call("POST", "mission", mission_for(drone))
    daemon.call("POST", "start")
    for event in daemon.events():
        if event["type"] == "state":
            print(f"  {event['from']} -> {event['to']}  {event['reason']}")
        elif event["type"] in ("stored", "failed"):
            print(f"  {event['type']} view {event['view']}")
        if event["type"] == "state" and event["to"] == "DISARMED":
            break
    # The last pictures may still be on their way.
    return workspace, wait_until("the pictures", lambda: all_stored(daemon.call("GET", "status")))


def main():
    work = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())
    programs = []
    try:
        workspace, status = fly(work, programs)
    finally:
        for program in reversed(programs):
            program.terminate()
            program.wait(timeout=20)
    photos = sorted(path.name for path in (workspace / "images").glob("*.jpg"))
    records = [json.loads(line) for line in (workspace / "images" / "captures.jsonl").read_text().splitlines()]
    print(f"{len(photos)} photos: {', '.join(photos)}")
    stored = [view for view in status["views"] if view["status"] == "stored"]
    if len(stored) != VIEWS or len(photos) != VIEWS or len(records) < VIEWS:
        raise SystemExit(f"expected {VIEWS} photos: {len(stored)} stored, {len(photos)} files, {len(records)} records")


if __name__ == "__main__":
    main()
