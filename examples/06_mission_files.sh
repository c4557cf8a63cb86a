#!/usr/bin/env bash
# A classic flight around a building that nobody has photographed yet, as files for other programs.
#
#   examples/06_mission_files.sh [folder to work in]
set -euo pipefail
work="${1:-$(mktemp -d)}"
mkdir -p "$work"

# 1. Where the world is: metres east, north and up of this place.
echo '{"metric": true, "origin": {"lat": 46.5191, "lon": 6.5668, "height_m": 400}}' >"$work/frame.json"

# 2. Two circles around a building of 20 m x 12 m, 9 m high.
colmap_ext flight_planner --RegionOfInterest.box=-10,-6,0,10,6,9 --frame_path "$work/frame.json" \
  --Pattern.name 2-circles --Pattern.num_views 24 --Pattern.distance_m 12 \
  --views_path "$work/views.json" --output_path "$work/path.json"

# 3. Files for QGroundControl, DJI, Litchi, Google Earth, GIS.
for format in qgc_plan wpl dji_wpml litchi kml geojson json; do
  case "$format" in
    qgc_plan) name=flight.plan ;;
    dji_wpml) name=flight.kmz ;;
    litchi) name=flight.csv ;;
    wpl) name=flight.waypoints ;;
    *) name="flight.$format" ;;
  esac
  colmap_ext mission_exporter --input_path "$work/path.json" --frame_path "$work/frame.json" \
    --format "$format" --output_path "$work/$name"
done

# 4. Every photo is in the plan, and within 100 m of the building.
python3 - "$work/flight.plan" "$work/flight.geojson" <<'PY'
import json, math, sys
items = json.load(open(sys.argv[1]))["mission"]["items"]
waypoints = [item for item in items if item["command"] == 16]
far = max(math.hypot((item["params"][4] - 46.5191) * 111e3, (item["params"][5] - 6.5668) * 76.5e3) for item in waypoints)
features = json.load(open(sys.argv[2]))["features"]
print(f"{len(waypoints)} waypoints, the farthest {far:.0f} m from the origin; {len(features)} features in GeoJSON")
sys.exit(0 if len(waypoints) >= 24 and far < 100 and features else "the plan is not as expected")
PY
ls -l "$work"
